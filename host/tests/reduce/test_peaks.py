"""test_peaks.py: integral, direction and width of peaks, and what they are uncertain by."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from signature_scene import circles, distribution, spiral

from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.reduce.integrals.peaks import evaluated_peak, measure_peak, undersampled_note

FloatArray = NDArray[np.float64]
MIRROR = (30.0, 180.0)


def gaussian(unit: FloatArray, about: FloatArray, sigma_deg: float, height: float = 1000.0) -> FloatArray:
    return np.asarray(height * np.exp(-0.5 * (angle_between_deg(unit, about) / sigma_deg) ** 2))


def turned_deg(about: tuple[float, float], dx_deg: float, dy_deg: float) -> FloatArray:
    return unit_from_angles_deg(about[0] + dx_deg, about[1] + dy_deg / np.sin(np.radians(about[0])))


@pytest.mark.parametrize("off", [(0.0, 0.0), (0.04, 0.02), (0.3, 0.1), (0.6, -0.5)])
@pytest.mark.parametrize("step_deg", [0.005, 0.02])
def test_integral_of_a_narrow_peak_is_within_a_tenth_of_a_percent(off: tuple[float, float], step_deg: float) -> None:
    """0.5 degrees full width at half maximum on a spiral of pitch 0.1 degrees, background removed; the closed form is
    2 pi sigma^2 times the height, less sigma^2 / 3 of it for the sphere's curvature."""
    sigma_deg = 0.5 / 2.354820
    sigma = np.radians(sigma_deg)
    unit = spiral(MIRROR, 2.2, 0.1, step_deg)
    dsf = gaussian(unit, turned_deg(MIRROR, *off), sigma_deg) + 3.0
    truth = 1000.0 * 2.0 * np.pi * sigma**2 * (1.0 - sigma**2 / 3.0)
    d = distribution((30.0, 0.0), unit, dsf)
    peak, results = evaluated_peak(d, slice(0, len(unit)), "m")
    assert peak is not None
    assert peak.integral == pytest.approx(truth, rel=1e-3)
    assert peak.ground_per_sr == pytest.approx(3.0, rel=1e-3)
    assert peak.fwhm_deg == pytest.approx(0.5, rel=1e-4)
    assert abs(peak.integral - truth) < 3.0 * results.values["peak m integral_u"] + 2e-5 * truth
    assert peak.turns == pytest.approx(5.0, rel=0.03)
    assert results.values["peak m undersampled"] == 1.0
    assert "under-sampled: 5.0 turns" in undersampled_note("m", peak)[0]


def test_a_peak_with_enough_turns_is_not_flagged() -> None:
    unit = spiral(MIRROR, 6.0, 0.25, 0.1)
    dsf = gaussian(unit, unit_from_angles_deg(*MIRROR), 1.2)
    peak, results = evaluated_peak(distribution((30.0, 0.0), unit, dsf), slice(0, len(unit)), "m")
    assert peak is not None
    assert peak.turns == pytest.approx(1.2 * 2.3548 / 0.25, rel=0.03)
    assert results.values["peak m undersampled"] == 0.0
    assert undersampled_note("m", peak) == []


def test_points_of_other_paths_in_the_disc_count_with_their_own_cells() -> None:
    parts = [circles(2.0, 90.0), spiral(MIRROR, 5.0, 0.25, 0.1)]
    unit = np.concatenate(parts)
    path = np.repeat([0, 1], [len(part) for part in parts])
    dsf = gaussian(unit, unit_from_angles_deg(*MIRROR), 1.2) + 2.0 * unit[:, 2]
    d = distribution((30.0, 0.0), unit, dsf, path)
    peak, _ = evaluated_peak(d, slice(len(parts[0]), len(unit)), "m", unit)
    assert peak is not None
    sigma = np.radians(1.2)
    assert peak.integral == pytest.approx(
        1000.0 * 2.0 * np.pi * sigma**2 * (1.0 - np.exp(-0.5 * (5 / 1.2) ** 2)), rel=2e-3
    )
    assert peak.solid_angle_sr == pytest.approx(2.0 * np.pi * (1.0 - np.cos(np.radians(5.0))), rel=0.2)


@pytest.mark.parametrize("ground_per_sr", [0.0, 2.0])
def test_integral_of_a_top_hat_keeps_what_stands_above_the_ground(ground_per_sr: float) -> None:
    unit = spiral(MIRROR, 6.0, 0.15, 0.1)
    half_width_rad = np.radians(1.8)
    inside = unit @ unit_from_angles_deg(*MIRROR) > np.cos(half_width_rad)
    truth = 100.0 * 2.0 * np.pi * (1.0 - np.cos(half_width_rad))
    peak = measure_peak(unit, np.where(inside, 100.0, 0.0) + ground_per_sr, np.ones(len(unit), dtype=bool))
    assert peak is not None
    assert peak.integral == pytest.approx(truth, rel=0.02)
    assert peak.ground_per_sr >= 0.0


def test_noise_of_direction_width_and_integral_is_that_of_repeats() -> None:
    unit = spiral(MIRROR, 5.0, 0.3, 0.2)
    quiet = distribution((30.0, 0.0), unit, gaussian(unit, turned_deg(MIRROR, 0.2, 0.1), 1.2, 50.0) + 1.0)
    rng = np.random.default_rng(8)
    fields = ("theta_deg", "phi_deg", "height_per_sr", "sigma_deg", "integral", "ground_per_sr")
    found, stated = [], []
    for _ in range(60):
        noise = 1.0 * rng.standard_normal(len(unit))
        noisy = replace(
            quiet, dsf_per_sr=quiet.dsf_per_sr + noise, variance_per_sr2=np.ones(len(unit)), budgets={}, integrals={}
        )
        _, results = evaluated_peak(noisy, slice(0, len(unit)), "m", unit)
        found.append([results.values[f"peak m {field}"] for field in fields])
        stated.append([results.budgets[f"peak m {field}"]["independent"] for field in fields])
    np.testing.assert_allclose(np.mean(stated, axis=0), np.std(found, axis=0, ddof=1), rtol=0.3)


@pytest.mark.parametrize("kind", ["scale", "offset", "turn"])
def test_effects_move_the_fit_as_a_second_fit_says(kind: str) -> None:
    """The pseudo-inverse times an effect's column, beside the fit of the values so changed."""
    unit = spiral(MIRROR, 5.0, 0.3, 0.2)
    about = turned_deg(MIRROR, 0.2, 0.1)
    dsf = gaussian(unit, about, 1.2) + 5.0 * unit[:, 2]
    if kind == "turn":
        theta_deg, phi_deg = angles_deg_from_unit(about)
        moved = gaussian(unit, unit_from_angles_deg(theta_deg + 1e-3, phi_deg), 1.2) + 5.0 * unit[:, 2]
        column = moved - dsf
    else:
        column = 1e-3 * dsf if kind == "scale" else np.full(len(unit), 0.02)
    d = distribution((30.0, 0.0), unit, dsf)
    one, results = evaluated_peak(replace(d, effects={"axis x": column}), slice(0, len(unit)), "m")
    two, _ = evaluated_peak(replace(d, dsf_per_sr=dsf + column), slice(0, len(unit)), "m")
    assert one is not None
    assert two is not None
    for field in ("theta_deg", "height_per_sr", "sigma_deg", "fwhm_deg", "integral", "ground_per_sr"):
        change = abs(getattr(two, field) - getattr(one, field))
        size = {"theta_deg": 1e-3, "sigma_deg": 1e-3, "fwhm_deg": 1e-3}.get(field, 1e-3 * abs(getattr(one, field)))
        assert results.budgets[f"peak m {field}"]["axis x"] == pytest.approx(change, rel=0.02, abs=0.01 * size)


def test_every_uncertainty_has_a_budget() -> None:
    unit = spiral(MIRROR, 5.0, 0.3, 0.2)
    d = distribution((30.0, 0.0), unit, gaussian(unit, unit_from_angles_deg(*MIRROR), 1.2), noise_per_sr=0.5)
    d.p_i_u_rel = 1e-3
    _, results = evaluated_peak(d, slice(0, len(unit)), "m")
    names = {name.removesuffix("_u") for name in results.values if name.endswith("_u")}
    assert names == set(results.budgets)
    assert results.budgets["peak m integral"]["p_i"] == pytest.approx(
        1e-3 * results.values["peak m integral"], rel=1e-6
    )
    assert "peak m theta_deg" in names
    assert results.values["peak m direction_u_deg"] > 0.0
