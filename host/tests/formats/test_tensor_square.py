"""test_tensor_square.py: the square and the disc: inverse, equal areas, Radiance's formulas; points of cells."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pyradiance
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lopsided import concentric_disc

from gonio.formats.tensor.frame import incident_points, place_of
from gonio.formats.tensor.square import cell_points, disc_from_square, distinct, on_diagonal, square_from_disc

UNIT = st.floats(0.0, 1.0, allow_subnormal=False)


@given(UNIT, UNIT)
def test_square_and_disc_are_inverse(a: float, b: float) -> None:
    place = np.array([[a, b]])
    disc = disc_from_square(place)
    assert np.hypot(*disc[0]) <= 1.0 + 1e-15
    np.testing.assert_allclose(square_from_disc(disc), place, atol=1e-15)
    np.testing.assert_allclose(disc, concentric_disc(place), atol=1e-15)


@given(UNIT, st.floats(-np.pi, np.pi))
def test_disc_and_square_are_inverse(radius: float, phi: float) -> None:
    disc = radius * np.array([[np.cos(phi), np.sin(phi)]])
    place = square_from_disc(disc)
    assert place.min() >= -1e-15
    assert place.max() <= 1.0 + 1e-15
    np.testing.assert_allclose(disc_from_square(place), disc, atol=2e-15)


def test_equal_cells_of_the_square_have_equal_areas_on_the_disc() -> None:
    """Exact polygon areas of finely divided outlines."""
    edge = np.linspace(0.0, 1.0, 400, endpoint=False)
    rim = np.concatenate(
        [
            np.stack(side, axis=1)
            for side in ((edge, 0 * edge), (0 * edge + 1, edge), (1 - edge, 0 * edge + 1), (0 * edge, 1 - edge))
        ]
    )
    for cell in np.ndindex(8, 8):
        x, y = disc_from_square((np.array(cell) + rim) / 8.0).T
        area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        assert area == pytest.approx(np.pi / 64.0, rel=2e-5)


@pytest.mark.judge
def test_radiances_formulas_agree() -> None:
    root = Path(pyradiance.__file__).parent
    rng = np.random.default_rng(1)
    disc = np.sqrt(rng.random((500, 1))) * np.stack((np.cos(p := rng.random(500) * 2 * np.pi), np.sin(p)), axis=1)
    command = ["rcalc", "-f", "disk2square.cal", "-e", "in_disk_x=$1;in_disk_y=$2;$1=out_square_x;$2=out_square_y"]
    text = "\n".join(f"{x:.17g} {y:.17g}" for x, y in disc)
    environment = {**os.environ, "RAYPATH": str(root / "lib")}
    command[0] = str(root / "bin" / "rcalc")
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True, env=environment)
    found = np.array([line.split() for line in done.stdout.splitlines()], dtype=np.float64)
    np.testing.assert_allclose(square_from_disc(disc), found, atol=2e-6)  # six digits are printed


@pytest.mark.parametrize("level", [1, 2, 4])
def test_points_of_cells_integrate_cosine_and_solid_angle(level: int) -> None:
    """Mean BSDF of DSF = cos is 1 in every cell; DSF = 1 sums up to 2 pi although 1 / cos is infinite at the rim."""
    index = np.array(list(np.ndindex(1 << level, 1 << level)), dtype=np.int64)
    light = 0.0
    crossed = on_diagonal(index, level)
    assert np.count_nonzero(crossed) == 2 << level
    for diagonal in (False, True):
        if not np.any(crossed == diagonal):
            continue
        points, weight = cell_points(index[crossed == diagonal], level, 4, diagonal=diagonal)
        np.testing.assert_allclose(np.linalg.norm(points, axis=2), 1.0, atol=1e-14)
        np.testing.assert_allclose(np.sum(weight * points[:, :, 2], axis=1), 1.0, rtol=2e-5)
        inside = np.floor(square_from_disc(points[:, :, :2]) * (1 << level)).astype(np.int64)
        np.testing.assert_array_equal(inside, np.broadcast_to(index[crossed == diagonal][:, None], inside.shape))
        light += float(weight.sum()) * np.pi * 0.25**level
    assert light == pytest.approx(2.0 * np.pi, rel=1e-6)


@pytest.mark.parametrize("dimensions", [3, 4])
def test_points_of_incident_cells_lie_in_them(dimensions: int) -> None:
    level, split = 3, dimensions - 2
    side = np.arange(8 if split == 2 else 4)
    index = np.stack([axis.ravel() for axis in np.meshgrid(*[side] * split, indexing="ij")], axis=1).astype(np.int64)
    crossed = on_diagonal(index, level) if split == 2 else np.zeros(len(index), dtype=bool)
    mean_z2 = 0.0
    for diagonal in (False, True):
        own = index[crossed == diagonal]
        if len(own) == 0:
            continue
        points, weight = incident_points(own, level, 5, diagonal=diagonal)
        flat = points.reshape(-1, 3)
        place = place_of(flat, np.tile([0.0, 0.0, 1.0], (len(flat), 1)), dimensions)[:, :split]
        np.testing.assert_array_equal(
            np.floor(place * 8).reshape(len(own), -1, split),
            np.broadcast_to(own[:, None], (len(own), points.shape[1], split)),
        )
        np.testing.assert_allclose(weight.sum(axis=1), 1.0, rtol=1e-14)
        # cos^2 over projected solid angle has the mean 1/2; a ring's share of it is the difference of sin^2.
        share = np.full(len(own), 1.0 / 64.0) if split == 2 else (2.0 * (3 - own[:, 0]) + 1.0) / 16.0
        mean_z2 += float(share @ np.sum(weight * points[:, :, 2] ** 2, axis=1))
    assert mean_z2 == pytest.approx(0.5, rel=1e-6)


@given(st.lists(st.tuples(st.integers(0, 31), st.integers(0, 31)), min_size=1, max_size=50))
def test_distinct_cells(cells: list[tuple[int, int]]) -> None:
    index = np.array(cells, dtype=np.int64)
    found, of = distinct(index, 5)
    np.testing.assert_array_equal(found[of], index)
    assert len({tuple(row) for row in found.tolist()}) == len(found)
