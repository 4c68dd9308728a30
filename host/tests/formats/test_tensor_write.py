"""test_tensor_write.py: what is written beside values, what is refused, and how leaves are chosen."""

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from lopsided import Lopsided

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Bsdf, FloatArray, IndexArray, MeasuredIntegral
from gonio.formats.tensor.build import Limit, build
from gonio.formats.tensor.cells import CellIntegrator
from gonio.formats.tensor.choose import Offered, choose
from gonio.formats.tensor.forced import forced_cells
from gonio.formats.tensor.frame import Component
from gonio.formats.tensor.grow import GrownTree, grow
from gonio.formats.tensor.measure import mixed
from gonio.formats.tensor.read import read_tensor
from gonio.formats.tensor.text import numbers
from gonio.formats.tensor.write import write_tensor
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import CheckFailed, UsageError

RETRO = Bsdf({"visible": RetroCoating()}, front_faces="interior", symmetry="isotropic")


@dataclass(frozen=True)
class Scaled(RetroCoating):
    """With more light, or less, or none of it positive."""

    by: float = 1.0

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        return self.by * super().dsf_per_sr(incident, outgoing, which)


def planted(resolution: int) -> GrownTree:
    component = Component("Reflection", "Back")
    tree = GrownTree(
        CellIntegrator(RetroCoating(), component, "interior", 3, mixed(0.7)),
        resolution,
        forced_cells(RetroCoating(), component, "interior", 3, resolution),
    )
    tree.plant()
    return tree


def test_what_is_undeclared_or_unclear_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.xml"
    two = {"a": RetroCoating(), "b": RetroCoating()}
    for bsdf, options, says in [
        (replace(RETRO, symmetry="bilateral"), {"dimensions": 3}, "declared bilateral"),
        (replace(RETRO, symmetry="undeclared"), {"dimensions": 3}, "declared undeclared"),
        (replace(RETRO, front_faces="undeclared"), {"dimensions": 4}, "--front"),
        (RETRO, {"dimensions": 5}, "3 or 4"),
        (RETRO, {"dimensions": 3, "resolution": 12}, "resolution 12"),
        (RETRO, {"dimensions": 3, "leaves": 100, "percent": 90.0}, "one limit"),
        (RETRO, {"dimensions": 3, "percent": 100.0}, "below 100"),
        (RETRO, {"dimensions": 3, "size_mb": 0.001}, "allow more"),
        (RETRO, {"dimensions": 3, "channels": {"Visible": "no"}}, "no channel"),
        (RETRO, {"dimensions": 3, "channels": {"Blue": "visible"}}, "Blue"),
        (RETRO, {"dimensions": 3, "channels": {"CIE-X": "visible"}}, "CIE-Y"),
        (replace(RETRO, channels=dict(two)), {"dimensions": 3}, "choose one of a, b"),
        (replace(RETRO, channels={"a": Lopsided(pairs=())}), {"dimensions": 4}, "nothing to write"),
    ]:
        with pytest.raises(UsageError, match=says) as caught:
            write_tensor(bsdf, path, **options)  # type: ignore[arg-type]
        assert "\n" not in str(caught.value)
        assert not list(tmp_path.iterdir())


def test_energy_beyond_one_is_refused_passed_or_scaled(tmp_path: Path) -> None:
    path = tmp_path / "x.xml"
    much = replace(RETRO, channels={"visible": Scaled(by=1.4)})
    options = {"dimensions": 3, "resolution": 5, "size_mb": 0.2}
    with pytest.raises(CheckFailed, match=r"light from the interior at .* over 1 by more than its uncertainty"):
        write_tensor(much, path, **options)  # type: ignore[arg-type]
    assert not path.exists()
    measured = tuple(MeasuredIntegral("visible", t, 0.0, True, 1.05, 0.06) for t in (10.0, 45.0, 80.0))
    remarks = write_tensor(replace(much, measured=measured), path, **options)  # type: ignore[arg-type]
    assert any("within its uncertainty" in line for line in remarks)
    remarks = write_tensor(much, path, rescale=True, **options)  # type: ignore[arg-type]
    assert any("incident cells scaled" in line for line in remarks)
    assert "incident cells scaled" in path.read_text()
    tree = next(iter(read_tensor(path)[0].channels["visible"].trees.values()))
    place = (np.indices((16, 32, 32)).reshape(3, -1).T + 0.5) / 32.0
    sums = tree.at(place).reshape(16, -1).mean(axis=1) * np.pi
    assert sums.max() <= 1.0 + 3e-3  # three digits
    assert sums.max() > 0.97


def test_negative_averages_become_zero_and_are_told(tmp_path: Path) -> None:
    path = tmp_path / "x.xml"
    bsdf = replace(RETRO, channels={"visible": Scaled(by=-0.1)})
    remarks = write_tensor(bsdf, path, dimensions=3, resolution=4, size_mb=0.1)
    line = next(line for line in remarks if "negative averages" in line)
    added = float(line.split("adding ")[1].split()[0])
    assert added == pytest.approx(0.07, abs=0.01)  # a tenth of the coating's light
    assert read_tensor(path)[0].channels["visible"].dsf_per_sr(*[unit_from_angles_deg([30.0], [0.0])] * 2)[0] == 0.0


def test_origins_are_counted_and_listed(tmp_path: Path) -> None:
    """Measured to 60 degrees: so far lie the middles of 6 x 6 of the 8 x 8 incident cells."""
    path, cells = tmp_path / "x.xml", tmp_path / "cells.csv"
    bsdf = Bsdf({"visible": Lopsided(pairs=((True, False),))}, front_faces="exterior", symmetry="none")
    write_tensor(bsdf, path, dimensions=4, resolution=3, leaves=8**4, cells=cells)
    text = path.read_text()
    share = float(text.split("Transmission Front, by projected solid angle: ")[1].split("%")[0])
    assert share == pytest.approx(100.0 * 36 / 64, abs=0.06)
    assert text.count("<WavelengthDataBlock>") == 1  # what is absent is left out
    assert "gonio-validity:" in text
    with cells.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    volume = {
        word: sum(0.0625 ** int(r["level"]) for r in rows if r["origin"] == word)
        for word in ("interpolated", "extrapolated")
    }
    assert sum(volume.values()) == pytest.approx(1.0)
    assert volume["interpolated"] == pytest.approx(share / 100.0, abs=0.001)
    assert read_tensor(path)[0].front_faces == "exterior"


def test_sums_of_parts_are_those_of_the_whole() -> None:
    """A cell's mean from its children's is what its own points would give: parts count by projected solid angle."""
    truth = RetroCoating(retro_per_sr=0.5, retro_sigma_deg=25.0, mirror_sigma_deg=25.0)

    def plain(dsf: FloatArray, cos: FloatArray) -> FloatArray:
        return 1.0 + 0.0 * dsf * cos

    tree = GrownTree(CellIntegrator(truth, Component("Reflection", "Back"), "interior", 3, plain), 6)
    tree.plant()
    for level in (1, 2, 3):
        index = tree.levels[level].index
        own = tree.integrator.sums(index, level, inner=9, outer=9)
        np.testing.assert_allclose(tree.levels[level].sums.mean, own.mean, rtol=2e-3)


def test_chosen_leaves_are_the_best_for_their_number() -> None:
    """No single exchange, a split undone here for a split done there, makes the error less."""
    tree = planted(6)
    grow([tree], 6000)
    offer = Offered(tree)
    chosen = choose([offer], 4000)[0]
    assert 3900 < chosen.leaves <= 4000
    worth_undoing, worth_doing = [], []
    for level in range(len(tree.levels) - 1):
        at = np.flatnonzero(tree.levels[level].child >= 0)
        members = tree.members(level, at)
        gain = offer.error[level][at] - offer.error[level + 1][members].sum(axis=1)
        ends = chosen.split[level][at] & chosen.leaf[level + 1][members].all(axis=1)
        worth_undoing.append(gain[ends])
        worth_doing.append(gain[chosen.leaf[level][at]])
    assert np.concatenate(worth_doing).max() <= np.concatenate(worth_undoing).min() * 1.01


def test_more_leaves_are_never_worse() -> None:
    tree = planted(6)
    grow([tree], 8000)
    errors = []
    for most in (500, 2000, 8000):
        chosen = choose([Offered(tree)], most)[0]
        errors.append(sum(float(tree.errors(level)[rows].sum()) for level, rows in chosen.rows()))
    assert errors[0] > 1.2 * errors[1]
    assert errors[1] > 1.1 * errors[2]


def test_memory_grows_with_the_leaves_not_with_the_resolution() -> None:
    """At k = 9 a dense tree would have 67 million leaves; some ten thousand cells are evaluated for as many leaves."""
    tree = planted(9)
    grow([tree], 40000)
    evaluated = sum(len(level.index) for level in tree.levels)
    assert evaluated < 120_000


def test_a_percentage_takes_leaves_away() -> None:
    leaves = {}
    for percent in (50.0, 90.0):
        built = build(RETRO, {"Visible": "visible"}, "interior", 3, 5, Limit(percent=percent), rescaled=False)
        leaves[percent] = sum(own.chosen.leaves for own in built.leaves.values())
    assert leaves[50.0] == pytest.approx(2**14 * 0.5, rel=0.02)
    assert leaves[90.0] == pytest.approx(2**14 * 0.1, rel=0.02)


def test_numbers_are_short_and_right() -> None:
    values = np.array([0.0, 0.07957, 0.5, 1.0, 12.34, 154.4, 1234.0, 2.5e-7, 99.96, 3.0e12])
    text = numbers(values, 3)
    assert text[:6] == ["0", ".0796", ".5", "1", "12.3", "154"]
    np.testing.assert_allclose([float(t) for t in text], values, rtol=5e-3)
    assert not any(t.startswith("0.") for t in text)
