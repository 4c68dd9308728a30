"""test_polar_grid.py: images by nearest point and the scatter plane, on functions whose value is known everywhere."""

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_bsdf import distribution, sphere_points

from gonio.geometry.directions import unit_from_angles_deg
from gonio.report.polar_grid import hemisphere_image, plane_directions, plane_profile


def pixel(size: int, x: float, y: float) -> tuple[int, int]:
    """Row and column of a place in degrees from the pole."""
    return int((y / 90 + 1) / 2 * size), int((x / 90 + 1) / 2 * size)


@pytest.mark.parametrize("half", ["front", "back"])
def test_x_is_right_and_y_is_up(half) -> None:  # type: ignore[no-untyped-def]
    """DSF = 2 + x + y / 2 is largest to the right, then above."""
    d = distribution((0, 0), sphere_points(5000), lambda u: 2 + u[:, 0] + u[:, 1] / 2)
    image = hemisphere_image(d, half, 200)
    assert image is not None
    for x, y in ((60.0, 0.0), (0.0, 60.0), (-60.0, 0.0), (0.0, -60.0), (30.0, 30.0)):
        r = np.radians(np.hypot(x, y))
        expected = 2 + np.sin(r) * (x + y / 2) / np.hypot(x, y)
        assert image.dsf_per_sr[pixel(200, x, y)] == pytest.approx(expected, abs=0.05)
    assert np.isnan(image.dsf_per_sr[0, 0])


def test_masked_and_missing_places_show_nothing() -> None:
    d = distribution((30, 0), sphere_points(5000), lambda u: np.ones(len(u)), masked_below_deg=10)
    image = hemisphere_image(d, "front", 200)
    assert image is not None
    at_source, elsewhere = pixel(200, 30, 0), pixel(200, -30, 0)
    assert image.masked[at_source]
    assert np.isnan(image.dsf_per_sr[at_source])
    assert not image.masked[elsewhere]
    assert image.dsf_per_sr[elsewhere] == 1
    keep = d.theta_deg < 40
    for name in ("theta_deg", "phi_deg", "dsf_per_sr", "flags"):
        setattr(d, name, getattr(d, name)[keep])
    image = hemisphere_image(d, "front", 200)
    assert image is not None
    assert np.isnan(image.dsf_per_sr[pixel(200, -80, 0)])
    assert hemisphere_image(d, "back") is None


@pytest.mark.parametrize("phi_i", [0.0, 77.0, 180.0])
def test_profile_is_signed_towards_the_mirror_side(phi_i: float) -> None:
    d = distribution((30.0, phi_i), sphere_points(20000), lambda u: np.ones(len(u)))
    profile = plane_profile(d)
    assert len(profile.angle_deg) >= 40
    assert np.all(np.diff(profile.angle_deg) >= 0)
    right = unit_from_angles_deg(d.theta_deg[profile.index], d.phi_deg[profile.index])
    along = plane_directions(d, profile.angle_deg)
    apart = np.degrees(np.arccos(np.clip((right * along).sum(axis=1), -1, 1)))
    assert apart.max() <= profile.band_deg + 1e-9
    mirror = plane_directions(d, np.array([30.0]))[0]
    np.testing.assert_allclose(mirror, unit_from_angles_deg(30.0, phi_i + 180.0), atol=1e-12)


def plane_points(step_deg: float) -> NDArray[np.float64]:
    """Front directions in the plane y = 0, unit vectors (n, 3)."""
    angle = np.radians(np.arange(-90 + step_deg / 2, 90, step_deg))
    return np.stack((-np.sin(angle), np.zeros(len(angle)), np.cos(angle)), axis=1)


def test_band_is_narrow_where_the_plane_itself_was_measured() -> None:
    """Points exactly in the plane, among many beside it, are shown alone; without them the band grows."""
    plane = unit_from_angles_deg(
        np.abs(np.arange(-89.75, 90, 0.5)), np.where(np.arange(-89.75, 90, 0.5) > 0, 180.0, 0.0)
    )
    around = sphere_points(3000)

    def flat(u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.ones(len(u))

    measured = plane_profile(distribution((30, 0), np.concatenate([around[around[:, 2] > 0], plane]), flat))
    sparse = plane_profile(distribution((30, 0), around, flat))
    assert measured.band_deg == 0.05
    assert len(measured.angle_deg) >= len(plane)
    assert sparse.band_deg > 0.5


def test_many_points_are_thinned_but_keep_their_place() -> None:
    units = np.concatenate([plane_points(0.03), [[0.0, 1.0, 0.0]]])
    profile = plane_profile(distribution((30, 0), units, lambda u: u[:, 2]))
    assert len(profile.angle_deg) <= 12 * 360
    np.testing.assert_allclose(profile.dsf_per_sr, np.cos(np.radians(profile.angle_deg)), atol=1e-9)
    assert np.diff(profile.angle_deg).max() < 0.1
