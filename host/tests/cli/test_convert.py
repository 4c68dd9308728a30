"""test_convert.py: simulation files in other bases, with their integrals kept."""

import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.models.samples import RetroCoating
from gonio.cli import main
from gonio.dataset.scattering import Bsdf
from gonio.formats.conversion import averages
from gonio.formats.findings import Findings
from gonio.formats.patches import of_tree
from gonio.formats.patches.average import average
from gonio.formats.patches.overlap import overlaps_sr, rebinned
from gonio.formats.tensor.flat import parse
from gonio.formats.tensor.read import read_tensor
from gonio.formats.tensor.square import disc_from_square
from gonio.formats.tensor.write import write_tensor
from gonio.formats.window import from_model as klems_model
from gonio.formats.window.klems import BASES, KlemsBasis, basis_from_rings
from gonio.formats.window.read import WindowBsdf, read
from gonio.formats.window.scattering import KlemsScattering

DATA = Path(__file__).parents[1] / "data" / "window_xml"
FULL, QUARTER = BASES["klems-full"], BASES["klems-quarter"]


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@st.composite
def bases(draw: st.DrawFn) -> KlemsBasis:
    inner = sorted(draw(st.sets(st.integers(2, 88), min_size=1, max_size=5)))
    bounds = [0, *inner, 90]
    counts = [draw(st.integers(1, 24)) for _ in bounds[1:]]
    middle = [(a + b) / 2 for a, b in pairwise(bounds)]
    return basis_from_rings("drawn", middle, bounds, counts)


@given(bases(), bases())
def test_overlaps_add_up_to_the_patches_of_both(old: KlemsBasis, new: KlemsBasis) -> None:
    shared = overlaps_sr(old, new)
    assert (shared >= 0).all()
    np.testing.assert_allclose(shared.sum(axis=0), old.projected_solid_angle_sr, rtol=1e-9)
    np.testing.assert_allclose(shared.sum(axis=1), new.projected_solid_angle_sr, rtol=1e-9)


def test_overlaps_against_counted_points() -> None:
    rng = np.random.default_rng(3)
    polar = np.degrees(np.arcsin(np.sqrt(rng.random(400_000))))
    azimuth = 360.0 * rng.random(400_000)
    pair = QUARTER.patch_of(polar, azimuth) * FULL.size + FULL.patch_of(polar, azimuth)
    counted = np.bincount(pair, minlength=QUARTER.size * FULL.size).reshape(QUARTER.size, FULL.size)
    np.testing.assert_allclose(counted * np.pi / 400_000, overlaps_sr(FULL, QUARTER), atol=1.5e-3)


def test_the_same_basis_changes_nothing() -> None:
    values = np.random.default_rng(5).random((41, 41))
    np.testing.assert_allclose(rebinned(values, QUARTER, QUARTER), values, rtol=1e-12)


@pytest.mark.parametrize("basis", ["klems-half", "klems-quarter", "klems-full"])
def test_a_wild_file_keeps_its_integrals(basis: str, capsys: pytest.CaptureFixture[str]) -> None:
    (source,) = DATA.glob("*.xml")
    assert main.run(["convert", str(source), "--format", basis, "-o", "x.xml"]) == 0
    assert capsys.readouterr().out == "x.xml\n"
    old, new = read(source), read(Path("x.xml"))
    assert new.basis.rings == BASES[basis].rings
    assert old.matrices.keys() == new.matrices.keys()
    assert new.text["Name"] == old.text["Name"]
    assert source.name in new.text["Comments"]
    shared = overlaps_sr(old.basis, new.basis)
    for key in old.matrices:
        expected = shared @ old.hemispherical(*key) / new.basis.projected_solid_angle_sr
        np.testing.assert_allclose(new.hemispherical(*key), expected, rtol=1e-6)
        # All light of the hemisphere, incident and outgoing.
        total = new.basis.projected_solid_angle_sr @ new.hemispherical(*key)
        assert total == pytest.approx(old.basis.projected_solid_angle_sr @ old.hemispherical(*key), rel=1e-6)


def test_leaves_of_a_small_tree() -> None:
    """Three dimensions: the first coordinate's bit is the lowest of a child's number; grids count the last fastest."""
    tree, _ = parse("{" + "{1}{2}{3}{4}{5}{6}{7}" + "{10 11 12 13 14 15 16 17}" + "}", 3, "here")
    found = {
        (level, *cell): value
        for level, index, values in of_tree.leaves_of(tree)
        for cell, value in zip(index.tolist(), values.tolist(), strict=True)
    }
    assert len(found) == 15
    for (level, *cell), value in found.items():
        place = (np.array([cell]) + 0.5) * 0.5**level
        assert tree.at(place)[0] == value


@pytest.mark.parametrize("dimensions", [3, 4])
def test_a_tree_as_matrices(dimensions: int) -> None:
    """A tree of a smooth sample: averages are the sample's, as far as the tree's cells tell."""
    coating = RetroCoating(0.3, 0.6, 20.0, 0.0)
    bsdf = Bsdf({"visible": coating}, "smooth", "us", "exterior", "isotropic")
    write_tensor(bsdf, Path("t.xml"), dimensions=dimensions, resolution=6 if dimensions == 3 else 4, size_mb=30.0)
    tree, _ = read_tensor(Path("t.xml"))
    found = averages(tree, QUARTER)["visible"].matrices["Reflection", "Front"]
    direct = average(coating, QUARTER, "exterior", symmetry="isotropic").matrices["Reflection", "Front"]
    size = QUARTER.projected_solid_angle_sr
    np.testing.assert_allclose(size @ found, size @ direct, rtol=0.01 if dimensions == 3 else 0.02)
    assert np.abs(found - direct).max() < (0.08 if dimensions == 3 else 0.25) * direct.max()
    # A turn or a mirror image would move the peak: the brightest outgoing patch is the same one.
    assert (np.argmax(found, axis=0) == np.argmax(direct, axis=0))[21:33].all()


@pytest.mark.parametrize(("dimensions", "resolution"), [(3, 4), (4, 4)])
def test_a_tree_keeps_the_columns_integrals(dimensions: int, resolution: int) -> None:
    """What an incident cell sends out is the mean of the columns that it overlaps; which part of it overlaps which
    patch is counted here from random directions."""
    rng = np.random.default_rng(7)
    values = rng.random((QUARTER.size, QUARTER.size)) * np.linspace(0.05, 0.5, QUARTER.size)
    if dimensions == 3:  # a sample that looks the same at all azimuths
        values = average(RetroCoating(0.3, 0.6, 20.0, 0.0), QUARTER, "exterior", symmetry="isotropic").matrices[
            "Reflection", "Front"
        ]
    matrices = {("Visible", "Reflection", "Front"): values}
    window = WindowBsdf(Path("x.xml"), QUARTER, matrices, {}, {}, None, Findings("x"), ET.Element("x"))  # type: ignore[arg-type]
    own = KlemsScattering(window, "Visible", "exterior")
    bsdf = Bsdf({"visible": own}, front_faces="exterior", symmetry="isotropic" if dimensions == 3 else "none")
    write_tensor(bsdf, Path("t.xml"), dimensions=dimensions, resolution=resolution, size_mb=8.0, rescale=True)
    tree, _ = read_tensor(Path("t.xml"))
    ((_, flat),) = tree.channels["visible"].trees.items()  # type: ignore[attr-defined]
    split, wide = dimensions - 2, 1 << resolution
    found = np.zeros((wide,) * split)
    for level, index, value in of_tree.leaves_of(flat):
        light = np.zeros((1 << level,) * split)
        np.add.at(light, tuple(index[:, :split].T), value * np.pi * 0.25**level)
        for axis in range(split):
            light = np.repeat(light, wide >> level, axis=axis)
        found += light
    hemispherical = QUARTER.projected_solid_angle_sr @ values
    place = rng.random((400_000, split)) * ([0.5] if split == 1 else [1.0, 1.0])
    if split == 1:
        sine = 1.0 - 2.0 * place[:, 0]
        azimuth, weight = 360.0 * rng.random(len(place)), sine
    else:
        xy = disc_from_square(place)
        sine, azimuth, weight = np.hypot(*xy.T), np.degrees(np.arctan2(xy[:, 1], xy[:, 0])), np.ones(len(place))
    column = QUARTER.patch_of(np.degrees(np.arcsin(np.minimum(sine, 1.0))), azimuth)
    cell = np.ravel_multi_index(tuple((place * wide).astype(int).T), found.shape)
    counted = [np.bincount(cell, w, minlength=found.size) for w in (weight, weight * hemispherical[column])]
    lit = counted[0] > 0
    found = found.ravel()[lit]
    np.testing.assert_allclose(found, (counted[1] / np.maximum(counted[0], 1e-9))[lit], rtol=0.06)
    apart = np.array([np.ptp(hemispherical[column[cell == k]]) == 0 for k in np.flatnonzero(lit)])
    inside = np.array([hemispherical[column[cell == k][0]] for k in np.flatnonzero(lit)[apart]])
    np.testing.assert_allclose(found[apart], inside, rtol=1e-4)  # cells within a patch: of no count
    assert apart.any()
    if split == 2:
        total = found.sum() * np.pi / 4.0**resolution
        assert total == pytest.approx(QUARTER.projected_solid_angle_sr @ hemispherical, rel=1e-4)


def test_a_tree_of_one_value_has_that_value_everywhere() -> None:
    for dimensions in (3, 4):
        tree, _ = parse("{ 0.25 }", dimensions, "here")
        found = of_tree.matrix(tree, QUARTER)
        np.testing.assert_allclose(found, 0.25, rtol=4e-3)
        sums = QUARTER.projected_solid_angle_sr @ found
        np.testing.assert_allclose(sums, 0.25 * np.pi, rtol=1e-9)


def test_a_tree_by_command_line_and_back(capsys: pytest.CaptureFixture[str]) -> None:
    bsdf = Bsdf({"visible": RetroCoating(0.3, 0.6, 20.0, 0.0)}, "smooth", "us", "exterior", "isotropic")
    what = klems_model.ModelFile({"Visible": "visible"})
    klems_model.write(bsdf, Path("k.xml"), what, basis="klems-quarter")
    assert main.run(["convert", "k.xml", "--format", "tensor3", "--resolution", "3", "-o", "t.xml"]) == 0
    assert "hemispherical values change by up to" in capsys.readouterr().err
    assert main.run(["convert", "t.xml", "--format", "klems-quarter", "-o", "back.xml"]) == 0
    first, back = read(Path("k.xml")), read(Path("back.xml"))
    key = ("Visible", "Reflection", "Front")
    np.testing.assert_allclose(back.hemispherical(*key), first.hemispherical(*key), rtol=0.2)  # type: ignore[arg-type]
    assert np.corrcoef(back.matrices[key].ravel(), first.matrices[key].ravel())[0, 1] > 0.85  # type: ignore[index]


def test_what_is_no_simulation_file_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("points.csv").write_text(
        "theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,dsf_per_sr\n0,0,10,0,0.1\n", encoding="utf-8"
    )
    assert main.run(["convert", "points.csv", "--format", "klems-full", "-o", "x.xml"]) == 2
    assert "gonio export" in capsys.readouterr().err
    assert not Path("x.xml").exists()
