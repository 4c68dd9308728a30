"""test_peaks.py: the integral of a peak that is no Gaussian."""

import numpy as np
import pytest

from gonio.reduce.integrals.peaks import measure_peak

TURNS, RADIUS_DEG = 40, 6.0


def spiral(turns: int, radius_deg: float) -> np.ndarray:
    """Directions (n, 3) of an Archimedean spiral about the direction (30, 0)."""
    angle = np.arange(0.0, 2 * np.pi * turns, 0.05)
    polar = np.radians(radius_deg) * angle / angle[-1]
    about_z = np.stack([np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=1)
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    return about_z @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]).T


@pytest.mark.parametrize("ground_per_sr", [0.0, 2.0])
def test_integral_of_a_top_hat_keeps_what_stands_above_the_ground(ground_per_sr: float) -> None:
    unit = spiral(TURNS, RADIUS_DEG)
    axis = np.array([np.sin(np.radians(30.0)), 0.0, np.cos(np.radians(30.0))])
    half_width_rad = np.radians(1.8)
    inside = unit @ axis > np.cos(half_width_rad)
    truth = 100.0 * 2.0 * np.pi * (1.0 - np.cos(half_width_rad))
    peak = measure_peak(unit, np.where(inside, 100.0, 0.0) + ground_per_sr, np.ones(len(unit), dtype=bool))
    assert peak is not None
    assert peak.integral == pytest.approx(truth, rel=0.03)
    assert peak.ground_per_sr >= 0.0
