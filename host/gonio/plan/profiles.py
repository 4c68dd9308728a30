"""profiles.py: smooth laws that paths are built from, each with its first and second derivative."""

import numpy as np

from gonio.plan.knots import FloatArray

Law = tuple[FloatArray, FloatArray, FloatArray]

# Largest slope and bend of `smooth_step` on its unit interval.
STEP_SLOPE = 15.0 / 8.0
STEP_BEND = 10.0 / np.sqrt(3.0)


def smooth_step(u: FloatArray) -> Law:
    """From 0 to 1 while u goes from 0 to 1, at rest (first and second derivative 0) at both ends and outside."""
    x = np.clip(u, 0.0, 1.0)
    return (
        x**3 * (10.0 - 15.0 * x + 6.0 * x**2),
        30.0 * x**2 * (1.0 - x) ** 2,
        60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
    )


def speed_up(time_s: FloatArray, ramp_s: float) -> Law:
    """Path time (n,) that runs ever faster, from rest to the rate 1 after `ramp_s`: its rate is `smooth_step`.

    s(t) = ramp (u^6 - 3 u^5 + 5/2 u^4) with u = t / ramp, and t - ramp / 2 after the ramp.
    """
    u = np.clip(time_s / ramp_s, 0.0, 1.0)
    rate, slope, _ = smooth_step(u)
    path_time = ramp_s * u**4 * (u**2 - 3.0 * u + 2.5) + np.maximum(time_s - ramp_s, 0.0)
    return path_time, rate, slope / ramp_s
