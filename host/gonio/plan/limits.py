"""limits.py: the firmware's checks of knots, done on the host before anything moves (firmware/core/motion/check.c)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import angles_deg_from_unit
from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import FloatArray, KnotArray, bernstein, counts_per_deg, derivatives, evaluate
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument, Zone

# The firmware's feed hold needs this share of the accelerations: |q''| + rate |q'| <= limit (path.h).
HOLD_RATE_PER_S = 0.5
# Half the firmware's slack, so that rounding never makes it refuse what passed here.
_SLACK = 0.5e-6
_POSITION_SLACK_COUNTS = 0.25
_DEEPEST = 16


@dataclass(frozen=True)
class Finding:
    """What is wrong first on a path: the segment's number, and axis and limit or zone in words."""

    segment: int
    what: str


def halve(coefficients: FloatArray) -> FloatArray:
    """Coefficients (n, m, ...) on [0, 1] to (2 n, m, ...): all left halves, then all right halves (de Casteljau)."""
    count = coefficients.shape[1]
    left, right = np.empty_like(coefficients), np.empty_like(coefficients)
    work = coefficients
    for level in range(count):
        left[:, level] = work[:, 0]
        right[:, count - 1 - level] = work[:, -1]
        work = 0.5 * (work[:, :-1] + work[:, 1:])
    return np.concatenate((left, right))


def first_outside(coefficients: FloatArray, low: float, high: float) -> int | None:
    """Index of the first of the polynomials (n, m) that is not certain to stay within [low, high]; None if all do."""
    index = np.arange(len(coefficients))
    worst: int | None = None
    for depth in range(_DEEPEST + 1):
        open_ = (coefficients.min(axis=1) < low) | (coefficients.max(axis=1) > high)
        coefficients, index = coefficients[open_], index[open_]
        ends = coefficients[:, [0, -1]]
        sure = ((ends < low) | (ends > high)).any(axis=1) | (depth == _DEEPEST)
        worst = _first(index[sure], worst)
        keep = ~sure if worst is None else index < worst
        if not keep.any():
            break
        coefficients, index = halve(coefficients[keep]), np.tile(index[keep], 2)
    return worst


def first_inside(outside: FloatArray) -> int | None:
    """Index of the first segment that is not certain to be clear of a zone; None if all are.

    `outside` (n, 6, half-spaces) holds the Bernstein coefficients of a . q - b. A piece is clear if all coefficients of
    one half-space are positive.
    """
    index = np.arange(len(outside))
    worst: int | None = None
    for depth in range(_DEEPEST + 1):
        open_ = np.max(outside.min(axis=1), axis=1) <= 0.0
        outside, index = outside[open_], index[open_]
        sure = np.any(np.all(outside[:, [0, -1]] <= 0.0, axis=2), axis=1) | (depth == _DEEPEST)
        worst = _first(index[sure], worst)
        keep = ~sure if worst is None else index < worst
        if not keep.any():
            break
        outside, index = halve(outside[keep]), np.tile(index[keep], 2)
    return worst


def _first(found: NDArray[np.int64], worst: int | None) -> int | None:
    if len(found) == 0:
        return worst
    smallest = int(found.min())
    return smallest if worst is None else min(worst, smallest)


def zone_lines(instrument: Instrument, start_counts: FloatArray) -> list[tuple[str, FloatArray, FloatArray]]:
    """Per zone its name, a (half-spaces, axes) and b (half-spaces,) in counts, for a path that starts there.

    A path that starts inside a zone may leave it: the zone shrinks to what lies deeper than the start.
    """
    scale = counts_per_deg(instrument.axes)
    zones = []
    for zone in instrument.zones:
        a = np.array([line.a for line in zone.half_spaces]) / scale
        b = np.array([line.b for line in zone.half_spaces])
        if np.all(a @ start_counts <= b):
            b = a @ start_counts - np.abs(a).sum(axis=1)
        zones.append((zone.name, a, b))
    return zones


def find(knots: KnotArray, instrument: Instrument) -> Finding | None:
    """The first thing about a path (within each check) that the firmware would refuse, or None."""
    used = len(instrument.axes)
    coefficients, duration = bernstein(knots)
    coefficients = coefficients[:, :, :used]
    velocity, acceleration = derivatives(coefficients, duration)
    start = knots["position_counts"][0, :used]
    for number, axis in enumerate(instrument.axes):
        scale = abs(axis.counts_per_deg)
        ends = sorted((axis.min_deg * axis.counts_per_deg, axis.max_deg * axis.counts_per_deg))
        low, high = min(ends[0], start[number]), max(ends[1], start[number])
        position = coefficients[:, :, number]
        segment = first_outside(position, low - _POSITION_SLACK_COUNTS, high + _POSITION_SLACK_COUNTS)
        if segment is not None:
            reading = _near(position[segment]) / axis.counts_per_deg
            over = reading.max() > axis.max_deg
            worst, limit = (reading.max(), axis.max_deg) if over else (reading.min(), axis.min_deg)
            return Finding(segment, f"{axis.name} would be {worst:.2f} deg, its limit is {limit:g}")
        speed = axis.max_velocity_deg_per_s * scale * (1.0 + _SLACK)
        segment = first_outside(velocity[:, :, number], -speed, speed)
        if segment is not None:
            worst = np.abs(_near(velocity[segment, :, number])).max() / scale
            limit = axis.max_velocity_deg_per_s
            return Finding(segment, f"{axis.name} would turn at {worst:.2f} deg/s, its limit is {limit:g}")
        force = axis.max_acceleration_deg_per_s2 * scale * (1.0 + _SLACK)
        raised = _raise_degree(acceleration[:, :, number])
        for sign in (1.0, -1.0):
            with_feed = raised + sign * HOLD_RATE_PER_S * velocity[:, :, number]
            segment = first_outside(with_feed, -force, force)
            if segment is not None:
                worst = np.abs(_near(with_feed[segment])).max() / scale
                limit = axis.max_acceleration_deg_per_s2
                return Finding(segment, f"{axis.name} would accelerate at {worst:.2f} deg/s2, its limit is {limit:g}")
    for name, a, b in zone_lines(instrument, start):
        segment = first_inside(coefficients @ a.T - b)
        if segment is not None:
            return Finding(segment, f'the arm would enter "{name}"')
    return None


def _near(coefficients: FloatArray) -> FloatArray:
    """Coefficients (m,) refined until their hull is the polynomial's range to a thousandth, for the sentences."""
    pieces = coefficients[None]
    for _ in range(6):
        pieces = halve(pieces)
    return pieces


def _raise_degree(cubic: FloatArray) -> FloatArray:
    """Bernstein coefficients (n, 4) of a cubic as those of degree 4, (n, 5)."""
    part = np.arange(5) / 4.0
    padded = np.pad(cubic, ((0, 0), (1, 1)))
    return part * padded[:, :-1] + (1.0 - part) * padded[:, 1:]


def require_allowed(knots: KnotArray, instrument: Instrument, kinematics: Kinematics, where: str) -> None:
    """Raise UsageError, with the outgoing direction and the limit, if the firmware would refuse the path."""
    finding = find(knots, instrument)
    if finding is None:
        return
    middle = np.array([0.5 * (knots["time_ns"][finding.segment] + knots["time_ns"][finding.segment + 1])])
    position, _, _ = evaluate(knots, middle)
    _, outgoing = kinematics.directions(position[:, : len(instrument.axes)] / counts_per_deg(instrument.axes))
    theta, phi = angles_deg_from_unit(outgoing[0])
    raise UsageError(f"{where}: at the outgoing direction ({theta:.1f}, {phi:.1f}) {finding.what}: change the plan")


def in_zone(q_deg: FloatArray, instrument: Instrument) -> NDArray[np.bool_]:
    """Which of the axis readings (n, axes) lie in a zone."""
    inside = np.zeros(len(q_deg), dtype=np.bool_)
    for zone in instrument.zones:
        inside |= _inside(q_deg, zone)
    return inside


def _inside(q_deg: FloatArray, zone: Zone) -> NDArray[np.bool_]:
    a = np.array([line.a for line in zone.half_spaces])
    b = np.array([line.b for line in zone.half_spaces])
    return np.asarray((q_deg @ a.T <= b).all(axis=1))


def reasons_out_of_reach(q_deg: FloatArray, instrument: Instrument) -> list[str | None]:
    """For axis readings (n, axes): why each is not allowed (limit or zone), or None. NaN: the arm cannot look there."""
    reasons: list[str | None] = [None] * len(q_deg)
    for zone in instrument.zones:
        for row in np.flatnonzero(_inside(q_deg, zone)):
            reasons[row] = f'the arm would enter "{zone.name}"'
    for i, axis in enumerate(instrument.axes):
        reading = q_deg[:, i]
        for row in np.flatnonzero((reading < axis.min_deg) | (reading > axis.max_deg)):
            limit = axis.min_deg if reading[row] < axis.min_deg else axis.max_deg
            reasons[row] = f"{axis.name} would be {reading[row]:.1f} deg, its limit is {limit:g}"
    for row in np.flatnonzero(np.isnan(q_deg).any(axis=1)):
        reasons[row] = "the arm cannot look from there"
    return reasons
