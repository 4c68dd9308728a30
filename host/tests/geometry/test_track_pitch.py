"""test_track_pitch.py: the distance of neighbouring tracks on paths whose pitch is known, and the reach at a seam."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.geometry.pitch import path_pitch_rad, reach_rad
from gonio.plan.spiral import spiral

FloatArray = NDArray[np.float64]


def one_path(points: FloatArray) -> NDArray[np.int64]:
    return np.zeros(len(points), dtype=np.int64)


def flown_spiral(pitch_deg: float, radius_deg: float, along_deg: float) -> FloatArray:
    track = spiral(unit_from_angles_deg(50.0, 20.0), radius_deg, pitch_deg)
    along = np.arange(0.0, track.length_deg[-1], along_deg)
    points = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    return np.asarray(points / np.linalg.norm(points, axis=1)[:, None])


def circles(elevations: FloatArray, step_deg: float, *, serpentine: bool = True) -> FloatArray:
    """Circles of constant elevation, there and back, as an arm flies them."""
    azimuth = np.arange(0.0, 360.0, step_deg)
    flown = [unit_from_angles_deg(90.0 - e, azimuth[:: -1 if serpentine and k % 2 else 1])
             for k, e in enumerate(elevations)]  # fmt: skip
    return np.concatenate(flown)


@pytest.mark.parametrize(("pitch_deg", "along_deg"), [(0.1, 0.01), (0.1, 0.05), (0.3, 0.3), (1.0, 0.03)])
def test_spiral(pitch_deg: float, along_deg: float) -> None:
    points = flown_spiral(pitch_deg, 30.0 * pitch_deg, along_deg)
    found = np.degrees(path_pitch_rad(points, one_path(points)))
    away = angle_between_deg(points, unit_from_angles_deg(50.0, 20.0)) > 2.0 * pitch_deg
    np.testing.assert_allclose(found[away], pitch_deg, rtol=0.12)
    assert np.all((found > 0.5 * pitch_deg) & (found < 1.5 * pitch_deg))


def test_circles_of_constant_elevation_are_apart_by_their_elevation() -> None:
    points = circles(np.arange(-60.0, 60.1, 4.0), 0.05)
    np.testing.assert_allclose(np.degrees(path_pitch_rad(points, one_path(points))), 4.0, rtol=0.15)


def test_noise_and_rests_change_little() -> None:
    points = circles(np.arange(-60.0, 60.1, 4.0), 0.05)
    points = np.concatenate((np.tile(points[:1], (3000, 1)), points, np.tile(points[-1:], (3000, 1))))
    points = points + 1e-5 * np.random.default_rng(1).standard_normal(points.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    np.testing.assert_allclose(np.degrees(path_pitch_rad(points, one_path(points))), 4.0, rtol=0.2)


def test_serpentine_with_its_sharp_turns() -> None:
    across, along = np.meshgrid(np.arange(-3.0, 3.0, 0.2), np.arange(-3.0, 3.0, 0.01), indexing="ij")
    along[1::2] = along[1::2, ::-1]
    points = unit_from_angles_deg(90.0 - across.ravel(), 30.0 + along.ravel())
    np.testing.assert_allclose(np.degrees(path_pitch_rad(points, one_path(points))), 0.2, rtol=0.15)


def test_single_circle_has_its_samples_distance() -> None:
    for elevation in (0.0, 60.0):
        points = circles(np.array([elevation]), 0.1)
        expected = 0.1 * np.cos(np.radians(elevation))
        np.testing.assert_allclose(np.degrees(path_pitch_rad(points, one_path(points))), expected, rtol=1e-3)


def test_crossing_profiles_do_not_make_each_other_coarse() -> None:
    theta = np.arange(-80.0, 80.0, 0.2)
    profile = [unit_from_angles_deg(np.abs(theta), np.where(theta < 0.0, phi + 180.0, phi)) for phi in (0.0, 90.0)]
    path = np.repeat([0, 1], len(theta))
    np.testing.assert_allclose(np.degrees(path_pitch_rad(np.concatenate(profile), path)), 0.2, rtol=1e-3)


def test_circles_flown_one_by_one_are_taken_together() -> None:
    points = circles(np.arange(-20.0, 20.1, 4.0), 0.1)
    path = np.repeat(np.arange(11), len(points) // 11)
    np.testing.assert_allclose(np.degrees(path_pitch_rad(points, path)), 4.0, rtol=0.15)


def test_interleaved_passes_have_their_own_pitch() -> None:
    """Two passes of 8 degrees each, 4 degrees apart."""
    parts = [circles(np.arange(start, 60.1, 8.0), 0.05) for start in (-60.0, -56.0)]
    path = np.concatenate([np.full(len(part), k) for k, part in enumerate(parts)])
    np.testing.assert_allclose(np.degrees(path_pitch_rad(np.concatenate(parts), path)), 8.0, rtol=0.15)


def test_scattered_points() -> None:
    theta, phi = np.meshgrid(np.arange(5.0, 90.0, 5.0), np.arange(0.0, 360.0, 5.0), indexing="ij")
    grid = unit_from_angles_deg(np.append(theta.ravel(), 0.0), np.append(phi.ravel(), 0.0))
    found = np.degrees(path_pitch_rad(grid, np.full(len(grid), -1)))
    assert found.max() <= 5.0 + 1e-9
    ring_spacing = 5.0 * np.sin(np.radians(theta.ravel()))
    assert np.all(found[:-1] >= np.minimum(ring_spacing, 5.0) * 0.99)
    assert np.degrees(path_pitch_rad([[0.0, 0.0, 1.0]], [-1])) == pytest.approx(180.0)
    # Repeated points have the pitch of one.
    twice = path_pitch_rad(np.tile(grid, (2, 1)), np.full(2 * len(grid), -1))
    np.testing.assert_allclose(np.degrees(twice), np.tile(found, 2))


def test_the_border_of_a_spiral_meets_the_coarse_track_around_it() -> None:
    fine = flown_spiral(0.1, 3.0, 0.03)
    coarse = circles(np.arange(-80.0, 80.1, 4.0), 0.1)
    points = np.concatenate((coarse, fine))
    path = np.concatenate((one_path(coarse), one_path(fine) + 1))
    reach = np.degrees(reach_rad(points, path))[len(coarse) :]
    off = angle_between_deg(fine, unit_from_angles_deg(50.0, 20.0))
    coarse_near = np.min([angle_between_deg(fine, one) for one in coarse[np.abs(coarse @ fine[0]) > 0.99][::5]], axis=0)
    np.testing.assert_allclose(reach[(off < 2.5) & (coarse_near > 0.5)], 0.15, rtol=0.2)
    assert np.median(reach[off > 2.97]) == pytest.approx(6.0, rel=0.15)
    # Alone it reaches nowhere.
    alone = np.degrees(reach_rad(fine, one_path(fine)))
    assert alone.max() < 0.25


def test_turnarounds_crossings_and_near_approaches_do_not_shrink_it() -> None:
    """A zigzag's strokes touch at one end and are two steps apart at the other; a leg beside the circles is near."""
    swing = np.linspace(0.0, 20.0, 40_001)
    points = unit_from_angles_deg(60.0 + 60.0 * np.abs(swing % 2.0 - 1.0), 4.0 * swing)
    found = np.degrees(path_pitch_rad(points, one_path(points)))
    assert found.min() > 3.0
    assert found.max() < 9.0
    points = circles(np.arange(-60.0, 60.1, 4.0), 0.05)
    leg = circles(np.array([0.3]), 0.05)
    points = np.concatenate((points, leg[:2000], points[::-1]))
    assert np.degrees(path_pitch_rad(points, one_path(points))).min() > 3.0


def test_no_points() -> None:
    assert path_pitch_rad(np.zeros((0, 3)), []).shape == (0,)
    assert reach_rad(np.zeros((0, 3)), []).shape == (0,)
