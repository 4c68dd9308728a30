"""test_interpolation.py: weights of linear interpolation on the triangles: exact at points and for what is linear."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.interpolate import Interpolation

FloatArray = NDArray[np.float64]


def random_directions(n: int, seed: int) -> FloatArray:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1)[:, None])


@settings(max_examples=30, deadline=None)
@given(st.integers(4, 300), st.integers(0, 10_000), st.booleans())
def test_points_are_met_exactly_and_weights_add_up(n: int, seed: int, cut: bool) -> None:
    points = random_directions(n, seed)
    values = np.random.default_rng(seed).uniform(size=n)
    between = Interpolation(points, cut_at_horizon=cut)
    np.testing.assert_allclose(between.at(points).of(values), values, atol=1e-4)
    found = between.at(random_directions(200, seed + 1))
    assert np.all(found.weight >= 0.0)
    np.testing.assert_allclose(found.weight[found.inside].sum(axis=1), 1.0)
    assert np.all(found.weight[~found.inside] == 0.0)


def test_a_linear_function_on_the_triangles_planes() -> None:
    """Where the ray meets the triangle's plane the three corners add up to a place on the ray."""
    points, wanted = random_directions(2000, 1), random_directions(5000, 2)
    found = Interpolation(points, cut_at_horizon=False).at(wanted)
    place = np.einsum("ij,ijk->ik", found.weight, points[found.index])
    place /= np.linalg.norm(place, axis=1)[:, None]
    np.testing.assert_allclose(place, wanted, atol=1e-9)
    # The triangle is Delaunay's: no point lies inside its circumscribed circle.
    corners = points[found.index[:200]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal *= np.sign(np.einsum("ij,ij->i", normal, corners[:, 0]))[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = points @ normal.T - np.einsum("ij,ij->i", normal, corners[:, 0])
    assert height.max() < 1e-9


def test_error_falls_with_the_square_of_the_spacing() -> None:
    wanted = random_directions(5000, 3)

    def smooth(unit: FloatArray) -> FloatArray:
        return np.asarray(np.exp(unit @ [0.3, -0.5, 0.8]))

    errors = []
    for n in (2000, 32_000):
        points = random_directions(n, 4)
        off = Interpolation(points, cut_at_horizon=False).at(wanted).of(smooth(points)) - smooth(wanted)
        errors.append(float(np.sqrt(np.mean(off**2))))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.4)


def test_reach_ends_what_is_known() -> None:
    points = unit_from_angles_deg(
        *(axis.ravel() for axis in np.meshgrid(np.arange(20.0, 60.0, 2.0), np.arange(0.0, 90.0, 2.0)))
    )
    between = Interpolation(points, reach_rad=np.radians(3.0))
    found = between.at(unit_from_angles_deg([40.0, 40.0, 40.0, 10.0, 140.0], [45.0, 200.0, 91.0, 45.0, 45.0]))
    assert found.inside.tolist() == [True, False, False, False, False]
    assert np.isnan(found.of(np.ones(len(points)))[1:]).all()


def test_hemispheres_know_nothing_of_each_other() -> None:
    points = random_directions(4000, 5)
    values = np.where(points[:, 2] >= 0.0, 1.0, 7.0)
    wanted = random_directions(20_000, 6)
    found = Interpolation(points).at(wanted)
    assert found.inside.all()
    np.testing.assert_allclose(found.of(values), np.where(wanted[:, 2] >= 0.0, 1.0, 7.0))
    one_side = Interpolation(points[points[:, 2] >= 0.0]).at(wanted)
    np.testing.assert_array_equal(one_side.inside, wanted[:, 2] >= 0.0)


def test_points_in_a_plane_stand_for_their_reach() -> None:
    points = unit_from_angles_deg(np.arange(0.0, 80.1, 1.0), 20.0)
    found = Interpolation(points, reach_rad=np.radians(1.0)).at(
        unit_from_angles_deg([40.2, 40.0, 100.0], [20.0, 60.0, 20.0])
    )
    assert found.inside.tolist() == [True, False, False]
    assert found.of(np.arange(81.0))[0] == pytest.approx(40.0)


def test_no_points() -> None:
    found = Interpolation(np.zeros((0, 3))).at([[0.0, 0.0, 1.0]])
    assert not found.inside.any()
