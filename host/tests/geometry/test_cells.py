"""test_cells.py: cell areas against scipy's SphericalVoronoi, solids known since antiquity, and the sum 4 pi."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import SphericalVoronoi

from gonio.geometry.cells import covered_cells_sr, solid_angles_sr
from gonio.geometry.directions import unit_from_angles_deg

SPHERE = 4.0 * np.pi


def random_directions(n: int, seed: int) -> NDArray[np.float64]:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1)[:, None])


@pytest.mark.parametrize("n", [4, 5, 10, 300, 20_000])
def test_random_points_against_scipy(n: int) -> None:
    points = random_directions(n, n)
    areas = solid_angles_sr(points)
    assert areas.sum() == pytest.approx(SPHERE, abs=1e-9)
    if n <= 300:
        np.testing.assert_allclose(areas, SphericalVoronoi(points).calculate_areas(), rtol=1e-9)


def test_monte_carlo_agrees_when_all_points_lie_in_a_cap() -> None:
    """The far side of the sphere goes to the border points; scipy's areas are wrong there, so count nearest points."""
    rng = np.random.default_rng(5)
    points = unit_from_angles_deg(rng.uniform(0.0, 20.0, 12), rng.uniform(0.0, 360.0, 12))
    probes = random_directions(400_000, 6)
    share = np.bincount(np.argmax(probes @ points.T, axis=1), minlength=12) / len(probes)
    np.testing.assert_allclose(solid_angles_sr(points) / SPHERE, share, atol=4.0 * 0.5 / np.sqrt(len(probes)))


def test_regular_solids_have_equal_cells() -> None:
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    octahedron = np.concatenate((np.eye(3), -np.eye(3)))
    tetrahedron = signs[signs.prod(axis=1) > 0] / np.sqrt(3.0)
    for points in (signs / np.sqrt(3.0), octahedron, tetrahedron):
        np.testing.assert_allclose(solid_angles_sr(points), SPHERE / len(points), rtol=1e-12)


def test_grid_of_cocircular_points() -> None:
    """Every cell of a latitude-longitude grid is bounded by circles half way: but those on parallels are great circles,
    so compare within a ring by symmetry and the pole with its regular polygon."""
    theta, phi = np.meshgrid(np.arange(10.0, 180.0, 10.0), np.arange(0.0, 360.0, 10.0), indexing="ij")
    points = np.concatenate((unit_from_angles_deg(theta.ravel(), phi.ravel()), [[0, 0, 1], [0, 0, -1]]))
    areas = solid_angles_sr(points)
    assert areas.sum() == pytest.approx(SPHERE, abs=1e-10)
    rings = areas[:-2].reshape(theta.shape)
    np.testing.assert_allclose(rings, rings[:, :1] * np.ones(36), rtol=1e-9)
    # Regular spherical polygon, 36 sides, inscribed radius 5 degrees: excess by its 72 right triangles.
    inner, corner = np.radians(5.0), np.radians(5.0)
    base = np.arctan(np.tan(corner) * np.sin(inner))
    triangle = 2.0 * np.arctan(np.tan(inner / 2.0) * np.tan(base / 2.0))
    np.testing.assert_allclose(areas[-2:], 72.0 * triangle, rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0.0, 180.0), st.floats(0.0, 360.0), st.integers(1, 3), st.sampled_from([0.0, 1e-9, 1e-5])),
        min_size=1,
        max_size=40,
    )
)
def test_any_points_fill_the_sphere(directions: list[tuple[float, float, int, float]]) -> None:
    theta, phi = [], []
    for theta_deg, phi_deg, repeats, apart_deg in directions:
        theta += [theta_deg + apart_deg * k for k in range(repeats)]
        phi += [phi_deg] * repeats
    areas = solid_angles_sr(unit_from_angles_deg(theta, phi))
    assert areas.sum() == pytest.approx(SPHERE, abs=1e-9)
    assert areas.min() >= -1e-12


@settings(max_examples=30, deadline=None)
@given(st.integers(4, 60), st.integers(0, 10_000), st.integers(2, 5))
def test_repeated_points_share_one_cell(n: int, seed: int, repeats: int) -> None:
    points = random_directions(n, seed)
    alone = solid_angles_sr(points)
    together = solid_angles_sr(np.tile(points, (repeats, 1))).reshape(repeats, n)
    np.testing.assert_allclose(together, np.tile(alone / repeats, (repeats, 1)), rtol=1e-12)


@pytest.mark.parametrize("tilt_deg", [0.0, 20.0])
def test_points_on_one_circle_own_lunes(tilt_deg: float) -> None:
    phi = np.array([0.0, 10.0, 40.0, 100.0, 250.0])
    expected = np.radians([120.0, 40.0, 90.0, 210.0, 260.0])
    areas = solid_angles_sr(unit_from_angles_deg(90.0 - tilt_deg, phi))
    np.testing.assert_allclose(areas, expected, rtol=1e-9)
    # The same with the circle not quite plane, as measured in-plane data are.
    theta = 90.0 - tilt_deg + 1e-5 * np.array([1, -1, 0.5, -0.3, 0.2])
    np.testing.assert_allclose(solid_angles_sr(unit_from_angles_deg(theta, phi)), expected, rtol=1e-3)


def test_few_points() -> None:
    assert solid_angles_sr(np.zeros((0, 3))).shape == (0,)
    np.testing.assert_allclose(solid_angles_sr([[0.0, 0.0, 1.0]]), [SPHERE])
    np.testing.assert_allclose(solid_angles_sr([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]]), [SPHERE / 2] * 2)
    np.testing.assert_allclose(solid_angles_sr([[0.0, 0.6, 0.8]] * 3), [SPHERE / 3] * 3)
    with pytest.raises(ValueError, match="unit length"):
        solid_angles_sr([[0.0, 0.0, 2.0]])


def test_flown_track_of_circles_with_rests_and_repeats() -> None:
    """A dense track (0.2 degrees between samples, 6 degrees between circles) that rests at its ends."""
    phi = np.arange(0.0, 360.0, 0.2)
    circles = [unit_from_angles_deg(theta, phi) for theta in np.arange(3.0, 180.0, 6.0)]
    points = np.concatenate([np.tile(circles[0][:1], (500, 1)), *circles])
    areas = solid_angles_sr(points)
    assert areas.sum() == pytest.approx(SPHERE, abs=1e-9)
    # The ring at 45 degrees owns the sphere between 42 and 48 degrees, to the small sagitta of its borders.
    ring = areas[500 + 7 * len(phi) : 500 + 8 * len(phi)]
    expected = 2.0 * np.pi * (np.cos(np.radians(42.0)) - np.cos(np.radians(48.0)))
    assert ring.sum() == pytest.approx(expected, rel=1e-6)


def test_covered_cells_end_at_the_directions_they_surround() -> None:
    """An octant with points at its corners and inside: its area is pi / 2, its first moment pi / 4 along each axis."""
    inside = np.abs(random_directions(400, 3))
    areas, moments = covered_cells_sr(np.concatenate((np.eye(3), inside)))
    assert areas.sum() == pytest.approx(np.pi / 2.0, abs=3e-4)
    np.testing.assert_allclose(moments.sum(axis=0), np.pi / 4.0, atol=3e-4)
    np.testing.assert_allclose(areas[:3].max(), areas[:3], atol=0.02)


def test_moments_of_small_cells_point_at_their_middle() -> None:
    points = random_directions(5000, 4)
    areas, moments = covered_cells_sr(points)
    np.testing.assert_allclose(areas, solid_angles_sr(points), rtol=1e-9)
    np.testing.assert_allclose(moments.sum(axis=0), 0.0, atol=1e-9)
    # A vector's length is the cell's area less what its spread takes, of second order in the radius.
    length = np.linalg.norm(moments, axis=1)
    assert np.all(length < areas)
    np.testing.assert_allclose(length, areas, rtol=0.01)


def test_directions_in_a_plane_surround_nothing() -> None:
    points = unit_from_angles_deg(np.arange(0.0, 90.0, 5.0), np.full(18, 20.0))
    areas, moments = covered_cells_sr(points)
    assert areas.sum() == pytest.approx(0.0, abs=1e-3)
    assert np.abs(moments).max() == pytest.approx(0.0, abs=1e-3)
    assert covered_cells_sr(points[:2])[0].tolist() == [0.0, 0.0]
