"""test_klems_model.py: matrices of a model: energy, origin of cells, bands, colour, and independent readers."""

import csv
import io
import json
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from test_window_judges import radiance, window

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Bsdf, FloatArray, IndexArray, MeasuredIntegral, Origin
from gonio.formats import validate
from gonio.formats.window import cells_table as klems_cells
from gonio.formats.window import from_model as klems_model
from gonio.formats.window.klems import BASES
from gonio.formats.window.matrices import counted
from gonio.formats.window.read import read
from gonio.units.errors import CheckFailed, UsageError

QUARTER = BASES["klems-quarter"]


def sample(diffuse: float = 0.25, *, u: float = 0.0, **channels: RetroCoating) -> Bsdf:
    made = dict(channels) or {"visible": RetroCoating(diffuse, 20.0, 3.0, 0.0)}
    power = 20.0 * 2 * np.pi * np.radians(3.0) ** 2
    measured = [MeasuredIntegral("visible", t, 0.0, True, diffuse + power, u * (diffuse + power)) for t in (5.0, 45.0)]
    return Bsdf(dict(made), "judge", "gonio tests", "exterior", "isotropic", measured=tuple(measured))


def build(bsdf: Bsdf, **options: bool):  # type: ignore[no-untyped-def]
    return klems_model.build(bsdf, klems_model.ModelFile(klems_model.channels_of(bsdf), **options), basis=QUARTER)


def test_energy_over_one_is_refused_with_side_column_and_sum() -> None:
    with pytest.raises(CheckFailed, match=r"Visible Front, incident patch \d+ \(theta .*sum to 1\.\d{4}.*--rescale"):
        build(sample(0.97))


def test_energy_over_one_within_its_uncertainty_is_a_finding() -> None:
    made = build(sample(0.671, u=0.01))
    assert "energy" in made.findings.codes
    sums = QUARTER.projected_solid_angle_sr @ made.bands["Visible"].matrices["Reflection", "Front"]
    assert 1.0 < sums.max() < 1.02
    assert any("within twice their uncertainty" in line for line in made.remarks())
    with pytest.raises(CheckFailed):
        build(sample(0.69, u=0.01))


def test_rescale_scales_columns_and_records_each() -> None:
    made = build(sample(0.7), rescale=True)
    sums = QUARTER.projected_solid_angle_sr @ made.bands["Visible"].matrices["Reflection", "Front"]
    assert sums.max() == pytest.approx(1.0, abs=1e-12)
    (said,) = [line for line in made.remarks() if "--rescale" in line]
    assert "Visible Front" in said
    assert "patch: factor 1-33: 0.9577" in said
    untouched = build(sample(0.5), rescale=True)
    assert "rescaled" not in untouched.findings.codes


def test_a_named_channel_is_visible_and_solar_stays() -> None:
    both = sample(green=RetroCoating(), Solar=RetroCoating())
    assert klems_model.channels_of(both, channel="green") == {"Visible": "green", "Solar": "Solar"}
    assert klems_model.channels_of(both, channel="Solar") == {"Solar": "Solar"}


def test_an_undeclared_symmetry_or_front_is_refused() -> None:
    with pytest.raises(UsageError, match="--symmetry"):
        build(replace(sample(), symmetry="undeclared"))
    with pytest.raises(UsageError, match="--front"):
        build(replace(sample(), front_faces="undeclared"))
    with pytest.raises(UsageError, match="--channel"):
        build(sample(**{"633 nm": RetroCoating()}))


@dataclass(frozen=True)
class Measured(RetroCoating):
    """As if it had been measured at theta 5 and 45, up to 60 degrees of the outgoing side."""

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        theta = np.degrees(np.arccos(incident[rows, 2]))
        at = np.min(np.abs(theta[:, None] - [5.0, 45.0]), axis=1) < 0.01
        found = np.where(at, Origin.MEASURED, Origin.INTERPOLATED)
        beyond = (theta > 45.01) | (outgoing[:, 2] < 0.5)
        return np.where(beyond, Origin.EXTRAPOLATED, found).astype(np.uint8)


def test_every_cell_has_an_origin() -> None:
    made = build(sample(visible=Measured(0.25, 20.0, 3.0, 0.0)))
    cells = made.bands["Visible"].cells["Reflection", "Front"]
    # Rings of the quarter basis: 0-9, 9-27, 27-45, 45-63, 63-90 degrees of 1, 8, 12, 12, 8 patches.
    assert (cells[:21, 0] == Origin.MEASURED).all()
    assert (cells[:21, 1:21] == Origin.INTERPOLATED).all()
    assert (cells[:21, 21:33] == Origin.MEASURED).all()  # 45 degrees belongs to the ring above
    assert (cells[:, 33:] == Origin.EXTRAPOLATED).all()
    assert (cells[33:] == Origin.EXTRAPOLATED).all()
    said = next(line for line in made.remarks() if "measured/interpolated/extrapolated/absent" in line)
    assert "Visible Reflection Front" in said
    assert "34-41: 0/0/41/0." in said
    table = list(csv.DictReader(io.StringIO(klems_cells.render(made).decode().split("\n", 1)[1])))
    assert len(table) == 2 * 4 * 41**2
    mine = [r for r in table if (r["band"], r["process"], r["light_from"]) == ("Visible", "Reflection", "Front")]
    named = np.array([r["origin"] for r in mine]).reshape(41, 41).T
    assert (named == np.array(["measured", "interpolated", "extrapolated", "absent"])[cells]).all()
    assert {r["origin"] for r in table if r["process"] == "Transmission"} == {"absent"}


def test_counts_join_neighbours_that_are_alike() -> None:
    cells = np.array([[0, 0, 1], [1, 1, 1]], dtype=np.uint8)
    assert counted(cells).endswith("by incident patch: 1-2: 1/1/0/0; 3: 0/2/0/0.")


def test_colour_is_written_in_blocks_of_its_own(tmp_path: Path) -> None:
    bsdf = sample(red=RetroCoating(0.3, 0, 5, 0), green=RetroCoating(0.2, 0, 5, 0), blue=RetroCoating(0.1, 0, 5, 0))
    channels = klems_model.channels_of(bsdf, xyz={"X": "red", "Y": "green", "Z": "blue"})
    path = tmp_path / "colour.xml"
    klems_model.write(bsdf, path, klems_model.ModelFile(channels), basis="klems-full")
    assert validate.validate(path).exit_status == 0
    back = read(path)
    for band, rho in (("CIE-X", 0.3), ("Visible", 0.2), ("CIE-Z", 0.1)):
        np.testing.assert_allclose(back.hemispherical(band, "Reflection", "Front"), rho, rtol=1e-5)  # type: ignore[arg-type]
    script = (
        "import json, sys, pyradiance.bsdf as b; sd = b.load_file(sys.argv[1]);"
        "print(json.dumps([float(v) for v in b.query(sd, 150, 0, 160, 40)]))"
    )
    done = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True)
    x, y, z = json.loads(done.stdout)
    assert y == pytest.approx(0.2 / np.pi, rel=1e-3)
    assert x / y == pytest.approx(1.5, rel=0.02)  # Radiance keeps chromaticity in a few digits
    assert z / y == pytest.approx(0.5, rel=0.02)


@pytest.mark.judge
def test_independent_programs_read_the_models_matrices(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    bsdf = sample(0.25)
    what = klems_model.ModelFile(klems_model.channels_of(bsdf), assume_flat=True)
    made = klems_model.write(bsdf, path, what, basis="klems-full")
    assert validate.validate(path).exit_status == 0
    own = made.bands["Visible"].matrices["Reflection", "Front"]
    sums = made.basis.projected_solid_angle_sr @ own
    cases = [("SOLAR", 40.0, 15.0)]
    columns = [int(made.basis.patch_of(theta, phi)) for _, theta, phi in cases]
    found = np.array(window(path, cases))
    np.testing.assert_allclose(found[:, 2], sums[columns], rtol=1e-5)
    np.testing.assert_allclose(found[:, [0, 1, 3]], 0.0, atol=1e-9)
    # Light from 40 degrees, azimuth 195 (the column's plus 180) outside; retro, mirror and to the side.
    column, rows = columns[0], [(40.0, 195.0), (40.0, 15.0), (20.0, 90.0)]
    answers = radiance(path, [[140.0, 195.0, 180.0 - t, p] for t, p in rows])["values"]
    expected = [own[int(made.basis.patch_of(t, p)), column] for t, p in rows]
    np.testing.assert_allclose(answers, expected, rtol=1e-3)
    assert expected[0] > 10 * expected[1]
