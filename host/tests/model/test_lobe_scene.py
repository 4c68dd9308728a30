"""test_lobe_scene.py: points in cells: no solid angle is lost, parts are scattered, means know their spread."""

import numpy as np
import pytest

from gonio.model.lobes.blobs import find_blobs
from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.scene import Scene


def fibonacci(count: int) -> np.ndarray:
    k = np.arange(count) + 0.5
    z = 1.0 - k / count
    phi = k * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z**2)
    return np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)


def scene_of(value: np.ndarray, unit: np.ndarray) -> Scene:
    return Scene(unit, value, np.full(len(unit), 0.01), np.full(len(unit), 2.0 * np.pi / len(unit)))


@pytest.mark.parametrize("count", [500, 20000, 100000])
def test_cells_hold_all_points_and_all_solid_angle(count: int) -> None:
    unit = fibonacci(count)
    scene = scene_of(unit[:, 2], unit)
    assert scene.cell_weight.sum() == pytest.approx(2.0 * np.pi)
    assert scene.start[-1] == count
    assert np.sum(scene.cell_weight * scene.cell_mean) == pytest.approx(np.pi, rel=1e-6)  # the cosine over the half
    for factor in (1, 2):
        means = scene.means(factor)
        assert means.nodes.weight.sum() == pytest.approx(2.0 * np.pi)
        np.testing.assert_allclose(means.of(scene.cell_mean), means.nodes.value)
        # noise of a mean over n points of equal weight
        assert np.sum(means.nodes.weight**2 * means.nodes.variance) == pytest.approx((2 * np.pi) ** 2 * 0.01 / count)


def test_points_near_are_those_near_and_thinning_keeps_their_solid_angle() -> None:
    unit = fibonacci(200000)
    centre = unit[60000]
    scene = scene_of(unit[:, 2], unit)
    radius = np.radians(9.0)
    there = unit @ centre >= np.cos(radius)
    full = scene.points_near(scene.cells_near(centre, radius), centre, radius, 10**6)
    assert len(full) == np.count_nonzero(there)
    thin = scene.points_near(scene.cells_near(centre, radius), centre, radius, 500)
    assert 300 < len(thin) < 1000
    assert np.all(thin.unit @ centre >= np.cos(radius))
    assert thin.weight.sum() == pytest.approx(full.weight.sum())


def test_the_held_out_part_is_a_quarter_anywhere_even_on_a_fibonacci_spiral() -> None:
    unit = fibonacci(40000)
    scene = scene_of(unit[:, 2], unit)
    for row in (100, 5000, 20000, 39000):
        cells = scene.cells_near(unit[row], np.radians(6.0))
        parts = scene.points_near(cells, unit[row], np.radians(6.0), 10**6).part
        shares = np.bincount(parts, minlength=4) / len(parts)
        assert len(parts) > 60
        assert shares.min() > 0.1
        assert shares.max() < 0.4


def test_means_of_a_lobe_are_those_of_the_lobe_widened_by_their_spread() -> None:
    unit = fibonacci(300000)
    gauss = Gauss.of(unit[80000], np.eye(2) * np.radians(5.0) ** 2, 1.0)
    scene = scene_of(gauss.value(unit), unit)
    means = scene.means(2)
    away = np.degrees(np.arccos(np.clip(means.nodes.unit @ gauss.centre, -1.0, 1.0)))
    middle = away < 2.0
    plain = means.nodes.value[middle] / gauss.value(means.nodes.unit[middle])
    spread = float(means.spread[middle].mean())
    wider = means.nodes.value[middle] / gauss.widened(spread).value(means.nodes.unit[middle])
    assert np.abs(plain - 1.0).max() > 0.005
    assert np.abs(wider - 1.0).max() < 0.0015


def test_blobs_are_found_at_their_place_and_octave_beside_holes() -> None:
    size = 96
    row, column = np.mgrid[:size, :size]
    weight = np.ones((size, size))
    weight[40:44, 20:24] = 0.0
    value = 50.0 * np.exp(-((row - 20) ** 2 + (column - 70) ** 2) / 2 / 1.5**2)
    value += 1.0 * np.exp(-((row - 70) ** 2 + (column - 30) ** 2) / 2 / 8.0**2)
    level = value + 0.1
    blobs = find_blobs(weight, value, level, np.zeros((size, size)), floor=1e-3)
    assert (blobs[0].row, blobs[0].column, blobs[0].cells) == (20.0, 70.0, 1)
    broad = max((b for b in blobs if b.cells >= 4 and b.column < 48), key=lambda b: b.contrast)
    assert abs(broad.row - 70) < 4
    assert abs(broad.column - 30) < 4
    assert not find_blobs(weight, 0.0 * value + 3.0, level, np.zeros((size, size)), floor=1e-3)
    assert not find_blobs(weight, value, level, np.full((size, size), 1e4), floor=1e-3)
