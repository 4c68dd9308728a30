"""test_window_write.py: what the writer writes, leaves at zero, says and refuses."""

from pathlib import Path

import numpy as np
import pytest
from synthetic_bsdf import distribution, lambert_and_mirror, lobe_per_sr, sphere_points, spiral_about

from gonio.dataset.bsdf import Dataset
from gonio.formats import validate
from gonio.formats.window import read as window_reader
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import direction_of_patch_deg, incident_place, process_of, to_radiance_deg
from gonio.formats.window.matrices import BANDS, PROCESSES, SIDES, build
from gonio.units.errors import CheckFailed, UsageError


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return lambert_and_mirror()


@pytest.mark.parametrize("basis", ["klems-full", "klems-half", "klems-quarter"])
def test_written_values_come_back(tmp_path: Path, dataset: Dataset, basis: str) -> None:
    path = tmp_path / "bsdf.xml"
    built = window_xml.write(dataset, path, basis=basis, assume_flat=True)
    back = window_reader.read(path)
    assert back.basis.rings == built.basis.rings
    for band in BANDS:
        for process in PROCESSES:
            for side in SIDES:
                expected = built.bands[band].matrices[process, side]
                np.testing.assert_allclose(back.matrices[band, process, side], expected, rtol=1e-6, atol=1e-12)
    assert back.text["Name"] == dataset.sample_name
    assert back.thickness_mm == pytest.approx(3.0)
    assert not back.findings.items


def test_hemispherical_values_are_those_of_the_sample(dataset: Dataset) -> None:
    built = build(dataset)
    size = built.basis.projected_solid_angle_sr
    block = built.bands["Visible"]
    reflection = size @ block.matrices["Reflection", "Front"]
    for theta in (30.0, 60.0):
        ring = built.basis.ring_of(theta)
        columns = slice(int(built.basis.ring_start[ring]), int(built.basis.ring_start[ring + 1]))
        np.testing.assert_allclose(reflection[columns], 0.7, rtol=5e-3)
    transmission = size @ block.matrices["Transmission", "Front"]
    np.testing.assert_allclose(transmission[transmission > 0], 0.1, rtol=5e-3)
    # The mirror lobe lies on the diagonal in every rotated column.
    for column in range(25, 45):
        assert int(np.argmax(block.matrices["Reflection", "Front"][:, column])) == column


def test_file_is_valid_and_names_what_is_zero(tmp_path: Path, dataset: Dataset) -> None:
    path = tmp_path / "bsdf.xml"
    window_xml.write(dataset, path)
    findings = validate.validate(path)
    assert findings.exit_status == 0, findings.text()
    comments = window_reader.read(path).text["Comments"]
    assert "zeros: Transmission Back, Reflection Back." in comments
    assert "Solar: not measured, all matrices are zeros." in comments
    assert "3 measured, 42 rotated from a measured theta_i (declared isotropic), 0 filled" in comments
    assert "assumed, not measured" in comments


def test_flat_copy_is_recorded(dataset: Dataset) -> None:
    built = build(dataset, assume_flat=True)
    assert built.copied == ("Visible", "Solar")
    for key, matrix in built.bands["Visible"].matrices.items():
        np.testing.assert_array_equal(built.bands["Solar"].matrices[key], matrix)
    assert any("copied from Visible" in line for line in built.remarks())


def test_fill_nearest_fills_every_column_of_the_measured_side(dataset: Dataset) -> None:
    built = build(dataset, fill="nearest")
    size = built.basis.projected_solid_angle_sr
    reflection = size @ built.bands["Visible"].matrices["Reflection", "Front"]
    assert reflection.min() > 0.5
    assert not built.bands["Visible"].matrices["Reflection", "Back"].any()
    assert built.column_counts("Visible", "Reflection", "Front") == (3, 42, 100, 0)
    column = int(built.basis.patch_of(40, 15))  # filled from 30 degrees, turned to its azimuth
    peak = int(np.argmax(built.bands["Visible"].matrices["Reflection", "Front"][:, column]))
    assert abs(built.basis.centres_deg[peak, 1] - 15) <= 9
    assert built.basis.centres_deg[peak, 0] == 30


def test_without_declared_symmetry_only_measured_columns_are_written() -> None:
    plain = lambert_and_mirror()
    plain.symmetry = "undeclared"
    assert build(plain).column_counts("Visible", "Reflection", "Front") == (3, 0, 0, 142)


@pytest.mark.parametrize("front_faces", ["exterior", "interior"])
@pytest.mark.parametrize(
    ("incident", "lobe"),
    [
        ((40.0, 0.0), (40.0, 90.0)),  # front, reflected up
        ((40.0, 90.0), (60.0, 200.0)),  # front, reflected left and down
        ((40.0, 270.0), (120.0, 30.0)),  # front, through
        ((140.0, 15.0), (50.0, 300.0)),  # back, through
        ((120.0, 105.0), (150.0, 72.0)),  # back, reflected
    ],
)
def test_asymmetric_fixture_there_and_back(tmp_path: Path, front_faces, incident, lobe) -> None:  # type: ignore[no-untyped-def]
    units = np.concatenate([sphere_points(2000), spiral_about(*lobe, 5.0, 0.5)])
    part = distribution(incident, units, lambda u: lobe_per_sr(u, lobe, 0.3))
    path = tmp_path / "asymmetric.xml"
    window_xml.write(Dataset([part], front_faces=front_faces), path)
    back = window_reader.read(path)
    held = [key for key, matrix in back.matrices.items() if matrix.max() > 0.1]
    theta_i, phi_i = (float(v) for v in to_radiance_deg(*incident, front_faces))
    theta_o, _ = to_radiance_deg(*lobe, front_faces)
    side, polar, azimuth = incident_place(theta_i, phi_i)
    process = process_of(side, bool(theta_o < 90))
    assert held == [("Visible", process, side)]
    row, column = np.unravel_index(int(np.argmax(back.matrices[held[0]])), (145, 145))
    assert column == int(back.basis.patch_of(polar, azimuth))
    where_i, where_o = direction_of_patch_deg(
        back.basis, process, side, row=int(row), column=int(column), front_faces=front_faces
    )
    assert abs(where_i[0] - incident[0]) <= 5
    assert abs((where_i[1] - incident[1] + 180) % 360 - 180) <= 9
    assert abs(where_o[0] - lobe[0]) <= 5
    assert abs((where_o[1] - lobe[1] + 180) % 360 - 180) <= 9


def test_negative_averages_are_written_as_zero_and_reported() -> None:
    units = sphere_points(3000)
    part = distribution((0.0, 0.0), units, lambda u: np.where(u[:, 0] > 0, 0.3, -0.001) * np.abs(u[:, 2]))
    built = build(Dataset([part], front_faces="interior"))
    block = built.bands["Visible"]
    assert all(matrix.min() >= 0 for matrix in block.matrices.values())
    # A half hemisphere at -0.001 per sr: 0.001 pi / 2, less what the border patches average out.
    assert block.negative_added == pytest.approx(0.001 * np.pi / 2, rel=0.15)
    assert any("negative averages written as 0" in line for line in built.remarks())


def test_energy_over_one_is_refused_with_side_column_and_sum() -> None:
    bright = lambert_and_mirror((60.0,), reflectance=0.9, transmittance=0.2)
    with pytest.raises(CheckFailed, match=r"Visible Front, incident patch .*theta 60.* sum to 1\.\d{4}"):
        build(bright)


def test_energy_over_one_within_uncertainty_is_a_finding() -> None:
    bright = lambert_and_mirror((60.0,), reflectance=0.7, transmittance=0.11)
    for part in bright.distributions:
        part.p_i_u_rel = 0.02
    built = build(bright)
    assert "energy" in built.findings.codes
    assert any("within 2 u" in line for line in built.remarks())


def test_what_is_undeclared_is_refused(dataset: Dataset, tmp_path: Path) -> None:
    unknown = lambert_and_mirror((30.0,))
    unknown.front_faces = "undeclared"
    path = tmp_path / "bsdf.xml"
    path.write_text("old")
    with pytest.raises(UsageError, match="--front"):
        window_xml.write(unknown, path)
    assert path.read_text() == "old"
    window_xml.write(unknown, path, front="interior")
    assert [p.name for p in tmp_path.iterdir()] == ["bsdf.xml"]
    with pytest.raises(UsageError, match="cannot be written"):
        window_xml.write(dataset, tmp_path / "missing" / "bsdf.xml")


def test_channels_are_never_guessed() -> None:
    coloured = lambert_and_mirror((30.0,))
    coloured.distributions[0].channel = "633 nm"
    with pytest.raises(UsageError, match="633 nm"):
        build(coloured)
    built = build(coloured, channel="633 nm", assume_flat=True)
    assert built.channel_of == {"Visible": "633 nm"}
    with pytest.raises(UsageError, match="no channel"):
        build(coloured, channel="red")


def test_points_without_cells_are_refused() -> None:
    raw = lambert_and_mirror((30.0,))
    raw.distributions[0].solid_angle_sr[:] = 0
    with pytest.raises(UsageError, match="cover no solid angle"):
        build(raw)


def test_names_with_markup_and_control_characters_survive(tmp_path: Path) -> None:
    odd = lambert_and_mirror((30.0,))
    odd.sample_name = "A & B <glass>\x07 é"
    path = tmp_path / "bsdf.xml"
    window_xml.write(odd, path)
    assert window_reader.read(path).text["Name"] == "A & B <glass> é"
