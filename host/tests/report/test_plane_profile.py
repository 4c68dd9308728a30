"""test_plane_profile.py: the scatter plane: which points, their means and uncertainties, and where it has gaps."""

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_bsdf import distribution, sphere_points

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.report.plane_figure import on_side
from gonio.report.plane_profile import plane_angles_deg, plane_directions, plane_profile


@pytest.mark.parametrize("phi_i", [0.0, 77.0, 180.0])
def test_profile_is_signed_towards_the_mirror_side(phi_i: float) -> None:
    d = distribution((30.0, phi_i), sphere_points(20000), lambda u: np.ones(len(u)))
    profile = plane_profile(d)
    assert len(profile.angle_deg) >= 35
    assert np.all(np.diff(profile.angle_deg) >= 0)
    right = unit_from_angles_deg(d.theta_deg[profile.point], d.phi_deg[profile.point])
    along = plane_directions(d, plane_angles_deg(d)[0][profile.point])
    apart = np.degrees(np.arccos(np.clip((right * along).sum(axis=1), -1, 1)))
    assert apart.max() <= profile.band_deg + 1e-9
    mirror = plane_directions(d, np.array([30.0]))[0]
    np.testing.assert_allclose(mirror, unit_from_angles_deg(30.0, phi_i + 180.0), atol=1e-12)


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


def on_plane(angle_deg: NDArray[np.float64], dsf: NDArray[np.float64], variance: float) -> Distribution:
    """Points in the plane of incidence at signed angles, source at (30, 0), without cells."""
    unit = np.stack((-np.sin(np.radians(angle_deg)), np.zeros(len(angle_deg)), np.cos(np.radians(angle_deg))), axis=1)
    theta, phi = angles_deg_from_unit(unit)
    n = len(theta)
    return Distribution(
        30.0,
        0.0,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=dsf,
        variance_per_sr2=np.full(n, variance),
        signal=dsf,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=np.full(n, 1e-3),
        time_ns=np.zeros(n, dtype=np.int64),
    )


def test_bins_hold_means_and_their_uncertainty() -> None:
    """Four points per bin: noise falls by two, a common effect stays, one of alternating sign cancels."""
    angle = (np.arange(-4000, 4000) + 0.5) * 0.025 / 2
    d = on_plane(angle, 5.0 + 0.01 * angle, 0.04**2)
    d.effects = {"p_i": 0.003 * d.dsf_per_sr, "linearity": np.where(np.arange(8000) % 2, 1.0, -1.0)}
    profile = plane_profile(d, bin_deg=0.05)
    assert len(profile.angle_deg) == 2000
    np.testing.assert_allclose(profile.dsf_per_sr, 5.0 + 0.01 * profile.angle_deg, atol=1e-9)
    np.testing.assert_allclose(profile.u_independent, 0.02, rtol=1e-9)
    expected = np.hypot(0.02, 0.003 * profile.dsf_per_sr)
    np.testing.assert_allclose(profile.u_combined, expected, rtol=1e-9)
    np.testing.assert_allclose(profile.mean(d.theta_deg[profile.point]), np.abs(profile.angle_deg), atol=1e-9)


def test_lines_break_where_points_are_masked_or_missing() -> None:
    angle = np.concatenate([np.arange(-80, -40, 0.2), np.arange(-20, 80, 0.2)])
    d = on_plane(angle, np.ones(len(angle)), 1e-6)
    shaded = (angle > 28.1) & (angle < 31.9)
    d.flags[shaded] = PointFlag.SHADOWED
    d.dsf_per_sr[shaded] = np.nan
    profile = plane_profile(d)
    ends = profile.angle_deg[np.flatnonzero(profile.gap_before)]
    np.testing.assert_allclose(ends, [-20.0, 32.0], atol=1e-6)
    np.testing.assert_allclose(profile.masked_deg, [[28.2, 31.8]], atol=1e-6)
    assert not np.isnan(profile.dsf_per_sr).any()


def test_negative_noise_stays_in_the_profile() -> None:
    angle = np.arange(-80, 80, 0.2)
    d = on_plane(angle, np.where(np.arange(len(angle)) % 2, 1e-3, -1e-3), 1e-6)
    profile = plane_profile(d, bin_deg=0.1)
    assert (profile.dsf_per_sr < 0).sum() == pytest.approx(len(angle) / 2, abs=2)


def test_the_back_half_is_folded_to_the_nearer_normal() -> None:
    """Rising again, and with the gap before the bin that follows it."""
    angle = np.concatenate([np.arange(-179.9, -120, 0.2), np.arange(100.1, 120, 0.2), np.arange(150.1, 180, 0.2)])
    d = on_plane(angle, 2.0 + np.abs(angle), 1e-6)
    side = on_side(plane_profile(d), "back")
    assert np.all(np.diff(side.angle_deg) > 0)
    folded = np.where(side.angle_deg > 0, 180 - side.angle_deg, 180 + side.angle_deg)
    np.testing.assert_allclose(side.dsf_per_sr, 2.0 + folded, atol=1e-6)
    before = side.angle_deg[np.flatnonzero(side.gap_before) - 1]
    np.testing.assert_allclose(before, [29.9], atol=1e-6)  # folded 150.1: the measured stretch goes on at 60
    assert len(on_side(plane_profile(d), "front").angle_deg) == 0
