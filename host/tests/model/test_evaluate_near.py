"""test_evaluate_near.py: lobes alone, points near lobes and points in cells: closed forms; compiled and numpy."""

from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray
from sampled_nodes import directions

from gonio.model import fallback
from gonio.model.evaluate import lobes_at, near_lobes
from gonio.model.hemisphere import disc_from_unit, tangent_axes
from gonio.model.lobe import Lobe

_model = pytest.importorskip("gonio.model._model")
FloatArray = NDArray[np.float64]


LOBES = (
    Lobe(np.array([0.0, 0.0, 1.0]), np.array([[0.01, 0.002], [0.002, 0.04]]), 3.0),
    Lobe(np.array([0.6, 0.0, 0.8]), np.array([[0.0004, 0.0], [0.0, 0.0009]]), 50.0),
    Lobe(np.array([0.0, -1.0, 0.0]), np.array([[1.0, -0.2], [-0.2, 2.0]]), 0.5),  # wider than the sphere
)
FRAME = tangent_axes(np.array([one.centre for one in LOBES]))
WHITENING = np.array([np.linalg.inv(np.linalg.cholesky(one.covariance_rad2)) for one in LOBES])


@pytest.mark.usefixtures("who_answers")
def test_lobes_alone_are_their_sum() -> None:
    unit = directions(3000)
    peak = np.array([one.peak_per_sr for one in LOBES])
    expected = np.sum([one.dsf_per_sr(unit) for one in LOBES], axis=0)
    np.testing.assert_allclose(lobes_at(FRAME, WHITENING, peak, unit), expected, rtol=1e-9)
    assert not np.any(lobes_at(FRAME[:0], WHITENING[:0], peak[:0], unit))


@pytest.mark.usefixtures("who_answers")
def test_points_near_lobes() -> None:
    unit = directions(3000, 2)
    rows, places = near_lobes(FRAME, WHITENING, unit, 2.5)
    assert len(rows) == len(places) == 3
    for lobe, row, v in zip(LOBES, rows, places, strict=True):
        longest = 2.5 * np.sqrt(np.linalg.eigvalsh(lobe.covariance_rad2)[1])
        angle = np.arccos(np.clip(unit @ lobe.centre, -1.0, 1.0))
        np.testing.assert_array_equal(row, np.flatnonzero(angle <= longest))
        expected = -2.0 * np.log(lobe.dsf_per_sr(unit[row]) / lobe.peak_per_sr)
        np.testing.assert_allclose(np.sum(v**2, axis=1), expected, rtol=1e-9)
    assert 0 < len(rows[1]) < len(rows[0]) < len(rows[2]) == len(unit)
    assert near_lobes(FRAME[:0], WHITENING[:0], unit, 2.0) == ([], [])


def test_places_are_the_same_in_both() -> None:
    unit = directions(2000, 3)
    for ours, theirs in zip(
        _model.near_lobes(unit, FRAME, WHITENING, 3.0), fallback.near_lobes(unit, FRAME, WHITENING, 3.0), strict=True
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)
    for one in (_model, fallback):
        with pytest.raises(ValueError, match="per lobe"):
            one.near_lobes(unit, FRAME, WHITENING[1:], 3.0)


def measured(count: int) -> tuple[np.ndarray, ...]:
    """Points, values with a steep place, variances and weights."""
    random = np.random.default_rng(9)
    unit = directions(count, 4)
    value = 1.0 + 0.3 * unit[:, 0] + 50.0 * (unit[:, 2] > 0.99) * random.random(count) ** 4
    return unit, value, np.full(count, 1e-4), 0.5 + random.random(count)


@pytest.mark.parametrize("size", [1, 7, 160])
@pytest.mark.parametrize("one", [_model, fallback], ids=["compiled", "numpy"])
def test_points_sorted_into_cells(one: ModuleType, size: int) -> None:
    unit, value, variance, weight = measured(5000)
    home, start, row, kept_weight, total = one.sorted_cells(unit, value, variance, weight, size, 5000)
    np.testing.assert_array_equal(np.sort(row), np.arange(5000))
    np.testing.assert_array_equal(kept_weight, weight[row])
    assert start[0] == 0
    assert start[-1] == 5000
    assert np.all(np.diff(home) > 0)
    cell = np.floor((disc_from_unit(unit) + 1.0) * 0.5 * size).astype(np.int64)
    key = cell[:, 1] * size + cell[:, 0]
    np.testing.assert_array_equal(key[row], np.repeat(home, np.diff(start)))
    assert all(np.all(np.diff(row[a:b]) > 0) for a, b in zip(start[:-1].tolist(), start[1:].tolist(), strict=True))
    for k, column in enumerate((weight, weight * value, weight**2 * variance, *(weight[:, None] * unit).T)):
        np.testing.assert_allclose(total[:, k], np.bincount(key, column, size**2)[home], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("one", [_model, fallback], ids=["compiled", "numpy"])
def test_some_points_stand_for_all_of_a_calm_cell(one: ModuleType) -> None:
    unit, value, variance, weight = measured(20000)
    size, most = 7, 100
    home, start, row, kept_weight, total = one.sorted_cells(unit, value, variance, weight, size, most)
    cell = np.floor((disc_from_unit(unit) + 1.0) * 0.5 * size).astype(np.int64)
    key = cell[:, 1] * size + cell[:, 0]
    count, stay = np.bincount(key, minlength=size**2)[home], np.diff(start)
    steep = home == size * size // 2  # at the normal
    np.testing.assert_array_equal(stay[steep], count[steep])
    assert np.all(stay[~steep] <= np.minimum(count[~steep], most))
    assert np.all(stay[~steep] > 0.45 * np.minimum(count[~steep], most))
    assert len(np.unique(row)) == len(row)
    np.testing.assert_allclose(total[:, 0], np.bincount(key, weight, size**2)[home])
    np.testing.assert_allclose(np.add.reduceat(kept_weight, start[:-1]), total[:, 0])
    # a seventh of the disc across, of a slope of 0.3 per unit: the mean of 100 is that of all within a few per cent
    mean = np.bincount(key, weight * value, size**2)[home] / total[:, 0]
    np.testing.assert_allclose(total[:, 1] / total[:, 0], mean, rtol=0.05)


def test_compiled_cells_are_those_of_numpy() -> None:
    columns = measured(20000)
    for ours, theirs in zip(_model.sorted_cells(*columns, 9, 50), fallback.sorted_cells(*columns, 9, 50), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9)


def test_no_points_in_cells() -> None:
    nothing = np.zeros(0)
    for one in (_model, fallback):
        home, start, row, weight, total = one.sorted_cells(np.zeros((0, 3)), nothing, nothing, nothing, 5, 10)
        assert (len(home), start.tolist(), len(row), len(weight), total.shape) == (0, [0], 0, 0, (0, 6))
        with pytest.raises(ValueError, match="per point"):
            one.sorted_cells(np.zeros((1, 3)), nothing, nothing, nothing, 5, 10)
