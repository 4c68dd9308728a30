"""test_solar.py: solar spectra against each other and the standards' totals; weights; the weighted channel."""

from importlib.resources import files

import numpy as np
import pytest

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Bsdf, MeasuredIntegral
from gonio.formats import klems_model
from gonio.formats.klems import BASES
from gonio.formats.solar.spectra import SPECTRA, spectrum_named
from gonio.formats.solar.weighted import with_solar
from gonio.formats.solar.weights import bands_of, solar_weights
from gonio.units.errors import UsageError


@pytest.mark.parametrize("name", SPECTRA)
def test_shares_add_up(name: str) -> None:
    spectrum = spectrum_named(name)
    assert spectrum.share.sum() == pytest.approx(1.0, abs=1e-12)
    assert (np.diff(spectrum.edges_nm) > 0).all()
    assert spectrum.between(0.0, 1e5) == pytest.approx(1.0)
    assert spectrum.between(400.0, 500.0) == pytest.approx(
        spectrum.between(400.0, 433.0) + spectrum.between(433.0, 500.0)
    )


def test_tables_have_the_standards_totals() -> None:
    folder = files("gonio.formats") / "data"
    lines = (folder / "solar_astm_g173.csv").read_text(encoding="utf-8").splitlines()[2:]
    power = sum(float(line.split(",")[2]) for line in lines)
    assert power == pytest.approx(1000.37, abs=0.05)  # W/m2, 280 to 4000 nm
    lines = (folder / "solar_iso_9050.csv").read_text(encoding="utf-8").splitlines()[2:]
    assert sum(float(line.split(",")[1]) for line in lines) == pytest.approx(1.0, abs=2e-6)


@pytest.mark.parametrize(
    ("band", "tolerance"),
    [
        ((300, 400), 0.01),
        ((400, 500), 0.02),
        ((500, 600), 0.02),
        ((600, 700), 0.02),
        ((700, 800), 0.02),
        ((800, 1000), 0.06),
        ((1000, 1300), 0.05),
        ((1300, 1800), 0.08),
        ((1800, 2500), 0.12),
        ((380, 780), 0.01),
    ],
)
def test_both_spectra_agree_band_by_band(band: tuple[float, float], tolerance: float) -> None:
    """Both are global radiation at air mass 1.5; the older one has coarser absorption bands."""
    g173, iso = spectrum_named("astm-g173"), spectrum_named("iso-9050")
    ours = g173.between(*band) / g173.between(300.0, 2500.0)
    assert iso.between(*band) == pytest.approx(ours, rel=tolerance)


def coating(diffuse: float) -> RetroCoating:
    return RetroCoating(diffuse, 20.0, 4.0, 0.0)


def sample(**bands: tuple[float, float]) -> Bsdf:
    channels = {name: coating(0.1 * (k + 1)) for k, name in enumerate(bands or {"visible": 0, "nir": 0})}
    return Bsdf(dict(channels), front_faces="interior", symmetry="isotropic", band_nm=bands)


def test_weights_are_shares_of_what_is_covered() -> None:
    found = solar_weights("iso-9050", {"nir": (780.0, 2500.0), "visible": (380.0, 780.0)})
    table = spectrum_named("iso-9050")
    visible, nir = table.between(380, 780), table.between(780, 2500)
    assert found.weight["visible"] == pytest.approx(visible / (visible + nir))
    assert sum(found.weight.values()) == pytest.approx(1.0)
    assert found.uncovered == pytest.approx(table.between(300, 380))
    assert 0.02 < found.uncovered < 0.04
    assert "3.1 % of the spectrum lies in no channel's band" in found.sentence()


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
    with pytest.raises(UsageError, match="choose one of astm-g173, iso-9050"):
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
    found, weights = with_solar(bsdf, "iso-9050")
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
        with_solar(found, "iso-9050")


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
