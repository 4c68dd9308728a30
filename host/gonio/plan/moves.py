"""moves.py: moves from rest to rest between paths, straight in the axes, round the zones if need be."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import AxisMotion, FloatArray, KnotArray, counts_per_deg, pack
from gonio.plan.limits import HOLD_RATE_PER_S, find, require_allowed
from gonio.plan.program import PathStep, Program
from gonio.plan.trajectory import FORCE_SHARE, SPEED_SHARE
from gonio.units.instrument import Instrument

_KNOT_S = 0.1
_SHORTEST_S = 0.02
_NO_DISTANCE_DEG = 1e-6
# Where an axis may stand while the others pass a zone: shares of its range, the middle first.
_VIA_SHARES = (0.5, 0.25, 0.75, 0.1, 0.9)


def move(start_deg: FloatArray, end_deg: FloatArray, instrument: Instrument, where: str) -> KnotArray:
    """Knots from one reading (axes,) to another, at rest at both; the quickest way among those that the zones allow.

    Raises UsageError, with the direction and the limit of the straight way, if there is none.
    """
    direct = pack(_through([start_deg, end_deg], instrument), instrument)
    if find(direct, instrument) is None:
        return direct
    ways = [pack(_through(points, instrument), instrument) for points in _detours(start_deg, end_deg, instrument)]
    for way in sorted(ways, key=lambda knots: int(knots["time_ns"][-1])):
        if find(way, instrument) is None:
            return way
    require_allowed(direct, instrument, Kinematics(instrument.axes), where)
    return direct


def starting_at(program: Program, standing_counts: FloatArray, instrument: Instrument) -> Program:
    """The program with its first move led from where the axes stand, counts (axes,); nothing changes if it has no move.

    Raises UsageError if there is no allowed way.
    """
    for i, step in enumerate(program.steps):
        if isinstance(step, PathStep):
            if step.kind != "move":
                break
            used = len(instrument.axes)
            scale = counts_per_deg(instrument.axes)
            standing = np.asarray(standing_counts, dtype=np.float64)[:used] / scale
            knots = move(standing, step.knots["position_counts"][-1, :used] / scale, instrument, step.name)
            steps = [*program.steps[:i], replace(step, knots=knots), *program.steps[i + 1 :]]
            return replace(program, steps=steps)
    return program


def _detours(start: FloatArray, end: FloatArray, instrument: Instrument) -> Iterator[list[FloatArray]]:
    """Ways on which one axis goes aside first, then the others go to their end, then that axis."""
    for i, axis in enumerate(instrument.axes):
        for share in _VIA_SHARES:
            aside, back = start.copy(), end.copy()
            aside[i] = back[i] = axis.min_deg + share * (axis.max_deg - axis.min_deg)
            yield [start, aside, back, end]


def _through(points: list[FloatArray], instrument: Instrument) -> AxisMotion:
    """A stop at each of the points."""
    legs = [_leg(a, b, instrument) for a, b in pairwise(points)]
    parts, elapsed = [], 0.0
    for number, leg in enumerate(legs):
        pick = slice(None) if number + 1 == len(legs) else slice(None, -1)
        parts.append(
            (
                elapsed + leg.time_s[pick],
                leg.q_deg[pick],
                leg.velocity_deg_per_s[pick],
                leg.acceleration_deg_per_s2[pick],
            )
        )
        elapsed += float(leg.time_s[-1])
    return AxisMotion(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _leg(start: FloatArray, end: FloatArray, instrument: Instrument) -> AxisMotion:
    """Straight from rest to rest: the share of the way grows as V (1 - cos(pi t / T)) / 2, cruises and brakes."""
    distance = end - start
    way = np.abs(distance)
    if way.max() < _NO_DISTANCE_DEG:
        still = np.zeros((2, len(start)))
        return AxisMotion(np.array([0.0, _SHORTEST_S]), np.stack((start, end)), still, still)
    moving = way >= _NO_DISTANCE_DEG
    way = way[moving]
    force = FORCE_SHARE * np.array([axis.max_acceleration_deg_per_s2 for axis in instrument.axes])[moving]
    fastest = SPEED_SHARE * np.array([axis.max_velocity_deg_per_s for axis in instrument.axes])[moving]
    # Without a cruise T = 1 / V, and way (pi V^2 / 2 + rate V) may be the force; a lower V leaves room for a cruise.
    held = HOLD_RATE_PER_S * way
    uncruised = (np.sqrt(held**2 + 2.0 * np.pi * way * force) - held) / (np.pi * way)
    speed = float(np.minimum(fastest / way, uncruised).min())
    ramp = float((0.5 * np.pi / (force / (speed * way) - HOLD_RATE_PER_S)).max())
    cruise = max(0.0, 1.0 / speed - ramp)
    w = np.pi / ramp

    # The pieces meet at knots, so that each is one closed form.
    up = np.linspace(0.0, ramp, max(2, int(np.ceil(ramp / _KNOT_S)) + 1))
    even = np.linspace(0.0, cruise, max(2, int(np.ceil(cruise / _KNOT_S)) + 1))[1:-1]
    share_up, rate_up, bend_up = (
        0.5 * speed * (up - np.sin(w * up) / w),
        0.5 * speed * (1.0 - np.cos(w * up)),
        0.5 * speed * w * np.sin(w * up),
    )
    down_from = 1 if cruise <= 1e-3 else 0
    time = np.concatenate((up, ramp + even, ramp + cruise + up[down_from:]))
    share = np.concatenate((share_up, 0.5 * speed * ramp + speed * even, 1.0 - share_up[::-1][down_from:]))
    rate = np.concatenate((rate_up, np.full_like(even, speed), rate_up[::-1][down_from:]))
    bend = np.concatenate((bend_up, np.zeros_like(even), -bend_up[::-1][down_from:]))
    q = start + share[:, None] * distance
    q[-1] = end
    return AxisMotion(time, q, rate[:, None] * distance, bend[:, None] * distance)
