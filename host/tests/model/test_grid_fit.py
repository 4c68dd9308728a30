"""test_grid_fit.py: grids through scattered points: exact where they must be, near where they can be, over holes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gonio.model import fallback
from gonio.model.grid_fit import fit_grid, grid_at, suitable_size
from gonio.model.hemisphere import disc_from_unit, unit_from_disc

_model = pytest.importorskip("gonio.model._model")
FloatArray = NDArray[np.float64]


def disc_points(n: int, seed: int = 1) -> FloatArray:
    """Points (n, 2) evenly at random on the unit disc."""
    r2, phi = np.random.default_rng(seed).random((2, n))
    phi *= 2.0 * np.pi
    return np.sqrt(r2)[:, None] * np.column_stack((np.cos(phi), np.sin(phi)))


def rings(pitch_deg: float) -> FloatArray:
    """Disc positions of directions on circles of latitude, as far apart along them as the circles are."""
    found = []
    for theta_deg in np.arange(0.5 * pitch_deg, 90.0, pitch_deg):
        theta = np.radians(theta_deg)
        phi = np.arange(0.0, 2.0 * np.pi, np.radians(pitch_deg) / np.sin(theta))
        found.append(np.sqrt(1.0 - np.cos(theta)) * np.column_stack((np.cos(phi), np.sin(phi))))
    return np.concatenate(found)


def smooth(disc: FloatArray) -> FloatArray:
    """Cosine and a lobe of 12 degrees, as the retro coating of the judges has them."""
    unit = unit_from_disc(disc)
    mirror = np.array([-np.sin(0.7), 0.0, np.cos(0.7)])
    angle = 2.0 * np.arcsin(np.minimum(np.linalg.norm(unit - mirror, axis=1) / 2.0, 1.0))
    return np.asarray(0.25 / np.pi * unit[:, 2] + 0.4 * np.exp(-(angle**2) / 2.0 / np.radians(12.0) ** 2))


def fitted(position: FloatArray, value: FloatArray, size: int, noise: FloatArray | float = 0.0) -> FloatArray:
    variance = np.broadcast_to(np.asarray(noise, dtype=np.float64) ** 2, value.shape)
    return fit_grid(position, value, variance, np.ones(len(value)), half_width=1.0, size=size)


@pytest.mark.usefixtures("who_answers")
def test_a_constant_stays_one() -> None:
    nodes = fitted(disc_points(500), np.full(500, 3.25), 33, noise=0.5)
    np.testing.assert_allclose(nodes, 3.25, rtol=1e-12)


@pytest.mark.usefixtures("who_answers")
@pytest.mark.parametrize("pitch_deg", [1.0, 2.0])
def test_smooth_functions_are_kept_well_under_a_percent(pitch_deg: float) -> None:
    position = rings(pitch_deg)
    nodes = fitted(position, smooth(position), suitable_size(position, 1.0))
    between = 0.98 * disc_points(5000, 2)
    off = grid_at(nodes, 1.0, between) / smooth(between) - 1.0
    assert np.sqrt(np.mean(off**2)) < 0.0008 * pitch_deg**2
    assert np.max(np.abs(off)) < 0.01 * pitch_deg**2


@pytest.mark.usefixtures("who_answers")
def test_noise_is_taken_off_and_more_points_take_off_more() -> None:
    left = []
    for n in (5000, 80_000):
        position = disc_points(n, 3)
        truth = smooth(position)
        noise = 0.05 * truth
        noisy = truth + noise * np.random.default_rng(4).normal(size=n)
        nodes = fitted(position, noisy, suitable_size(position, 1.0), noise)
        between = 0.95 * disc_points(5000, 5)
        left.append(np.sqrt(np.mean((grid_at(nodes, 1.0, between) / smooth(between) - 1.0) ** 2)))
        unaware = fitted(position, noisy, suitable_size(position, 1.0))
        assert left[-1] < 0.55 * np.sqrt(np.mean((grid_at(unaware, 1.0, between) / smooth(between) - 1.0) ** 2))
    assert left[0] < 0.02
    assert left[1] < 0.01


@pytest.mark.usefixtures("who_answers")
def test_holes_are_spanned_smoothly() -> None:
    """A cosine is a paraboloid on the disc: a plate has its curvature, a membrane sags by radius squared."""
    position = disc_points(20_000, 6)
    for centre, radius in ((np.array([0.3, 0.0]), 0.15), (np.array([-0.2, 0.3]), 0.4), (np.zeros(2), 0.4)):
        kept = position[np.hypot(*(position - centre).T) > radius]
        nodes = fitted(kept, unit_from_disc(kept)[:, 2], 129)
        within = centre + radius * disc_points(500, 7)
        assert np.max(np.abs(grid_at(nodes, 1.0, within) - unit_from_disc(within)[:, 2])) < 0.2 * radius**2


@pytest.mark.usefixtures("who_answers")
def test_weights_decide_between_points_at_one_place() -> None:
    position = np.repeat(disc_points(2000, 8), 2, axis=0)
    value = np.tile([1.0, 4.0], 2000)
    weight = np.tile([2.0, 1.0], 2000)
    nodes = fit_grid(position, value, np.zeros(4000), weight, half_width=1.0, size=17)
    np.testing.assert_allclose(nodes, 2.0, rtol=1e-12)


@pytest.mark.usefixtures("who_answers")
def test_points_without_weight_value_or_place_are_passed_over() -> None:
    position = np.concatenate((disc_points(1000), [[0.1, 0.1], [0.1, 0.1], [1.5, 0.0], [np.nan, 0.0]]))
    value = np.concatenate((np.ones(1000), [99.0, np.nan, 99.0, 99.0]))
    weight = np.concatenate((np.ones(1000), [0.0, 1.0, 1.0, 1.0]))
    nodes = fit_grid(position, value, np.zeros(1004), weight, half_width=1.0, size=33)
    np.testing.assert_allclose(nodes, 1.0, rtol=1e-12)
    nothing = fit_grid(position, value, np.zeros(1004), np.zeros(1004), half_width=1.0, size=5)
    np.testing.assert_array_equal(nothing, np.zeros((5, 5)))


@pytest.mark.usefixtures("who_answers")
def test_places_on_nodes_and_rim() -> None:
    """Where all points lie on nodes, the nodes are their values."""
    x = np.linspace(-2.0, 2.0, 17)
    position = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    value = np.random.default_rng(9).normal(size=len(position))
    nodes = fit_grid(position, value, np.zeros(289), np.ones(289), half_width=2.0, size=17)
    np.testing.assert_allclose(nodes.ravel(), value, atol=1e-3)
    np.testing.assert_allclose(grid_at(nodes, 2.0, position), nodes.ravel(), rtol=1e-12)
    np.testing.assert_allclose(grid_at(nodes, 2.0, np.array([[9.0, -9.0]])), nodes[0, -1])


@pytest.mark.usefixtures("who_answers")
@pytest.mark.parametrize("size", [0, 1, 4, 100])
def test_other_sizes_are_refused(size: int) -> None:
    with pytest.raises(ValueError, match=r"2\^p \+ 1"):
        fitted(disc_points(10), np.ones(10), size)


@given(
    n=st.integers(1, 60),
    seed=st.integers(0, 2**20),
    size=st.sampled_from([2, 3, 9, 33]),
    noise=st.sampled_from([0.0, 0.1, 10.0]),
    snap=st.sampled_from([0.0, 0.25]),
)
def test_any_points_stay_within_bounds_and_numpy_agrees(
    n: int, seed: int, size: int, noise: float, snap: float
) -> None:
    random = np.random.default_rng(seed)
    position = random.uniform(-1.0, 1.0, (n, 2))
    if snap:
        position = np.round(position / snap) * snap
    arrays = (position, random.normal(size=n), np.full(n, noise**2), random.random(n) + 1e-3, 1.0, size)
    nodes = _model.fit_grid(*arrays)
    np.testing.assert_allclose(nodes, fallback.fit_grid(*arrays), atol=1e-9)
    assert np.max(np.abs(nodes)) < 20.0 * np.max(np.abs(arrays[1]))
    at = random.uniform(-1.5, 1.5, (50, 2))
    np.testing.assert_allclose(_model.grid_at(nodes, 1.0, at), fallback.grid_at(nodes, 1.0, at), atol=1e-12)


@pytest.mark.usefixtures("who_answers")
def test_suitable_size_follows_the_points() -> None:
    assert suitable_size(rings(1.0), 1.0) == 129
    assert suitable_size(rings(2.0), 1.0) == 65
    assert suitable_size(disc_points(400_000), 1.0) == 513
    assert suitable_size(np.tile(disc_points(500), (4, 1)), 1.0) <= 65
    assert suitable_size(np.zeros((0, 2)), 1.0) == 2
    assert suitable_size(np.full((5, 2), 3.0), 1.0) == 2
    disc = disc_from_unit(unit_from_disc(disc_points(30_000)))
    assert suitable_size(4.0 * disc, 4.0) == suitable_size(disc, 1.0)
