"""test_solar.py: the solar spectrum's total, tables of the user; weights; the weighted channel."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Bsdf, MeasuredIntegral
from gonio.formats.solar.spectra import spectrum_named
from gonio.formats.solar.weighted import with_solar
from gonio.formats.solar.weights import bands_of, solar_weights
from gonio.formats.window import from_model as klems_model
from gonio.formats.window.klems import BASES
from gonio.units.errors import UsageError


def test_shares_add_up() -> None:
    spectrum = spectrum_named("astm-g173")
    assert (np.diff(spectrum.edges_nm) > 0).all()
    assert spectrum.between(0.0, 1e5) == pytest.approx(1.0)
    assert spectrum.between(400.0, 500.0) == pytest.approx(
        spectrum.between(400.0, 433.0) + spectrum.between(433.0, 500.0)
    )


def test_the_table_has_the_standards_total() -> None:
    lines = (files("gonio.formats") / "data" / "solar_astm_g173.csv").read_text(encoding="utf-8").splitlines()[2:]
    power = sum(float(line.split(",")[2]) for line in lines)
    assert power == pytest.approx(1000.37, abs=0.05)  # W/m2, 280 to 4000 nm


def test_a_table_of_irradiance_is_integrated_by_trapezia(tmp_path: Path) -> None:
    path = tmp_path / "ours.csv"
    path.write_text("# ours\nirradiance,wavelength_nm\n0,300\n2,400\n2,1400\n0,2400\n", encoding="utf-8")
    spectrum = spectrum_named(str(path))
    assert spectrum.between(0.0, 1e4) == pytest.approx(1.0)
    whole = 100.0 + 2000.0 + 1000.0
    assert spectrum.between(300.0, 350.0) == pytest.approx(25.0 / whole)  # half of 1 at 350 nm, 50 nm wide
    assert spectrum.between(350.0, 500.0) == pytest.approx((75.0 + 200.0) / whole)
    assert spectrum.between(1900.0, 2400.0) == pytest.approx(250.0 / whole)
    assert "the table ours.csv" in solar_weights(str(path), {"all": (300.0, 2400.0)}).sentence()


def test_a_table_of_shares_stands_for_the_nearest_wavelengths(tmp_path: Path) -> None:
    path = tmp_path / "shares.csv"
    path.write_text("wavelength_nm,share\n400,0.1\n500,0.2\n700,0.1\n", encoding="utf-8")
    spectrum = spectrum_named(str(path))
    assert spectrum.between(400.0, 450.0) == pytest.approx(0.25)
    assert spectrum.between(450.0, 600.0) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wavelength,irradiance\n1,2\n", "must name wavelength_nm"),
        ("wavelength_nm,irradiance,share\n1,2,3\n", "irradiance or share"),
        ("wavelength_nm,share\n400,0.1\n", "two values or more"),
        ("wavelength_nm,share\n400,0.1\n300,0.2\n", "rising"),
        ("wavelength_nm,share\n400,0.1\n500,-0.2\n", "must not be negative"),
        ("wavelength_nm,share\n400,0\n500,0\n", "not zero everywhere"),
        ("wavelength_nm,share\n400,nan\n500,1\n", "no number"),
        ("wavelength_nm,share\n400\n500,1\n", "line 2"),
        ("", "must name wavelength_nm"),
        (None, "cannot be read"),
    ],
)
def test_tables_that_do_not_do_are_refused_in_one_line(tmp_path: Path, text: str | None, words: str) -> None:
    path = tmp_path / "x.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(UsageError, match=words) as error:
        spectrum_named(str(path))
    assert "\n" not in str(error.value)


def coating(diffuse: float) -> RetroCoating:
    return RetroCoating(diffuse, 20.0, 4.0, 0.0)


def sample(**bands: tuple[float, float]) -> Bsdf:
    channels = {name: coating(0.1 * (k + 1)) for k, name in enumerate(bands or {"visible": 0, "nir": 0})}
    return Bsdf(dict(channels), front_faces="interior", symmetry="isotropic", band_nm=bands)


def test_weights_are_shares_of_what_is_covered() -> None:
    found = solar_weights("astm-g173", {"nir": (780.0, 2500.0), "visible": (380.0, 780.0)})
    table = spectrum_named("astm-g173")
    visible, nir = table.between(380, 780), table.between(780, 2500)
    assert found.weight["visible"] == pytest.approx(visible / (visible + nir))
    assert sum(found.weight.values()) == pytest.approx(1.0)
    assert found.uncovered == pytest.approx(1.0 - visible - nir)
    assert 0.03 < found.uncovered < 0.06
    assert f"{100 * found.uncovered:.1f} % of the spectrum lies in no channel's band" in found.sentence()


@pytest.mark.parametrize(
    ("bands", "words"),
    [
        ({}, "--solar-band CHANNEL=FROM-TO"),
        ({"a": (400.0, 700.0), "b": (650.0, 900.0)}, "a and b overlap"),
        ({"a": (700.0, 400.0), "b": (700.0, 900.0)}, "is empty"),
        ({"visible": (380.0, 780.0)}, "--assume-flat"),
        ({"far": (5000.0, 9000.0)}, "holds any"),
    ],
)
def test_bands_that_do_not_do_are_refused(bands: dict[str, tuple[float, float]], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        solar_weights("astm-g173", bands)
    with pytest.raises(UsageError, match="give astm-g173, or a FILE"):
        solar_weights("noon", bands)


def test_bands_come_from_the_user_then_the_file_then_the_name() -> None:
    bsdf = sample(visible=(400.0, 700.0), nir=(900.0, 900.0))
    bsdf.channels |= {"1100-2500 nm": coating(0.1), "633 nm": coating(0.1)}
    assert bands_of(bsdf, {"633 nm": (700.0, 780.0)}) == {
        "visible": (400.0, 700.0),
        "nir": (780.0, 2500.0),
        "1100-2500 nm": (1100.0, 2500.0),
        "633 nm": (700.0, 780.0),
    }
    with pytest.raises(UsageError, match="no channel 'red'"):
        bands_of(bsdf, {"red": (600.0, 700.0)})


def test_the_solar_channel_is_the_weighted_mean() -> None:
    bsdf = sample()
    bsdf.measured = (
        MeasuredIntegral("visible", 30.0, 0.0, True, 0.5, 0.01),
        MeasuredIntegral("nir", 30.0, 0.0, True, 0.7, 0.01),
        MeasuredIntegral("nir", 60.0, 0.0, True, 0.6, 0.01),
    )
    found, weights = with_solar(bsdf, "astm-g173")
    rng = np.random.default_rng(4)
    unit = rng.normal(size=(50, 3))
    unit[:, 2] = np.abs(unit[:, 2])
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    expected = sum(w * bsdf.channels[name].dsf_per_sr(unit[:1], unit) for name, w in weights.weight.items())
    np.testing.assert_allclose(found.channels["solar"].dsf_per_sr(unit[:1], unit), expected, rtol=1e-14)
    (solar,) = [m for m in found.measured if m.channel == "solar"]
    assert solar.value == pytest.approx(0.5 * weights.weight["visible"] + 0.7 * weights.weight["nir"])
    assert solar.u == pytest.approx(0.01)  # what channels share does not average out
    with pytest.raises(UsageError, match="solar already"):
        with_solar(found, "astm-g173")


def test_the_solar_matrices_are_the_weighted_mean_of_the_channels() -> None:
    bsdf, weights = with_solar(sample(), "astm-g173")
    channels = klems_model.channels_of(bsdf)
    assert channels == {"Visible": "visible", "Solar": "solar"}
    basis = BASES["klems-quarter"]
    made = klems_model.build(bsdf, klems_model.ModelFile(channels, notes=(weights.sentence(),)), basis=basis)
    size = basis.projected_solid_angle_sr
    near_infrared = klems_model.build(bsdf, klems_model.ModelFile({"Visible": "nir"}), basis=basis)
    key = ("Reflection", "Back")
    parts = {"visible": made.bands["Visible"], "nir": near_infrared.bands["Visible"]}
    expected = sum(weights.weight[name] * block.matrices[key] for name, block in parts.items())  # type: ignore[index]
    np.testing.assert_allclose(made.bands["Solar"].matrices[key], expected, rtol=1e-12)  # type: ignore[index]
    visible, solar = (float((size @ made.bands[b].matrices[key])[0]) for b in ("Visible", "Solar"))  # type: ignore[index]
    assert solar - visible == pytest.approx(0.1 * weights.weight["nir"], rel=1e-3)
    assert any("ASTM G173-03" in line for line in made.remarks())
