"""test_patch_average.py: patch averages of points whose answer is known in closed form."""

import numpy as np
import pytest
from synthetic_bsdf import distribution, lambert_and_mirror, lobe_per_sr, sphere_points, spiral_about

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.formats.window.klems import BASES
from gonio.formats.window.patch_average import hemisphere_profile
from gonio.geometry.directions import unit_from_angles_deg

FULL = BASES["klems-full"]
SIZE = FULL.projected_solid_angle_sr


def upper(d: Distribution, turn_deg: float = 0.0):  # type: ignore[no-untyped-def]
    return hemisphere_profile(FULL, d, d.theta_deg, d.phi_deg + turn_deg)


@pytest.mark.parametrize("count", [600, 3000, 20000])
def test_lambertian_has_one_value_everywhere(count: int) -> None:
    d = distribution((0, 0), sphere_points(count), lambda u: 0.5 / np.pi * np.abs(u[:, 2]))
    values = upper(d).patches()
    # Exact but at the horizon, where a cell's mean cosine bounds the division.
    np.testing.assert_allclose(values.bsdf_per_sr[:-12], 0.5 / np.pi, rtol=1e-9)
    assert values.bsdf_per_sr @ SIZE == pytest.approx(0.5, rel=2e-3)
    assert not values.filled.any()


def test_long_cells_of_a_fly_scan_count_once() -> None:
    """Samples at most 0.1 degrees apart on circles 6 degrees apart: most cells hold no direction of the grid."""
    theta_deg, phi_deg = (v.ravel() for v in np.meshgrid(np.arange(3.0, 90.0, 6.0), np.arange(0.0, 360.0, 0.1)))
    unit = unit_from_angles_deg(theta_deg, phi_deg)
    d = distribution((0, 0), unit, lambda u: 0.3 / np.pi * np.abs(u[:, 2]))
    values = upper(d).patches()
    # A strip takes its middle's cosine: a large cell may be off by the change of the cosine over it.
    assert np.pi * values.bsdf_per_sr[:-12] == pytest.approx(0.3, rel=0.02)
    assert values.bsdf_per_sr @ SIZE == pytest.approx(0.3, rel=0.01)


def test_energy_of_a_peak_is_that_of_its_points() -> None:
    d = lambert_and_mirror((30.0,)).distributions[0]
    front = (d.theta_deg < 90) & d.measured
    direct = float(np.sum(d.dsf_per_sr[front] * d.solid_angle_sr[front]))
    values = upper(d).patches()
    assert values.bsdf_per_sr @ SIZE == pytest.approx(direct, rel=1e-3)
    peak = int(FULL.patch_of(30, 180))
    assert values.bsdf_per_sr[peak] * SIZE[peak] == pytest.approx(0.2 + 0.5 / np.pi * SIZE[peak], rel=0.01)


@pytest.mark.parametrize("turn_deg", [18.0, 45.0, 333.0])
def test_turning_the_profile_is_turning_the_points(turn_deg: float) -> None:
    d = lambert_and_mirror((30.0,)).distributions[0]
    shifted = upper(d).shifted(turn_deg).patches().bsdf_per_sr
    turned = upper(d, turn_deg).patches().bsdf_per_sr
    np.testing.assert_allclose(shifted, turned, rtol=0.02)
    assert shifted @ SIZE == pytest.approx(turned @ SIZE, rel=1e-3)


def test_smearing_keeps_energy_and_moves_nothing() -> None:
    profile = upper(lambert_and_mirror((30.0,)).distributions[0])
    plain, smeared = profile.patches().bsdf_per_sr, profile.smeared(18.0).patches().bsdf_per_sr
    assert smeared @ SIZE == pytest.approx(plain @ SIZE, rel=1e-6)
    assert np.argmax(smeared) == np.argmax(plain)
    neighbours = [int(FULL.patch_of(30, 180 - 18)), int(FULL.patch_of(30, 180 + 18))]
    assert smeared[neighbours[0]] == pytest.approx(smeared[neighbours[1]], rel=0.02)


def test_masked_points_count_as_not_measured_and_empty_patches_are_filled() -> None:
    d = distribution((0, 0), sphere_points(3000), lambda u: 0.5 / np.pi * np.abs(u[:, 2]), masked_below_deg=30)
    values = upper(d).patches()
    assert values.filled[:25].all()  # rings up to 25 degrees
    assert values.coverage[:25].max() == pytest.approx(0, abs=1e-12)
    assert not values.filled[45:].any()
    np.testing.assert_allclose(values.bsdf_per_sr, 0.5 / np.pi, rtol=0.1)


def test_a_hemisphere_without_values_has_no_profile() -> None:
    d = distribution((0, 0), sphere_points(800), lambda u: np.abs(u[:, 2]))
    d.flags[d.theta_deg > 90] = PointFlag.UNREACHABLE
    assert hemisphere_profile(FULL, d, 180 - d.theta_deg, d.phi_deg) is None
    assert upper(d) is not None


def test_a_peak_on_a_border_is_shared_by_its_patches() -> None:
    about = (30.0, 9.0)  # the border between azimuths 0 and 18
    units = np.concatenate([sphere_points(3000), spiral_about(*about, 6.0, 0.4)])
    d = distribution((0, 0), units, lambda u: lobe_per_sr(u, about, 0.2) * (u[:, 2] > 0))
    energy = upper(d).patches().bsdf_per_sr * SIZE
    left, right = int(FULL.patch_of(30, 0)), int(FULL.patch_of(30, 18))
    assert energy[left] == pytest.approx(0.1, rel=0.05)
    assert energy[right] == pytest.approx(0.1, rel=0.05)
    assert energy.sum() == pytest.approx(0.2, rel=5e-3)
