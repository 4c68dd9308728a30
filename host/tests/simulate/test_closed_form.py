"""test_closed_form.py: closed forms against numbers of the conventions page, energy balance and brute force."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.geometry.directions import tangent_frame, unit_from_angles_deg
from gonio.simulate.closed_form import Truth
from gonio.units.errors import UsageError


def truth(tmp_path: Path, components: str, *, divergence_deg: float = 1.0, edge_deg: float = 0.1) -> Truth:
    path = tmp_path / "s.toml"
    beam = f'[beam]\nkind = "focused"\ndivergence_deg = {divergence_deg}\nedge_deg = {edge_deg}\n'
    path.write_text(f"[sample]\ncomponents = [{components}]\n{beam}")
    return Truth.from_scenario(path)


@pytest.mark.parametrize(("divergence_deg", "lowered_percent"), [(0.56, 1.4), (1.0, 4.2), (1.5, 9.2), (3.0, 31.0)])
def test_a_top_hat_lowers_a_peak_as_the_conventions_say(
    tmp_path: Path, divergence_deg: float, lowered_percent: float
) -> None:
    """The figures there are for the top hat alone; the aperture of 0.56 degrees lowers the rest by 1.4 % more."""
    t = truth(
        tmp_path,
        '{kind="gaussian", about="mirror", sigma_deg=1.2, integral=0.2}',
        divergence_deg=divergence_deg,
        edge_deg=0.0,
    )
    top = unit_from_angles_deg([30.0], [180.0])
    kept = t.dsf_per_sr(30.0, 0.0, top) / t.dsf_per_sr(30.0, 0.0, top, convolved=False)
    assert 100.0 * (1.0 - kept[0] / (1.0 - 0.0136)) == pytest.approx(lowered_percent, rel=0.03, abs=0.1)


def test_convolution_against_brute_force(tmp_path: Path) -> None:
    """Random pairs of aperture point and beam direction, the beam's profile by rejection."""
    components = (
        '{kind="gaussian", about="mirror", sigma_deg=1.2, integral=0.2}, '
        '{kind="lambertian", reflectance=0.3, transmittance=0.1}'
    )
    t = truth(tmp_path, components, edge_deg=0.4)
    rng = np.random.default_rng(4)
    n = 200_000

    def disc(radius_rad: float, profile_edge: float) -> NDArray[np.float64]:
        reach = radius_rad + 0.5 * profile_edge
        xy = rng.uniform(-reach, reach, (8 * n, 2))
        r = np.hypot(xy[:, 0], xy[:, 1])
        ramp = np.clip((radius_rad - r) / profile_edge + 0.5, 0, 1) if profile_edge else (r <= radius_rad)
        keep = rng.random(8 * n) < 0.5 * (1 - np.cos(np.pi * np.asarray(ramp, dtype=float)))
        return np.asarray(xy[keep][:n])

    for theta, phi in [(30.0, 180.0), (31.5, 181.0), (89.8, 20.0), (90.3, 20.0)]:
        centre = unit_from_angles_deg(theta, phi)
        e1, e2, _ = tangent_frame(centre)
        offset = disc(np.arctan(5.0 / 1020.0), 0.0) + disc(np.radians(0.5), np.radians(0.4))
        v = centre + offset[:, :1] * e1 + offset[:, 1:] * e2
        v /= np.linalg.norm(v, axis=1)[:, None]
        values = t.dsf_per_sr(30.0, 0.0, v, convolved=False)
        expected, error = values.mean(), values.std() / np.sqrt(n)
        assert t.dsf_per_sr(30.0, 0.0, centre[None])[0] == pytest.approx(expected, abs=5 * error + 2e-4 * expected)


@pytest.mark.parametrize("kind", ["gaussian", "straight-through", "lambertian"])
def test_convolution_keeps_the_energy(tmp_path: Path, kind: str) -> None:
    parts = {
        "gaussian": '{kind="gaussian", about="through", sigma_deg=2.0, integral=0.4}',
        "straight-through": '{kind="straight-through", transmittance=0.4}',
        "lambertian": '{kind="lambertian", transmittance=0.4}',
    }
    t = truth(tmp_path, parts[kind], edge_deg=0.3)
    reach = np.pi if kind == "lambertian" else np.radians(25.0)
    angle = reach * (np.arange(50_000) + 0.5) / 50_000
    ring = t.dsf_per_sr(0.0, 0.0, unit_from_angles_deg(180.0 - np.degrees(angle), 0.0))
    assert np.sum(reach / 50_000 * 2.0 * np.pi * np.sin(angle) * ring) == pytest.approx(0.4, rel=1e-4)
    assert t.integrals(0.0, 0.0) == {"rho": pytest.approx(0.0, abs=1e-9), "tau": pytest.approx(0.4, rel=1e-9)}


def test_beam_has_unit_integral(tmp_path: Path) -> None:
    t = truth(tmp_path, '{kind="lambertian", reflectance=1.0}')
    angle_deg = np.linspace(0.5e-4, 2.0 - 0.5e-4, 20_000)
    ring = 2.0 * np.pi * np.sin(np.radians(angle_deg)) * np.radians(1e-4)
    assert np.sum(ring * t.beam_per_sr(angle_deg)) == pytest.approx(1.0, rel=3e-4)


def test_a_lobe_on_the_horizon_is_half_reflected(tmp_path: Path) -> None:
    t = truth(tmp_path, '{kind="gaussian", about="mirror", sigma_deg=3.0, integral=0.2}')
    found = t.integrals(90.0, 0.0)
    assert found["rho"] == pytest.approx(0.1, rel=1e-6)
    assert found["tau"] == pytest.approx(0.1, rel=1e-6)


def test_incidence_from_behind_turns_the_sides_round(tmp_path: Path) -> None:
    t = truth(tmp_path, '{kind="lambertian", reflectance=0.5, transmittance=0.2}')
    up, down = t.dsf_per_sr(150.0, 0.0, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), convolved=False)
    assert up == pytest.approx(0.2 / np.pi)
    assert down == pytest.approx(0.5 / np.pi)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[sample\n", "cannot read the scenario"),
        ('[sample]\ncomponents = [{kind="mirror"}]', "kind = 'mirror'"),
        ('[sample]\ncomponents = [{kind="lambertian", albedo=1.0}]', "albedo is unknown"),
        ('[sample]\ncomponents = [{kind="gaussian", sigma_deg=1.0}]', "about must be"),
    ],
)
def test_a_wrong_scenario_is_one_sentence(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(UsageError, match=problem):
        Truth.from_scenario(tmp_path / "s.toml")
