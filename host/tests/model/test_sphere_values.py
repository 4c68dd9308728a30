"""test_sphere_values.py: integrating-sphere tables: reading, bands, openness, stacks, and models tied to them."""

from pathlib import Path

import numpy as np
import pytest
from analytic_cases import dataset, integral_by_scipy, measured
from hypothesis import given, settings
from hypothesis import strategies as st

from gonio.model.analytic import AnalyticScattering, Component, fit_family
from gonio.model.sphere_values import Band, read_sphere, stack, threads_from_stacks
from gonio.units.errors import UsageError

HEAD = "wavelength_nm,theta_i_deg,layers,tau_total,tau_diffuse,rho_total,rho_diffuse,u\n"
# A shade in the manner of paper [2], figures 3 to 5: direct part 0.055 at all wavelengths, rho falling, tau rising.
SHADE = HEAD + "".join(
    f"{nm},{theta},{layers},{tau},{diffuse},{rho},{rho},0.004\n"
    for nm, theta, layers, tau, diffuse, rho in (
        (400, 0, 1, 0.100, 0.045, 0.50, ),
        (633, 0, 1, 0.125, 0.070, 0.46, ),
        (800, 0, 1, 0.140, 0.085, 0.44, ),
        (633, 0, 2, 0.025, 0.020, 0.478,),
        (633, 0, 3, 0.006, 0.006, 0.479,),
        (633, 60, 1, 0.080, 0.060, 0.49,),
    )
)  # fmt: skip


def table(folder: Path, text: str) -> Path:
    path = folder / "sphere.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_values_at_a_wavelength(tmp_path: Path) -> None:
    sphere = read_sphere(table(tmp_path, "# instrument: a sphere\n" + SHADE))
    at = Band.at(633.0)
    rows = sphere.rows("tau_total", at)
    assert [(r.theta_i_deg, r.value, r.u) for r in rows] == [(0.0, 0.125, 0.004), (60.0, 0.080, 0.004)]
    assert sphere.rows("rho_total", at, layers=3)[0].value == 0.479
    assert sphere.rows("rho_total", at, side="back") == ()
    assert sphere.openness(at) == pytest.approx(0.055)
    assert sphere.by_layers("tau_total", at) == {1: 0.125, 2: 0.025, 3: 0.006}


def test_band_means(tmp_path: Path) -> None:
    """Flat: trapezoids by hand. Weighted: a fine sum over the same broken lines."""
    sphere = read_sphere(table(tmp_path, "wavelength_nm,tau_total\n300,0.1\n500,0.3\n800,0.0\n900,0.2\n"))
    flat = sphere.rows("tau_total", Band.flat(400.0, 800.0))[0].value
    assert flat == pytest.approx(((0.2 + 0.3) / 2 * 100 + (0.3 + 0.0) / 2 * 300) / 400)
    visible = Band.visible()
    assert visible.weight_nm is not None
    assert visible.weight is not None

    nm = np.linspace(380.0, 780.0, 400_001)
    eye = np.interp(nm, visible.weight_nm, visible.weight)
    truth = float(np.interp(nm, [300, 500, 800, 900], [0.1, 0.3, 0.0, 0.2]) @ eye) / float(eye.sum())
    assert sphere.rows("tau_total", visible)[0].value == pytest.approx(truth, rel=1e-5)
    assert np.isnan(sphere.rows("tau_total", visible)[0].u)
    with pytest.raises(UsageError, match=r"300 to 900 nm"):
        sphere.rows("tau_total", Band.flat(780.0, 2500.0))


def test_the_eyes_curve() -> None:
    """CIE 1931 y at a few wavelengths: 0.0380, 0.323, 0.995 (550), 0.631 (600), 0.107 (650) within the fit's 0.01."""
    band = Band.visible()
    assert band.weight_nm is not None
    assert band.weight is not None
    known = {450.0: 0.0380, 500.0: 0.3230, 550.0: 0.9950, 600.0: 0.6310, 650.0: 0.1070}
    for nm, y in known.items():
        assert float(np.interp(nm, band.weight_nm, band.weight)) == pytest.approx(y, abs=0.012)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("wavelength_nm,tau\n500,0.1\n", "'tau' is not known"),
        ("theta_i_deg,tau_total\n0,0.1\n", "needs the column wavelength_nm"),
        ("wavelength_nm,theta_i_deg\n500,0\n", "one of tau_total"),
        (HEAD, "no values"),
        ("wavelength_nm,tau_total\n500,12.5\n", "line 2: tau_total 12.5 .* percent"),
        ("wavelength_nm,tau_total\n500,abc\n", "line 2: tau_total 'abc' is no number"),
        ("wavelength_nm,tau_total\n500,nan\n", "line 2: tau_total nan"),
        ("wavelength_nm,tau_total\n500,0.1\n500,0.2\n", "line 3 repeats 500 nm"),
        ("wavelength_nm,tau_total\n500\n", "line 2 has 1 cells"),
        ("wavelength_nm,layers,tau_total\n500,4,0.1\n", "layers 4"),
        ("wavelength_nm,theta_i_deg,tau_total\n500,95,0.1\n", "theta_i_deg 95"),
        ("wavelength_nm,side,tau_total\n500,top,0.1\n", "side 'top'"),
        ("wavelength_nm,tau_total\n,0.1\n", "wavelength_nm is missing"),
        ("wavelength_nm,tau_total,u\n500,0.1,-1\n", "u is not"),
    ],
)
def test_one_line_errors(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        read_sphere(table(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        read_sphere(tmp_path / "none.csv")


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(b"wavelength_nm,tau_total\n500,0.1\n" + content)
    said = ""
    try:
        said = read_sphere(path).name
    except UsageError as error:
        said = str(error)
    assert said
    assert "\n" not in said


def rays(rho: float, tau: float, layers: int) -> tuple[float, float]:
    """Light between layers followed as a linear system: down- and upward flux at each gap (Kubelka's bookkeeping)."""
    matrix, right = np.eye(2 * layers + 2), np.zeros(2 * layers + 2)  # down 0..n, up 0..n
    right[0] = 1.0
    down, up = np.arange(layers + 1), np.arange(layers + 1) + layers + 1
    for n in range(layers):
        matrix[down[n + 1], down[n]] -= tau
        matrix[down[n + 1], up[n + 1]] -= rho
        matrix[up[n], down[n]] -= rho
        matrix[up[n], up[n + 1]] -= tau
    flux = np.linalg.solve(matrix, right)
    return float(flux[up[0]]), float(flux[down[layers]])


@pytest.mark.parametrize("layers", [1, 2, 3])
@pytest.mark.parametrize(("rho", "tau"), [(0.46, 0.125), (0.9, 0.1), (0.0, 0.3)])
def test_stack_by_linear_system(rho: float, tau: float, layers: int) -> None:
    assert stack(rho, tau, layers) == pytest.approx(rays(rho, tau, layers), abs=1e-12)


@pytest.mark.parametrize(("r", "t", "openness"), [(0.5, 0.0, 0.05), (0.48, 0.08, 0.055), (0.8, 0.15, 0.2)])
def test_threads_are_recovered(r: float, t: float, openness: float) -> None:
    cover = 1 - openness
    found = [rays(cover * r, openness + cover * t, n) for n in (1, 2, 3)]
    threads = threads_from_stacks(
        {n + 1: rho for n, (rho, _) in enumerate(found)}, {n + 1: tau for n, (_, tau) in enumerate(found)}, openness
    )
    assert threads.reflectance == pytest.approx(r, abs=1e-6)
    assert threads.transmittance == pytest.approx(t, abs=1e-6)
    assert threads.residual < 1e-6
    assert threads.folded == found[2][0]


def test_threads_of_the_shade(tmp_path: Path) -> None:
    """Folding converges at the second layer, to slightly less than the threads' reflectance, as paper [2] expects."""
    sphere = read_sphere(table(tmp_path, SHADE))
    at = Band.at(633.0)
    threads = threads_from_stacks(
        sphere.by_layers("rho_total", at), sphere.by_layers("tau_total", at), sphere.openness(at)
    )
    assert threads.converged
    assert threads.folded == 0.479
    assert threads.reflectance == pytest.approx(0.49, abs=0.015)
    assert threads.residual < 0.02
    with pytest.raises(UsageError, match="of one layer"):
        threads_from_stacks({2: 0.4}, {}, 0.05)
    with pytest.raises(UsageError, match="openness"):
        threads_from_stacks({1: 0.4}, {}, -0.1)


def test_openness_needs_both_parts(tmp_path: Path) -> None:
    sphere = read_sphere(table(tmp_path, "wavelength_nm,theta_i_deg,tau_total\n633,0,0.1\n"))
    with pytest.raises(UsageError, match="openness"):
        sphere.openness(Band.at(633.0))


def shade_points() -> tuple[Component, Component]:
    return (
        Component.of("lambertian", "reflection", share=0.5),
        Component.of("abg", "transmission", A=0.004, B=0.002, g=1.9),
    )


@pytest.mark.parametrize(
    ("tie", "expected"), [("total", {0.0: 0.125, 60.0: 0.080}), ("diffuse", {0.0: 0.070, 60.0: 0.060})]
)
def test_models_are_tied_to_the_sphere(tmp_path: Path, tie: str, expected: dict[float, float]) -> None:
    """The exact integral of the fitted model, by scipy, is the sphere's value at its angles; the points' own values,
    which differ, are kept as measured integrals beside."""
    reflection, transmission = shade_points()
    data = dataset(*[measured({True: reflection, False: transmission}, t, n=1200) for t in (0.0, 20.0, 45.0)])
    for d in data.distributions:
        d.wavelength_nm = 633.0
    sphere = read_sphere(table(tmp_path, SHADE))
    found = fit_family(data, "abg", sphere=sphere, sphere_tie=tie)  # type: ignore[arg-type]
    s = found.channels["visible"]
    assert isinstance(s, AnalyticScattering)
    through = s.components[True, False]
    for theta, value in expected.items():
        assert integral_by_scipy(through, theta) == pytest.approx(value, rel=1e-5)
    record = found.provenance["model"]["channels"]["visible"]["components"]["front transmission"]
    assert "sphere.csv at 0, 60 degrees" in record["tie"]["source"]
    sphere_said = found.provenance["model"]["channels"]["visible"]["sphere"]
    assert sphere_said["openness"] == pytest.approx(0.055)
    assert sphere_said["threads"]["converged"] is True
    stated = [m.value for m in found.measured if not m.reflection and m.incident_theta_deg == 0.0]
    assert expected[0.0] in stated
    assert float(transmission.integral(np.zeros(1))[0]) in stated


def test_one_angle_keeps_the_points_dependence(tmp_path: Path) -> None:
    """A sphere at normal incidence alone sets the level; the course with theta is the goniometer's."""
    _, transmission = shade_points()
    data = dataset(*[measured({False: transmission}, t, n=1200) for t in (0.0, 40.0)])
    own = transmission.integral(np.array([0.0, 40.0]))
    sphere = read_sphere(table(tmp_path, "wavelength_nm,tau_total\n380,0.125\n780,0.125\n"))
    s = fit_family(data, "abg", sphere=sphere).channels["visible"]
    assert isinstance(s, AnalyticScattering)
    at = s.components[True, False].integral(np.array([0.0, 40.0]))
    assert at[0] == pytest.approx(0.125, rel=1e-9)
    assert at[1] == pytest.approx(0.125 * own[1] / own[0], rel=1e-6)


def test_band_of_a_channel_must_be_known(tmp_path: Path) -> None:
    reflection, _ = shade_points()
    data = dataset(measured({True: reflection}, 20.0, n=400, channel="red"))
    sphere = read_sphere(table(tmp_path, "wavelength_nm,rho_total\n600,0.4\n700,0.6\n"))
    with pytest.raises(UsageError, match="--sphere-band"):
        fit_family(data, "lambertian", sphere=sphere)
    s = fit_family(data, "lambertian", sphere=sphere, band=Band.flat(600.0, 700.0)).channels["red"]
    assert isinstance(s, AnalyticScattering)
    assert s.components[True, True].integral(np.array([20.0]))[0] == pytest.approx(0.5)
