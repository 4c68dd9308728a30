"""knots.py: motion of the axes as knots: packed in counts, and evaluated as the firmware evaluates them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated.records import KNOT_DTYPE
from gonio.units.instrument import Axis, Instrument

FloatArray = NDArray[np.float64]
KnotArray = NDArray[np.void]  # KNOT_DTYPE
KNOT_AXES = 4


@dataclass(frozen=True)
class AxisMotion:
    """Axis readings (n, axes) and their derivatives at times (n,) that rise from 0; a C2 curve sampled at its knots."""

    time_s: FloatArray
    q_deg: FloatArray
    velocity_deg_per_s: FloatArray
    acceleration_deg_per_s2: FloatArray


def counts_per_deg(axes: tuple[Axis, ...]) -> FloatArray:
    """Signed counts per degree of each axis, shape (axes,)."""
    return np.array([axis.counts_per_deg for axis in axes])


def pack(motion: AxisMotion, instrument: Instrument) -> KnotArray:
    """Knots (n,) of a motion that is at rest at both ends (what rounding left there is set to zero)."""
    scale = counts_per_deg(instrument.axes)
    used = len(scale)
    knots = np.zeros(len(motion.time_s), dtype=KNOT_DTYPE)
    knots["time_ns"] = np.rint(motion.time_s * 1e9).astype(np.int64)
    knots["position_counts"][:, :used] = motion.q_deg * scale
    knots["velocity_counts_per_s"][:, :used] = motion.velocity_deg_per_s * scale
    knots["acceleration_counts_per_s2"][:, :used] = motion.acceleration_deg_per_s2 * scale
    for end in (0, -1):
        knots["velocity_counts_per_s"][end] = 0.0
        knots["acceleration_counts_per_s2"][end] = 0.0
    return knots


def bernstein(knots: KnotArray) -> tuple[FloatArray, FloatArray]:
    """Bernstein coefficients (segments, 6, axes) in counts and durations (segments,) in s between knots.

    The derivatives of a polynomial of degree 5 at its ends are differences of its first and last coefficients
    (G. Farin, "Curves and Surfaces for CAGD", section 5.3).
    """
    duration = np.diff(knots["time_ns"]) * 1e-9
    h = duration[:, None]
    p, v, a = (knots[name] for name in ("position_counts", "velocity_counts_per_s", "acceleration_counts_per_s2"))
    start_speed, start_bend = v[:-1] * h / 5.0, a[:-1] * h**2 / 20.0
    end_speed, end_bend = v[1:] * h / 5.0, a[1:] * h**2 / 20.0
    first, last = p[:-1], p[1:]
    rows = (
        first,
        first + start_speed,
        first + 2.0 * start_speed + start_bend,
        last - 2.0 * end_speed + end_bend,
        last - end_speed,
        last,
    )
    return np.stack(rows, axis=1), duration


def derivatives(coefficients: FloatArray, duration_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bernstein coefficients of velocity (segments, 5, axes) in counts/s and acceleration (segments, 4, axes)."""
    h = duration_s[:, None, None]
    velocity = 5.0 / h * np.diff(coefficients, axis=1)
    return velocity, 4.0 / h * np.diff(velocity, axis=1)


def _value(coefficients: FloatArray, u: FloatArray) -> FloatArray:
    work = coefficients
    side = u[:, None, None]
    while work.shape[1] > 1:
        work = (1.0 - side) * work[:, :-1] + side * work[:, 1:]
    return work[:, 0]


def evaluate(knots: KnotArray, time_ns: NDArray[np.float64]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position, velocity and acceleration in counts, each (n, axes), at path times (n,) within the path."""
    coefficients, duration = bernstein(knots)
    segment = np.clip(np.searchsorted(knots["time_ns"], time_ns, side="right") - 1, 0, len(duration) - 1)
    u = (time_ns - knots["time_ns"][segment]) * 1e-9 / duration[segment]
    velocity, acceleration = derivatives(coefficients, duration)
    return (
        _value(coefficients[segment], u),
        _value(velocity[segment], u),
        _value(acceleration[segment], u),
    )


def positions_deg(knots: KnotArray, instrument: Instrument, every_s: float = 0.05) -> FloatArray:
    """Axis readings (n, axes) along a path, in steps of at most `every_s`."""
    end = float(knots["time_ns"][-1])
    times = np.linspace(0.0, end, max(2, int(np.ceil(end * 1e-9 / every_s)) + 1))
    position, _, _ = evaluate(knots, times)
    scale = counts_per_deg(instrument.axes)
    return np.asarray(position[:, : len(scale)] / scale)
