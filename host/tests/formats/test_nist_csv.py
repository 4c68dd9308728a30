"""test_nist_csv.py: the published PTFE data: values, angles and which side is the mirror side."""

from pathlib import Path

import numpy as np
import pytest

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.formats import validate
from gonio.formats.tables import nist as nist_csv
from gonio.formats.window import read as window_reader
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import BASES
from gonio.formats.window.patch_average import hemisphere_profile
from gonio.reduce.imported import reduce_dataset
from gonio.units.errors import UsageError

TABLE = Path(__file__).parents[3] / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"
HEADER = "lambda,thetai,phi,thetar,phir,f_r11\n"


@pytest.fixture(scope="module")
def distributions() -> list[Distribution]:
    return nist_csv.read(TABLE).distributions


def test_directions_and_point_counts(distributions: list[Distribution]) -> None:
    counts = {0.001: 304, 15.0: 303, 30.0: 304, 45.0: 304, 60.0: 304, 75.0: 305}
    found = {(d.wavelength_nm, d.incident_theta_deg): len(d.theta_deg) for d in distributions}
    assert found == {(w, t): n for w in (351.0, 532.0, 633.0, 1064.0) for t, n in counts.items()}
    assert {d.incident_phi_deg for d in distributions} == {180.0}
    assert {d.channel for d in distributions} == {"351 nm", "532 nm", "633 nm", "1064 nm"}


@pytest.mark.parametrize(("wavelength", "value"), [(351.0, 0.984), (532.0, 0.998), (633.0, 0.997), (1064.0, 0.992)])
def test_zero_forty_five(distributions: list[Distribution], wavelength: float, value: float) -> None:
    d = next(d for d in distributions if d.wavelength_nm == wavelength and d.incident_theta_deg < 1)
    near = np.abs(d.theta_deg - 45) <= 2
    bsdf = d.dsf_per_sr[near] / np.cos(np.radians(d.theta_deg[near]))
    assert round(float(np.pi * bsdf.mean()), 3) == value


def test_azimuth_zero_is_the_mirror_side(distributions: list[Distribution]) -> None:
    """The lobe towards grazing lies opposite the source; where the detector would shade it there is no point."""
    steep = next(d for d in distributions if d.wavelength_nm == 633.0 and d.incident_theta_deg == 75)
    bsdf = steep.dsf_per_sr / np.cos(np.radians(steep.theta_deg))
    towards_mirror = np.cos(np.radians(steep.phi_deg - (steep.incident_phi_deg + 180)))
    low = steep.theta_deg > 60
    assert bsdf[low & (towards_mirror > 0.9)].mean() > 1.5 * bsdf[low & (towards_mirror < -0.9)].mean()
    for d in distributions:
        if d.incident_theta_deg in (30.0, 45.0):
            retro_side = np.abs(d.phi_deg - d.incident_phi_deg) < 0.01
            assert np.abs(d.theta_deg[retro_side] - d.incident_theta_deg).min() > 4


def test_hemispherical_reflectance_is_physical(distributions: list[Distribution]) -> None:
    """PTFE of this kind reflects 0.97 to 0.99 of normal incidence; nothing exceeds 1."""
    basis = BASES["klems-full"]
    for d in distributions:
        profile = hemisphere_profile(basis, d, d.theta_deg, d.phi_deg)
        assert profile is not None
        rho = float(profile.patches().bsdf_per_sr @ basis.projected_solid_angle_sr)
        assert 0.965 < rho < 1.0, (d.channel, d.incident_theta_deg)
        assert 80 < profile.outermost_deg < 83


def test_it_becomes_a_window_file(tmp_path: Path) -> None:
    dataset = reduce_dataset(nist_csv.read(TABLE))
    path = tmp_path / "ptfe.xml"
    window_xml.write(dataset, path, channel="633 nm", front="interior", fill="nearest", assume_flat=True)
    findings = validate.validate(path)
    assert findings.exit_status == 0, findings.text()
    content = window_reader.read(path)
    # The front faces the interior: light that falls on it arrives from WINDOW's back.
    rho = content.hemispherical("Visible", "Reflection", "Back")
    assert rho.min() > 0.97
    assert rho.max() < 1.0
    assert not content.matrices["Visible", "Transmission", "Back"].any()
    assert "Visible holds channel 633 nm" in content.text["Comments"]
    assert "measured up to 81.9 degrees from the normal" in content.text["Comments"]


def test_rounding_is_the_stated_variance(distributions: list[Distribution]) -> None:
    d = distributions[0]
    cosine = np.cos(np.radians(d.theta_deg))
    np.testing.assert_allclose(np.sqrt(12 * d.variance_per_sr2) / cosine, 0.001, rtol=1e-9)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no column lambda"),
        (b"a,b,c\n1,2,3\n", "no NIST BRDF table"),
        (b"\xff\xfe\x00", "not readable"),
        ((HEADER + "0.633,-30,0,20,180,3.1E-01\n0.633,-30,0,20").encode(), "line 3"),
        (HEADER.encode(), "empty"),
        ((HEADER + "0.633,-30,0,900,180,3.1E-01\n").encode(), "impossible"),
        ((HEADER + "0.633,-30,0,20,180,nan\n").encode(), "impossible"),
    ],
)
def test_foreign_and_cut_off_tables_are_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=words):
        nist_csv.read(path)


def test_the_published_table_comes_back_to_its_digits(tmp_path: Path) -> None:
    path = tmp_path / "again.csv"
    assert nist_csv.write(nist_csv.read(TABLE), path) == (7296, 0)
    published = [",".join(line.split(",")[:6]) for line in TABLE.read_text().splitlines()]
    assert path.read_text().splitlines() == published


def test_only_reflection_at_a_wavelength_is_written(tmp_path: Path) -> None:
    source, path = tmp_path / "t.csv", tmp_path / "again.csv"
    rows = "0.633,-30,0,20,180,3.1E-01\n0.633,-30,0,160,0,1.25E-05\n0.633,-30,0,90,0,1.00E-05\n"
    source.write_text(HEADER + rows)
    dataset = nist_csv.read(source)
    assert nist_csv.write(dataset, path) == (1, 2)
    assert path.read_text() == HEADER + "0.633,-30,0,20,180,3.10E-01\n"
    with pytest.raises(UsageError, match="no channel 'red'"):
        nist_csv.write(dataset, path, channel="red")
    dataset.distributions[0].flags[:] = PointFlag.SHADOWED
    with pytest.raises(UsageError, match="no point in reflection"):
        nist_csv.write(dataset, path)
    dataset.distributions[0].wavelength_nm = None
    with pytest.raises(UsageError, match="states no wavelength"):
        nist_csv.write(dataset, path)
    dataset.distributions[0].p_i = np.nan
    with pytest.raises(UsageError, match="not normalised"):
        nist_csv.write(dataset, path)
