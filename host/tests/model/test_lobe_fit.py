"""test_lobe_fit.py: lobes of distributions in closed form: found, of the right size, and none where there is none."""

import numpy as np
import pytest

from benchmarks.models.samples import RetroCoating
from gonio.model.hemisphere import tangent_axes
from gonio.model.lobe import Lobe
from gonio.model.lobes.fit import fit_lobes

MIRROR = np.array([-1.0, -1.0, 1.0])


def fibonacci(count: int) -> tuple[np.ndarray, np.ndarray]:
    k = np.arange(count) + 0.5
    z = 1.0 - k / count
    phi = k * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z**2)
    unit = np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)
    return unit, np.full(count, 2.0 * np.pi / count)


UNIT, SOLID_ANGLE = fibonacci(20000)


def direction(theta_deg: float, phi_deg: float) -> np.ndarray:
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def angle_deg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.degrees(2.0 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2.0, 0.0, 1.0)))


def lobe(theta_deg: float, phi_deg: float, sigma_deg: tuple[float, float], turn_deg: float, peak: float) -> Lobe:
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    axes = np.array([[cos, -sin], [sin, cos]])
    covariance = axes @ np.diag(np.radians(sigma_deg) ** 2) @ axes.T
    return Lobe(direction(theta_deg, phi_deg), covariance, peak)


def with_noise(dsf: np.ndarray, share: float, floor: float, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    variance = (share * dsf) ** 2 + floor**2
    return dsf + np.random.default_rng(seed).normal(size=len(dsf)) * np.sqrt(variance), variance


def spiral_and_grid(centre: np.ndarray, pitch_deg: float, radius_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """A coarse hemisphere of 2.5 degrees and a spiral about a peak."""
    coarse, solid_angle = fibonacci(int(2.0 * np.pi / np.radians(2.5) ** 2))
    outside = angle_deg(coarse, centre) > radius_deg + 1.0
    k = np.arange(int(np.pi * (radius_deg / pitch_deg) ** 2)) + 0.5
    radius = np.sqrt(k / np.pi)
    turn = 2.0 * np.pi * radius
    radius = np.radians(pitch_deg) * radius
    axes = tangent_axes(centre)
    aside = np.cos(turn)[:, None] * axes[0] + np.sin(turn)[:, None] * axes[1]
    spiral = np.cos(radius)[:, None] * centre + np.sin(radius)[:, None] * aside
    areas = np.concatenate((solid_angle[outside], np.full(len(spiral), np.radians(pitch_deg) ** 2)))
    return np.concatenate((coarse[outside], spiral)), areas


def same(found: Lobe, true: Lobe, *, peak: float, sigma: float, centre_deg: float) -> None:
    assert found.peak_per_sr == pytest.approx(true.peak_per_sr, rel=peak)
    np.testing.assert_allclose(found.sigma_rad, true.sigma_rad, rtol=sigma)
    assert angle_deg(found.centre, true.centre) < centre_deg


@pytest.mark.parametrize("theta_deg", [5, 10, 20, 30, 40, 50, 60, 70])
def test_a_weak_broad_lobe_beside_a_strong_narrow_one_is_kept(theta_deg: float) -> None:
    incident = direction(theta_deg, 0.0)
    dsf = RetroCoating().dsf_per_sr(incident[None, :], UNIT)
    hints = (incident, incident * MIRROR)
    retro, mirror = fit_lobes(UNIT, dsf, np.zeros(len(dsf)), SOLID_ANGLE, hints=hints)
    same(retro, lobe(theta_deg, 0.0, (1.2, 1.2), 0.0, 150.0), peak=0.005, sigma=0.005, centre_deg=0.01)
    same(mirror, lobe(theta_deg, 180.0, (12.0, 12.0), 0.0, 0.4), peak=0.001, sigma=0.001, centre_deg=0.05)


@pytest.mark.parametrize("theta_deg", [10, 45, 70])
def test_noise_moves_peaks_by_no_more_than_it_must(theta_deg: float) -> None:
    incident = direction(theta_deg, 0.0)
    clean = RetroCoating().dsf_per_sr(incident[None, :], UNIT)
    dsf, variance = with_noise(clean, 0.01, 0.002)
    for declared in (variance, np.zeros(len(dsf))):
        retro, mirror = fit_lobes(UNIT, dsf, declared, SOLID_ANGLE)
        same(retro, lobe(theta_deg, 0.0, (1.2, 1.2), 0.0, 150.0), peak=0.02, sigma=0.01, centre_deg=0.02)
        same(mirror, lobe(theta_deg, 180.0, (12.0, 12.0), 0.0, 0.4), peak=0.02, sigma=0.01, centre_deg=0.1)


@pytest.mark.parametrize("theta_deg", [80, 88])
def test_lobes_cut_by_the_horizon_do_not_run_away(theta_deg: float) -> None:
    incident = direction(theta_deg, 0.0)
    dsf = RetroCoating().dsf_per_sr(incident[None, :], UNIT)
    retro, mirror = fit_lobes(UNIT, dsf, np.zeros(len(dsf)), SOLID_ANGLE)
    same(retro, lobe(theta_deg, 0.0, (1.2, 1.2), 0.0, 150.0), peak=0.02, sigma=0.02, centre_deg=0.05)
    same(mirror, lobe(theta_deg, 180.0, (12.0, 12.0), 0.0, 0.4), peak=0.05, sigma=0.05, centre_deg=0.5)


@pytest.mark.parametrize("hole_deg", [1.5, 3.0, 5.0])
def test_a_peak_in_a_shaded_zone_is_bounded_by_what_was_seen(hole_deg: float) -> None:
    incident = direction(30.0, 0.0)
    seen = angle_deg(UNIT, incident) > hole_deg
    unit = UNIT[seen]
    dsf = RetroCoating().dsf_per_sr(incident[None, :], unit)
    lobes = fit_lobes(unit, dsf, np.zeros(len(dsf)), SOLID_ANGLE[seen], hints=(incident, incident * MIRROR))
    highest = float(dsf.max())
    mirror = [g for g in lobes if angle_deg(g.centre, incident * MIRROR) < 1.0]
    assert len(mirror) == 1
    assert mirror[0].peak_per_sr == pytest.approx(0.4, rel=0.05)
    for other in (g for g in lobes if g is not mirror[0]):
        assert other.peak_per_sr < 1.51 * highest
        assert angle_deg(other.centre, incident) < hole_deg
        assert np.degrees(other.sigma_rad[1]) < 3.0


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize(("sigma_deg", "apart_deg", "second"), [(2.0, 6.0, 4.0), (2.0, 6.0, 1.2), (1.5, 3.2, 4.0)])
def test_two_peaks_side_by_side_are_two(noise: float, sigma_deg: float, apart_deg: float, second: float) -> None:
    true = [
        lobe(40.0, 90.0, (sigma_deg, sigma_deg), 0.0, 5.0),
        lobe(40.0 + apart_deg, 90.0, (sigma_deg, sigma_deg), 0.0, second),
    ]
    dsf = 0.05 * UNIT[:, 2] + sum(g.dsf_per_sr(UNIT) for g in true)
    dsf, variance = with_noise(dsf, noise, 0.2 * noise)
    found = fit_lobes(UNIT, dsf, variance, SOLID_ANGLE)
    assert len(found) == 2
    for mine, other in zip(found, true, strict=True):
        same(mine, other, peak=0.02, sigma=0.02, centre_deg=0.05)


@pytest.mark.parametrize(("theta_deg", "turn_deg"), [(0.0, 20.0), (2.0, 75.0), (35.0, 30.0), (60.0, 120.0)])
def test_an_elliptic_lobe_in_any_orientation(theta_deg: float, turn_deg: float) -> None:
    true = lobe(theta_deg, 60.0, (8.0, 2.0), turn_deg, 7.0)
    dsf = 0.25 * UNIT[:, 2] + true.dsf_per_sr(UNIT)
    (found,) = fit_lobes(UNIT, dsf, np.zeros(len(dsf)), SOLID_ANGLE)
    same(found, true, peak=0.005, sigma=0.005, centre_deg=0.02)
    np.testing.assert_allclose(found.dsf_per_sr(UNIT), true.dsf_per_sr(UNIT), atol=0.01)


def test_too_few_points_for_an_ellipse_give_a_circle() -> None:
    unit, solid_angle = fibonacci(5000)  # 2 degrees apart, standard deviation 1.2
    incident = direction(30.0, 0.0)
    dsf = RetroCoating().dsf_per_sr(incident[None, :], unit)
    retro, mirror = fit_lobes(unit, dsf, np.zeros(len(dsf)), solid_angle)
    same(retro, lobe(30.0, 0.0, (1.2, 1.2), 0.0, 150.0), peak=0.02, sigma=0.02, centre_deg=0.05)
    assert mirror.peak_per_sr == pytest.approx(0.4, rel=0.02)


def test_crowded_points_neither_rule_nor_are_lost() -> None:
    """A spiral of 0.1 degrees on a coarse grid: 7,000 of 11,000 points on 0.4 % of the hemisphere."""
    centre = direction(45.0, 180.0)
    unit, solid_angle = spiral_and_grid(centre, 0.1, 5.0)
    true = [
        lobe(45.0, 180.0, (0.4, 0.4), 0.0, 20000.0),
        lobe(47.0, 180.0, (0.3, 0.3), 0.0, 200.0),
        lobe(45.0, 0.0, (10.0, 10.0), 0.0, 0.3),
    ]
    dsf = 1e-3 * unit[:, 2] + sum(g.dsf_per_sr(unit) for g in true)
    dsf, variance = with_noise(dsf, 0.01, 0.01)
    found = fit_lobes(unit, dsf, variance, solid_angle)
    assert len(found) == 3
    for mine, other in zip(found, true, strict=True):
        same(mine, other, peak=0.02, sigma=0.02, centre_deg=0.15)


def test_a_heavy_tailed_peak_is_followed_by_several_lobes() -> None:
    centre = direction(45.0, 180.0)
    unit, solid_angle = spiral_and_grid(centre, 0.1, 5.0)
    away = angle_deg(unit, centre)
    peak = 1000.0 / (1.0 + (away / 0.3) ** 2.5)  # ABg with g = 2.5
    found = fit_lobes(unit, peak + 0.1 * unit[:, 2], np.zeros(len(unit)), solid_angle)
    model = sum(g.dsf_per_sr(unit) for g in found)
    assert 2 <= len(found) <= 8
    assert np.abs(model / peak - 1.0)[away < 1.0].max() < 0.08
    assert np.abs(model / peak - 1.0)[away < 3.0].max() < 0.25
    assert all(angle_deg(g.centre, centre) < 0.05 for g in found)


def test_a_heavy_tail_is_followed_on_an_even_grid_too() -> None:
    away = angle_deg(UNIT, direction(45.0, 180.0))
    peak = 100.0 / (1.0 + (away / 1.5) ** 2.5)
    found = fit_lobes(UNIT, peak + 0.25 * UNIT[:, 2], np.zeros(len(UNIT)), SOLID_ANGLE)
    model = sum(g.dsf_per_sr(UNIT) for g in found)
    assert len(found) >= 3
    assert np.abs(model / peak - 1.0)[away < 4.0].max() < 0.12


def _shaded(centre: np.ndarray, radius_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of half a degree about a direction but for a disc that something shades, and the coarse hemisphere."""
    unit, solid_angle = spiral_and_grid(centre, 0.5, 8.0)
    seen = angle_deg(unit, centre) > radius_deg
    return unit[seen], solid_angle[seen]


def test_a_lobe_whose_top_is_shaded_is_told_from_its_flanks() -> None:
    # As `make demo` measures its retro lobe: the detector's head shades 2.19 degrees about it.
    true = lobe(30.0, 0.0, (2.02, 2.02), 0.0, 2.57)
    unit, solid_angle = _shaded(true.centre, 2.19)
    dsf, variance = with_noise(0.095 * unit[:, 2] + true.dsf_per_sr(unit), 1e-3, 4e-4)
    (found,) = fit_lobes(unit, dsf, variance, solid_angle, hints=(true.centre,))
    same(found, true, peak=0.05, sigma=0.02, centre_deg=0.05)


def test_no_lobe_is_invented_where_nothing_is_seen() -> None:
    centre = direction(30.0, 0.0)
    unit, solid_angle = _shaded(centre, 4.0)
    narrow = lobe(30.0, 0.0, (1.5, 1.5), 0.0, 2.0).dsf_per_sr(unit)  # its top, 35 times the highest seen
    away = angle_deg(unit, centre)
    side = np.clip(np.degrees(unit[:, 1]) / np.maximum(away, 1.0), 0.0, 1.0)
    aside = 0.6 * side * np.exp(-(away - 4.0) / 1.2)  # a flank on one side only
    for rest in (narrow, aside):
        dsf, variance = with_noise(0.095 * unit[:, 2] + rest, 1e-3, 4e-4)
        assert not [g for g in fit_lobes(unit, dsf, variance, solid_angle, hints=(centre,)) if hidden(g, unit)]


def hidden(found: Lobe, unit: np.ndarray) -> bool:
    """Whether points see less than 0.8 of a lobe's peak."""
    return float(found.dsf_per_sr(unit).max()) < 0.8 * found.peak_per_sr


@pytest.mark.parametrize("theta_deg", [0.0, 30.0, 60.0])
def test_a_beam_straight_through_is_one_lobe_and_the_same_at_every_angle(theta_deg: float) -> None:
    # As `make demo` measures it: a top hat of 1 degree with soft edges over diffuse light; next to nothing is no lobe.
    centre = direction(theta_deg, 180.0)
    unit, solid_angle = spiral_and_grid(centre, 0.05, 2.0)
    away = angle_deg(unit, centre)
    beam = 417.2 * np.clip((0.55 - away) / 0.1, 0.0, 1.0)
    dsf, variance = with_noise(beam + 0.1 / np.pi * unit[:, 2], 1e-4, 4e-4)
    (found,) = fit_lobes(unit, dsf, variance, solid_angle, hints=(centre,))
    # the nearest Gaussian by least squares over the plane: 1.43 times as high as a hard edge's top hat
    np.testing.assert_allclose(np.degrees(found.sigma_rad), 0.331, atol=0.004)
    assert found.peak_per_sr == pytest.approx(606.0, rel=0.02)


def test_what_is_broader_than_twenty_degrees_is_ground() -> None:
    swelling = lobe(30.0, 0.0, (25.0, 25.0), 0.0, 2.0).dsf_per_sr(UNIT)
    assert not fit_lobes(UNIT, swelling + 0.05 * UNIT[:, 2], np.zeros(len(UNIT)), SOLID_ANGLE)


def test_a_top_hat_is_one_lobe_of_about_its_power() -> None:
    centre = direction(0.0, 0.0)
    unit, solid_angle = spiral_and_grid(centre, 0.1, 5.0)
    beam = np.where(angle_deg(unit, centre) < 0.5, 4000.0, 0.0)
    (found,) = fit_lobes(unit, beam, np.zeros(len(unit)), solid_angle)
    assert angle_deg(found.centre, centre) < 0.05
    assert found.power == pytest.approx(4000.0 * np.pi * np.radians(0.5) ** 2, rel=0.4)
    assert found.peak_per_sr < 1.51 * 4000.0


@pytest.mark.parametrize("count", [2000, 20000, 100000])
@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("declared", [True, False])
def test_a_cosine_has_no_lobes(count: int, noise: float, declared: bool) -> None:
    unit, solid_angle = fibonacci(count)
    dsf, variance = with_noise(0.25 * unit[:, 2], noise, 0.1 * noise)
    hints = (direction(30.0, 0.0), direction(30.0, 180.0))
    assert not fit_lobes(unit, dsf, variance if declared else 0.0 * variance, solid_angle, hints=hints)


@pytest.mark.parametrize("theta_deg", [0, 30, 60, 75])
def test_a_sintered_white_has_no_lobes(theta_deg: float) -> None:
    """Like PTFE: a cosine with some limb darkening, a broad swelling forwards and a slight one backwards."""
    incident = direction(theta_deg, 0.0)
    forwards, backwards = (angle_deg(UNIT, d) for d in (incident * MIRROR, incident))
    shape = 1.0 + 0.1 * (1.0 - UNIT[:, 2]) * (UNIT @ (incident * MIRROR)) - 0.05 * np.exp(-((backwards / 30) ** 2) / 2)
    shape += 0.15 * np.sin(np.radians(theta_deg)) ** 4 * np.exp(-((forwards / 25) ** 2) / 2)
    dsf, variance = with_noise(0.3 * UNIT[:, 2] * shape, 0.003, 0.0)
    assert not fit_lobes(UNIT, dsf, variance, SOLID_ANGLE, hints=(incident, incident * MIRROR))


def test_one_wrong_point_is_no_lobe() -> None:
    dsf, variance = with_noise(0.25 * UNIT[:, 2], 0.01, 0.001)
    dsf[777] *= 40.0
    assert not fit_lobes(UNIT, dsf, variance, SOLID_ANGLE)


def test_points_without_a_value_are_left_out_and_hopeless_input_gives_none() -> None:
    true = lobe(35.0, 60.0, (3.0, 3.0), 0.0, 7.0)
    dsf = 0.25 * UNIT[:, 2] + true.dsf_per_sr(UNIT)
    dsf[::7] = np.nan
    solid_angle = SOLID_ANGLE.copy()
    solid_angle[3::7] = 0.0
    zero = np.zeros(len(dsf))
    (found,) = fit_lobes(UNIT, dsf, zero, solid_angle)
    same(found, true, peak=0.005, sigma=0.005, centre_deg=0.02)
    assert fit_lobes(UNIT, zero, zero, SOLID_ANGLE) == ()
    assert fit_lobes(UNIT[:10], dsf[:10], zero[:10], SOLID_ANGLE[:10]) == ()
    assert fit_lobes(UNIT, np.full(len(dsf), np.nan), zero, SOLID_ANGLE) == ()
    assert fit_lobes(UNIT, dsf, zero, solid_angle, most=0) == ()


def test_no_more_lobes_than_asked_for_and_the_strong_ones_first() -> None:
    true = [lobe(30.0, phi, (2.0, 2.0), 0.0, peak) for phi, peak in ((0.0, 5.0), (90.0, 20.0), (180.0, 10.0))]
    dsf = 0.05 * UNIT[:, 2] + sum(g.dsf_per_sr(UNIT) for g in true)
    found = fit_lobes(UNIT, dsf, np.zeros(len(dsf)), SOLID_ANGLE, most=2)
    assert [round(g.peak_per_sr) for g in found] == [20, 10]
