"""test_cells_cut.py: cells that end at the horizon and at their reach, against counts of nearest points; P1 weights;
the required figures of quadrature."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import Delaunay, SphericalVoronoi

from gonio.geometry.cells import Cells, cells
from gonio.geometry.directions import angle_between_deg, tangent_frame, unit_from_angles_deg
from gonio.geometry.pitch import reach_rad
from gonio.plan.spiral import spiral

FloatArray = NDArray[np.float64]
SPHERE = 4.0 * np.pi


def random_directions(n: int, seed: int) -> FloatArray:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1)[:, None])


def rotation(seed: int) -> FloatArray:
    q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def counted(points: FloatArray, reach: FloatArray, cut: bool, probes: int = 150_000) -> tuple[FloatArray, FloatArray]:
    """Areas and moments by random directions and their nearest points."""
    q = random_directions(probes, 99)
    near = q @ points.T
    if cut:
        near[(q[:, 2] >= 0.0)[:, None] != (points[:, 2] >= 0.0)] = -2.0
    own = near.argmax(axis=1)
    kept = near[np.arange(probes), own] > np.cos(reach[own])
    each = SPHERE / probes
    moment = [np.bincount(own[kept], q[kept, k], len(points)) for k in range(3)]
    return np.bincount(own[kept], minlength=len(points)) * each, np.stack(moment, axis=1) * each


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 40])
def test_cells_own_what_is_nearest_and_within_reach(n: int, cut: bool) -> None:
    points = random_directions(n, n)
    for reach in (np.full(n, np.pi), np.random.default_rng(n).uniform(0.1, 1.2, n), np.full(n, 2.0)):
        found = cells(points, reach_rad=reach, cut_at_horizon=cut)
        area, moment = counted(points, reach, cut)
        np.testing.assert_allclose(found.solid_angle_sr, area, atol=0.06)
        np.testing.assert_allclose(found.moment, moment, atol=0.06)  # four standard errors of the count
        assert found.linear_sr.sum() == pytest.approx(found.solid_angle_sr.sum(), abs=1e-9)


@pytest.mark.parametrize("n", [100, 3000])
def test_random_points_are_those_of_scipy_to_the_rounding(n: int) -> None:
    points = random_directions(n, 5)
    found = cells(points, cut_at_horizon=False)
    np.testing.assert_allclose(found.solid_angle_sr, SphericalVoronoi(points).calculate_areas(), rtol=1e-6, atol=1e-9)
    assert found.solid_angle_sr.sum() == pytest.approx(SPHERE, abs=1e-10)


def test_each_hemisphere_is_shared_among_its_own_points() -> None:
    points = random_directions(3001, 8)
    found = cells(points)
    up = points[:, 2] >= 0.0
    for side in (up, ~up):
        assert found.solid_angle_sr[side].sum() == pytest.approx(SPHERE / 2.0, abs=1e-10)
        assert found.linear_sr[side].sum() == pytest.approx(SPHERE / 2.0, abs=1e-10)
    # The projected solid angle of a hemisphere is pi.
    assert found.moment[up, 2].sum() == pytest.approx(np.pi, abs=1e-9)
    assert found.moment[~up, 2].sum() == pytest.approx(-np.pi, abs=1e-9)


@pytest.mark.parametrize("cut", [False, True])
def test_points_on_the_horizon_and_at_the_poles(cut: bool) -> None:
    """A grid with both: every ring has equal cells, P1 weights too, though the diagonals of the quads are arbitrary."""
    theta, phi = np.meshgrid(np.arange(0.0, 181.0, 10.0), np.arange(0.0, 360.0, 15.0), indexing="ij")
    found = cells(unit_from_angles_deg(theta.ravel(), phi.ravel()), cut_at_horizon=cut)
    assert found.solid_angle_sr.sum() == pytest.approx(SPHERE, abs=1e-10)
    for weight in (found.solid_angle_sr, found.linear_sr):
        rings = weight.reshape(theta.shape)
        np.testing.assert_allclose(rings, rings[:, :1] * np.ones(24), rtol=1e-6)
    half = found.solid_angle_sr[theta.ravel() <= 90.0].sum()  # the points at 90 degrees belong to the upper hemisphere
    assert half == pytest.approx(SPHERE / 2.0, abs=1e-8) or not cut


def test_a_lone_circle_owns_a_band_within_its_reach() -> None:
    points = unit_from_angles_deg(60.0, np.arange(0.0, 360.0, 0.1))
    found = cells(points, reach_rad=np.radians(1.0))
    band = 2.0 * np.pi * (np.cos(np.radians(59.0)) - np.cos(np.radians(61.0)))
    assert found.solid_angle_sr.sum() == pytest.approx(band, rel=1e-3)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 60), st.integers(0, 10_000), st.booleans(), st.floats(0.01, 1.0), st.floats(1.0, 3.0))
def test_areas_grow_with_reach_and_stay_below_the_cap(
    n: int, seed: int, cut: bool, reach: float, factor: float
) -> None:
    points = random_directions(n, seed)
    near, far = (cells(points, reach_rad=r, cut_at_horizon=cut) for r in (reach, factor * reach))
    assert np.all(near.solid_angle_sr <= far.solid_angle_sr + 1e-10)
    assert np.all(near.solid_angle_sr <= 2.0 * np.pi * (1.0 - np.cos(reach)) + 1e-10)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 80), st.integers(0, 10_000), st.sampled_from(["random", "circle", "patch", "grid"]))
def test_rotation_and_order_do_not_matter(n: int, seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    if kind == "random":
        points = random_directions(n, seed)
    elif kind == "circle":
        points = unit_from_angles_deg(40.0, 5.0 * rng.permutation(72)[: min(n, 72)])
    elif kind == "patch":
        points = unit_from_angles_deg(rng.uniform(0.0, 0.3, n), rng.uniform(0.0, 360.0, n))
    else:
        points = unit_from_angles_deg(*np.meshgrid(np.arange(10.0, 60.0, 10.0), np.arange(0.0, 90.0, 10.0))).reshape(
            -1, 3
        )
    order = rng.permutation(len(points))
    one = cells(points, reach_rad=0.4, cut_at_horizon=False)
    other = cells((points @ rotation(seed).T)[order], reach_rad=0.4, cut_at_horizon=False)
    np.testing.assert_allclose(other.solid_angle_sr, one.solid_angle_sr[order], atol=2e-7)
    np.testing.assert_allclose(other.linear_sr, one.linear_sr[order], atol=2e-7)


@settings(max_examples=30, deadline=None)
@given(st.floats(-5.0, 0.0), st.integers(1, 400), st.integers(0, 10_000))
def test_tiny_patches_own_the_cap_around_them(log_size: float, n: int, seed: int) -> None:
    """Down to where all points are one; a reach far larger than the patch makes a cap of their cells."""
    rng = np.random.default_rng(seed)
    size = 10.0**log_size
    pole = random_directions(1, seed)[0]
    points = pole + 0.5 * size * rng.standard_normal((n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for reach in (None, 30.0 * size):
        found = cells(points, reach_rad=reach, cut_at_horizon=False)
        assert np.isfinite(found.solid_angle_sr).all()
        if reach is None:
            assert found.solid_angle_sr.sum() == pytest.approx(SPHERE, abs=3e-6 if size < 1e-3 else 1e-9)
        elif reach < 1.0:
            cap = 2.0 * np.pi * (1.0 - np.cos(reach))
            assert found.solid_angle_sr.sum() == pytest.approx(cap, rel=0.3)
            assert found.solid_angle_sr.sum() >= cap * (1.0 - 1e-6) or n > 1


def test_a_flat_path_through_all_the_sphere() -> None:
    """An in-plane scan: lunes without reach, a band with it; the weights of linear interpolation are the same."""
    points = unit_from_angles_deg(
        np.abs(np.arange(-85.0, 85.01, 0.1)), np.where(np.arange(-85.0, 85.01, 0.1) < 0, 180, 0)
    )
    found = cells(points)
    assert found.solid_angle_sr.sum() == pytest.approx(SPHERE / 2.0, abs=1e-8)
    thin = cells(points, reach_rad=np.radians(0.2))
    ends = 1.0 - np.cos(np.radians(0.2))
    band = 2.0 * np.sin(np.radians(0.2)) * np.radians(170.0) + 2.0 * np.pi * ends
    assert thin.solid_angle_sr.sum() == pytest.approx(band, rel=0.02)


def test_wrong_input_is_refused() -> None:
    with pytest.raises(ValueError, match="unit length"):
        cells([[0.0, 0.0, 2.0]])
    with pytest.raises(ValueError, match="positive angle"):
        cells([[0.0, 0.0, 1.0]], reach_rad=0.0)


def scan_path(n: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """About n directions: circles of constant elevation in a tilted frame, with a little noise of the encoders, and a
    spiral about a peak."""
    track = spiral(unit_from_angles_deg(40.0, 20.0), 3.0, 0.1)
    along = np.arange(0.0, track.length_deg[-1], 0.03)
    fine = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    step = 0.2
    pitch = 41253.0 / ((n - len(fine)) * step)
    circles = []
    for k, elevation in enumerate(np.arange(-89.0, 89.0, pitch)):
        azimuth = np.arange(0.0, 360.0, step / np.cos(np.radians(elevation)))
        circles.append(unit_from_angles_deg(90.0 - elevation, azimuth[:: 1 if k % 2 else -1]))
    coarse = np.concatenate(circles) @ rotation(3)
    points = np.concatenate((coarse, fine)) + 3e-6 * np.random.default_rng(4).standard_normal(
        (len(coarse) + len(fine), 3)
    )
    path = np.concatenate((np.zeros(len(coarse), dtype=np.int64), np.ones(len(fine), dtype=np.int64)))
    return points / np.linalg.norm(points, axis=1)[:, None], path


def corrected(found: Cells) -> FloatArray:
    return 2.0 * found.solid_angle_sr - found.linear_sr


def test_cosine_over_an_irregular_path_within_a_hundredth_of_a_percent() -> None:
    points, path = scan_path(100_000)
    assert 90_000 < len(points) < 110_000
    found = cells(points, reach_rad=reach_rad(points, path))
    for up in (True, False):
        side = (points[:, 2] >= 0.0) == up
        assert np.abs(points[side, 2]) @ corrected(found)[side] == pytest.approx(np.pi, rel=1e-4)
        # And without any quadrature: the projected solid angle is exact.
        assert np.abs(found.moment[side, 2]).sum() == pytest.approx(np.pi, rel=1e-4)


@pytest.mark.parametrize("along_deg", [0.005, 0.02, 0.05])
@pytest.mark.parametrize("off_deg", [0.0, 0.013, 0.05, 0.11, 0.25, 0.4])
def test_peak_on_a_spiral_within_a_tenth_of_a_percent(along_deg: float, off_deg: float) -> None:
    """0.5 degrees full width at half maximum, pitch 0.1: Voronoi sums are 0.9 % high at the spiral's centre, linear
    ones twice as much."""
    pole = unit_from_angles_deg(50.0, 20.0)
    track = spiral(pole, 1.8, 0.1)
    along = np.arange(0.0, track.length_deg[-1], along_deg)
    points = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    points /= np.linalg.norm(points, axis=1)[:, None]
    found = cells(points, reach_rad=reach_rad(points, np.zeros(len(points), dtype=np.int64)))
    sigma = np.radians(0.5) / np.sqrt(8.0 * np.log(2.0))
    exact = 2.0 * np.pi * sigma**2 * (1.0 - sigma**2 / 3.0)
    e1, e2, _ = tangent_frame(pole)
    for turn in (0.0, 2.1, 4.0):
        o = np.radians(off_deg)
        centre = np.cos(o) * pole + np.sin(o) * (np.cos(turn) * e1 + np.sin(turn) * e2)
        peak = np.exp(-0.5 * (np.radians(angle_between_deg(points, centre)) / sigma) ** 2)
        assert peak @ corrected(found) == pytest.approx(exact, rel=1e-3)
        if off_deg == 0.0 and along_deg < 0.05:
            voronoi, linear = (peak @ w / exact - 1.0 for w in (found.solid_angle_sr, found.linear_sr))
            assert 0.007 < voronoi < 0.011
            assert linear == pytest.approx(2.0 * voronoi, rel=0.1)


def test_rings_of_equal_azimuths_err_as_spirals_do() -> None:
    """Concentric rings with the same azimuths: all quads are cocircular, and P1 must still be twice as wrong as V."""
    pole = unit_from_angles_deg(50.0, 20.0)
    radius, azimuth = np.meshgrid(np.arange(0.05, 1.8, 0.1), np.arange(0.0, 360.0, 3.0), indexing="ij")
    around = unit_from_angles_deg(radius.ravel(), azimuth.ravel()) @ tangent_frame(pole)
    sigma = np.radians(0.5) / np.sqrt(8.0 * np.log(2.0))
    exact = 2.0 * np.pi * sigma**2 * (1.0 - sigma**2 / 3.0)
    peak = np.exp(-0.5 * (np.radians(radius.ravel()) / sigma) ** 2)
    found = cells(around, reach_rad=np.radians(0.15))
    assert peak @ found.solid_angle_sr == pytest.approx(peak @ found.linear_sr, rel=0.02)
    assert peak @ found.solid_angle_sr / exact - 1.0 > 0.005
    assert peak @ corrected(found) == pytest.approx(exact, rel=2e-3)


def test_linear_weights_are_thirds_of_planar_triangles() -> None:
    """A fine patch is nearly flat: the weights of its inner points against scipy's planar Delaunay triangles."""
    xy = 0.01 * np.random.default_rng(6).uniform(-1.0, 1.0, (600, 2))
    points = np.concatenate((xy, np.ones((len(xy), 1))), axis=1)
    points /= np.linalg.norm(points, axis=1)[:, None]
    flat = points[:, :2]
    corners = Delaunay(flat).simplices
    u, v = (flat[corners[:, k]] - flat[corners[:, 0]] for k in (1, 2))
    third = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 6.0
    expected = np.bincount(corners.ravel(), np.repeat(third, 3))
    found = cells(points, reach_rad=0.01, cut_at_horizon=False)
    deep = (np.abs(flat) < 0.007).all(axis=1)
    np.testing.assert_allclose(found.linear_sr[deep], expected[deep], rtol=1e-3)
    assert found.linear_sr.sum() == pytest.approx(found.solid_angle_sr.sum(), rel=1e-12)
