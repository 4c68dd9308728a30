"""trajectory.py: the time law along a curve of the axes: as fast as speed and axis limits allow, with bounded jerk."""

import numpy as np

from gonio.plan.arm import AxisCurve
from gonio.plan.knots import AxisMotion, FloatArray
from gonio.plan.limits import HOLD_RATE_PER_S
from gonio.units.instrument import Instrument

# Shares of the limits that plans use; the rest is for the rounding of corners and the drives' own control.
SPEED_SHARE = 0.99
FORCE_SHARE = 0.92
_BEND_SHARE = 0.65  # of the force: for the curve's bends and the feed hold; the rest changes the speed
_SMOOTHING_S = 0.12  # full width of the window that rounds the speed's corners
_FINE_S = 0.002
_KNOT_STEPS = 10  # a knot every 20 ms
_ROUNDS = 5


def _speed_limit(curve: AxisCurve, speed_deg_per_s: float, instrument: Instrument) -> FloatArray:
    """Largest speed along the track (n,) that leaves each axis its velocity and its share of the acceleration."""
    limit = np.full(len(curve.length_deg), speed_deg_per_s)
    for i, axis in enumerate(instrument.axes):
        slope, bend = np.abs(curve.d_q[:, i]), np.abs(curve.dd_q[:, i])
        with np.errstate(divide="ignore"):
            limit = np.minimum(limit, SPEED_SHARE * axis.max_velocity_deg_per_s / slope)
        # bend v^2 + rate slope v = share: its positive root in the form that has no cancellation.
        share = _BEND_SHARE * FORCE_SHARE * axis.max_acceleration_deg_per_s2
        linear = HOLD_RATE_PER_S * slope
        root = np.sqrt(linear**2 + 4.0 * bend * share) + linear
        with np.errstate(divide="ignore"):
            limit = np.minimum(limit, 2.0 * share / root)
    return limit


def _reachable_speed(length: FloatArray, limit: FloatArray, acceleration: FloatArray) -> FloatArray:
    """Largest speed under `limit` whose changes stay within `acceleration` (n,), at rest at both ends.

    v^2 may grow by 2 a ds: with A the integral of 2 a, v^2 - A may nowhere exceed an earlier value (and backwards).
    """
    steps = np.diff(length) * (acceleration[:-1] + acceleration[1:])
    gained = np.concatenate(([0.0], np.cumsum(steps)))
    square = limit**2
    square[0] = square[-1] = 0.0
    square = np.minimum.accumulate(square - gained) + gained
    square = np.minimum.accumulate((square + gained)[::-1])[::-1] - gained
    return np.sqrt(np.maximum(square, 0.0))


def _smoothed(time: FloatArray, speed: FloatArray, total: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Length, speed and acceleration along the track at multiples of the fine step, its corners rounded."""
    half = round(0.5 * _SMOOTHING_S / _FINE_S)
    window = 1.0 + np.cos(np.pi * np.arange(-half, half + 1) / (half + 1))
    steps = int(np.ceil(time[-1] / _FINE_S))
    even = np.interp(np.arange(-half, steps + half + 1) * _FINE_S, time, speed, left=0.0, right=0.0)
    # Zeros on both sides: full overlap is not needed, the ends of the result are at rest.
    pad = half + 3
    v = np.convolve(np.pad(even, pad), window / window.sum(), mode="same")
    count = len(v) + (-(len(v) - 1)) % _KNOT_STEPS
    v = np.pad(v, (0, count - len(v)))
    a = np.zeros_like(v)
    a[2:-2] = (8.0 * (v[3:-1] - v[1:-3]) - (v[4:] - v[:-4])) / (12.0 * _FINE_S)
    steps_length = 0.5 * _FINE_S * (v[:-1] + v[1:]) + _FINE_S**2 / 12.0 * (a[:-1] - a[1:])
    length = np.concatenate(([0.0], np.cumsum(steps_length)))
    scale = total / length[-1]
    return length * scale, v * scale, a * scale


def _hermite(curve: AxisCurve, length: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Readings and derivatives by length, each (m, axes), at lengths (m,): quintic between the curve's samples."""
    s = curve.length_deg
    i = np.clip(np.searchsorted(s, length, side="right") - 1, 0, len(s) - 2)
    h = (s[i + 1] - s[i])[:, None]
    u = (length - s[i])[:, None] / h
    step = curve.q_deg[i + 1] - curve.q_deg[i]
    c1, c2 = curve.d_q[i] * h, 0.5 * curve.dd_q[i] * h**2
    # Coefficients from what is left of position, slope and bend at the far end.
    rest = step - c1 - c2
    slope = curve.d_q[i + 1] * h - c1 - 2.0 * c2
    bend = curve.dd_q[i + 1] * h**2 - 2.0 * c2
    c3 = 10.0 * rest - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * rest + 7.0 * slope - bend
    c5 = 6.0 * rest - 3.0 * slope + 0.5 * bend
    q = curve.q_deg[i] + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    d_q = (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h
    dd_q = (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / h**2
    return q, d_q, dd_q


def _load(velocity: FloatArray, acceleration: FloatArray, instrument: Instrument) -> FloatArray:
    """How far each moment (n,) uses the shares of the limits; 1 is all. Accelerations count by their root."""
    load = np.zeros(len(velocity))
    for i, axis in enumerate(instrument.axes):
        force = np.abs(acceleration[:, i]) + HOLD_RATE_PER_S * np.abs(velocity[:, i])
        load = np.maximum(load, np.sqrt(force / (FORCE_SHARE * axis.max_acceleration_deg_per_s2)))
        load = np.maximum(load, np.abs(velocity[:, i]) / (SPEED_SHARE * axis.max_velocity_deg_per_s))
    return load


def time_law(curve: AxisCurve, speed_deg_per_s: float, instrument: Instrument) -> AxisMotion:
    """Motion from rest to rest along a curve, at `speed_deg_per_s` on the sphere wherever the axes' limits allow it."""
    total = float(curve.length_deg[-1])
    limit = _speed_limit(curve, speed_deg_per_s, instrument)
    slope = np.abs(curve.d_q)
    share = np.array([(1.0 - _BEND_SHARE) * FORCE_SHARE * axis.max_acceleration_deg_per_s2 for axis in instrument.axes])
    with np.errstate(divide="ignore"):
        acceleration = np.minimum((share / slope).min(axis=1), share.max())
    for _ in range(_ROUNDS):
        speed = _reachable_speed(curve.length_deg, limit.copy(), acceleration)
        pairs = speed[:-1] + speed[1:]
        time = np.concatenate(([0.0], np.cumsum(2.0 * np.diff(curve.length_deg) / pairs)))
        length, v, a = _smoothed(time, speed, total)
        q, d_q, dd_q = _hermite(curve, length)
        velocity = d_q * v[:, None]
        accelerations = dd_q * (v**2)[:, None] + d_q * a[:, None]
        load = _load(velocity, accelerations, instrument)
        if load.max() <= 1.0:
            break
        # Where rounding corners took too much (at the centre of a spiral), go slower and try again.
        reach = round(_SMOOTHING_S / _FINE_S)
        padded = np.pad(load, reach, mode="edge")
        around = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=1)
        limit = limit / np.maximum(1.0, 1.01 * np.interp(curve.length_deg, length, around))
    stretch = max(1.0, float(load.max()))
    pick = slice(None, None, _KNOT_STEPS)
    count = len(length[pick])
    return AxisMotion(
        np.arange(count, dtype=np.float64) * (_FINE_S * _KNOT_STEPS * stretch),
        q[pick],
        velocity[pick] / stretch,
        accelerations[pick] / stretch**2,
    )
