"""coarse.py: the coarse pass in time: every second circle on the way up, the others on the way down, without stopping.

After paper [1], fig. 5a. The arm's azimuth goes to and fro within its cable wrap: it turns round beyond the ends of the
circles while the elevation goes over to the next one. Everything is closed form in time.
"""

from itertools import pairwise

import numpy as np

from gonio.plan.arm import axis_numbers
from gonio.plan.circles import CLEARANCE_DEG, Circle, Coverage, circles
from gonio.plan.knots import AxisMotion, FloatArray
from gonio.plan.limits import HOLD_RATE_PER_S
from gonio.plan.profiles import STEP_BEND, STEP_SLOPE, Law, smooth_step
from gonio.plan.trajectory import FORCE_SHARE, SPEED_SHARE

_KNOT_S = 0.05
_STEP_SHARE = 0.5  # of the elevation's limits, for the step from circle to circle
_LEAST_BEYOND_DEG = 5.0


def coarse_pass(coverage: Coverage, speed_deg_per_s: float) -> AxisMotion:
    """The motion from rest to rest over all circles; `speed_deg_per_s` at the arm's equator if its azimuth can."""
    speed, turn_s = _speed_and_turn(coverage, speed_deg_per_s)
    beyond = speed * turn_s / np.pi
    found = circles(coverage, speed, beyond)
    order = found[0::2] + found[1::2][::-1]
    ramp_s = 2.0 * beyond / speed
    side = 1.0
    flight = _Flight(coverage, speed, _end(order[0], -side) - side * beyond)
    flight.ramp(order[0], ramp_s, side)
    for circle, following in pairwise(order):
        flight.cruise(circle, side * max(side * _end(circle, side), side * _end(following, side)), side)
        flight.turn(circle, following, turn_s, side)
        side = -side
    flight.cruise(order[-1], _end(order[-1], side), side)
    flight.brake(order[-1], ramp_s, side)
    return flight.motion()


def _end(circle: Circle, side: float) -> float:
    return circle.last_deg if side > 0.0 else circle.first_deg


def _speed_and_turn(coverage: Coverage, speed_deg_per_s: float) -> tuple[float, float]:
    """Azimuth speed and the time in which it reverses: v cos(pi t / T), which goes v T / pi beyond the circle's end."""
    azimuth, elevation = (coverage.instrument.axes[i] for i in axis_numbers(coverage.instrument, "detector"))
    speed = min(speed_deg_per_s, SPEED_SHARE * azimuth.max_velocity_deg_per_s)
    # The largest of |a| + rate |v| over the reversal is v sqrt((pi / T)^2 + rate^2).
    force = FORCE_SHARE * azimuth.max_acceleration_deg_per_s2 / speed
    turn_s = np.pi / np.sqrt(force**2 - HOLD_RATE_PER_S**2) if force > HOLD_RATE_PER_S else np.inf
    step = 2.0 * coverage.pitch_deg
    turn_s = max(
        turn_s,
        np.sqrt(step * STEP_BEND / (_STEP_SHARE * elevation.max_acceleration_deg_per_s2)),
        step * STEP_SLOPE / (_STEP_SHARE * elevation.max_velocity_deg_per_s),
    )
    room = min(azimuth.max_deg - 180.0, -180.0 - azimuth.min_deg) - CLEARANCE_DEG
    if room >= _LEAST_BEYOND_DEG:
        speed = min(speed, room * np.pi / turn_s)
    return float(speed), float(turn_s)


class _Flight:
    """Collects the pieces of the flight as knots; each begins where the last one ended, at the same speed."""

    def __init__(self, coverage: Coverage, speed_deg_per_s: float, azimuth_deg: float) -> None:
        self._coverage = coverage
        self._speed = speed_deg_per_s
        self._azimuth = azimuth_deg
        self._elapsed = 0.0
        self._times: list[FloatArray] = []
        self._azimuths: list[FloatArray] = []  # (3, n): reading and two derivatives by time
        self._elevations: list[FloatArray] = []

    def ramp(self, circle: Circle, duration_s: float, side: float) -> None:
        """From rest to full speed: v (1 - cos(pi t / T)) / 2."""
        w, v, t = np.pi / duration_s, side * self._speed, self._piece(duration_s)
        law = (0.5 * v * (t - np.sin(w * t) / w), 0.5 * v * (1.0 - np.cos(w * t)), 0.5 * v * w * np.sin(w * t))
        self._add(t, law, (circle, circle), np.zeros((3, len(t))))
        self._advance(0.5 * v * duration_s, duration_s)

    def cruise(self, circle: Circle, end_deg: float, side: float) -> None:
        """At constant speed along a circle."""
        distance = side * (end_deg - self._azimuth)
        if distance <= 1e-6:
            return
        v, duration = side * self._speed, distance / self._speed
        t = self._piece(duration)
        law = (v * t, np.full_like(t, v), np.zeros_like(t))
        self._add(t, law, (circle, circle), np.zeros((3, len(t))))
        self._advance(v * duration, duration)

    def turn(self, circle: Circle, following: Circle, duration_s: float, side: float) -> None:
        """Round the end of a circle back onto the next one: v cos(pi t / T), the elevation by a smooth step."""
        w, v, t = np.pi / duration_s, side * self._speed, self._piece(duration_s)
        law = (v / w * np.sin(w * t), v * np.cos(w * t), -v * w * np.sin(w * t))
        blend, rate, bend = smooth_step(t / duration_s)
        self._add(t, law, (circle, following), np.stack((blend, rate / duration_s, bend / duration_s**2)))
        self._advance(0.0, duration_s)

    def brake(self, circle: Circle, duration_s: float, side: float) -> None:
        """From full speed to rest."""
        w, v, t = np.pi / duration_s, side * self._speed, self._piece(duration_s, with_end=True)
        law = (0.5 * v * (t + np.sin(w * t) / w), 0.5 * v * (1.0 + np.cos(w * t)), -0.5 * v * w * np.sin(w * t))
        self._add(t, law, (circle, circle), np.zeros((3, len(t))))
        self._advance(0.5 * v * duration_s, duration_s)

    def motion(self) -> AxisMotion:
        """All pieces as one motion of the axes."""
        azimuth, elevation = np.concatenate(self._azimuths, axis=1), np.concatenate(self._elevations, axis=1)
        first, second = axis_numbers(self._coverage.instrument, "detector")
        moving = np.zeros((2, azimuth.shape[1], len(self._coverage.instrument.axes)))
        moving[:, :, first], moving[:, :, second] = azimuth[1:], elevation[1:]
        q = self._coverage.readings(azimuth[0], elevation[0])
        return AxisMotion(np.concatenate(self._times), q, moving[0], moving[1])

    def _piece(self, duration_s: float, with_end: bool = False) -> FloatArray:
        count = max(1, int(np.ceil(duration_s / _KNOT_S)))
        return np.asarray(np.arange(count + int(with_end)) * (duration_s / count), dtype=np.float64)

    def _add(self, times: FloatArray, law: Law, pair: tuple[Circle, Circle], blend: FloatArray) -> None:
        azimuth, v, a = self._azimuth + law[0], law[1], law[2]
        here, there = (circle.at(azimuth) for circle in pair)
        s, ds, dds = blend
        gap, gap_slope = there[0] - here[0], there[1] - here[1]
        slope, bend = here[1] + s * gap_slope, here[2] + s * (there[2] - here[2])
        elevation = np.stack(
            (
                here[0] + s * gap,
                slope * v + ds * gap,
                bend * v**2 + slope * a + 2.0 * ds * gap_slope * v + dds * gap,
            )
        )
        self._times.append(self._elapsed + times)
        self._azimuths.append(np.stack((azimuth, v, a)))
        self._elevations.append(elevation)

    def _advance(self, travel_deg: float, duration_s: float) -> None:
        self._azimuth += travel_deg
        self._elapsed += duration_s
