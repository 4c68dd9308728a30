"""circles.py: the parallels of the arm that cover the sphere: where each begins and ends, and gives way to a zone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import angles_deg_from_unit
from gonio.geometry.kinematics import Kinematics
from gonio.plan.arm import axis_numbers, readings
from gonio.plan.knots import FloatArray
from gonio.plan.limits import in_zone, reasons_out_of_reach
from gonio.plan.profiles import STEP_BEND, STEP_SLOPE, Law, smooth_step
from gonio.plan.program import UnreachableDirection
from gonio.plan.trajectory import FORCE_SHARE
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

GRID_DEG = 0.25
CLEARANCE_DEG = 0.5  # from zones and from the ends of the cable
_MARGIN_DEG = 0.1  # from the elevation's limits: a quintic overshoots a corner of its third derivative a little
_HIGHEST_LIFT_DEG = 25.0
_LIFT_SHARE = 0.5  # of the elevation's acceleration; the turns between circles need the rest
_FAR_DEG = 1e4


@dataclass(frozen=True)
class Lift:
    """Where a circle passes beside a zone: off its elevation before `start_deg` of azimuth, back after `end_deg`."""

    start_deg: float
    end_deg: float
    height_deg: float  # negative: below
    ramp_deg: float

    def at(self, azimuth_deg: FloatArray) -> Law:
        """Height and its derivatives by azimuth, each (n,)."""
        up = smooth_step((azimuth_deg - self.start_deg) / self.ramp_deg + 1.0)
        down = smooth_step((azimuth_deg - self.end_deg) / self.ramp_deg)
        h, w = self.height_deg, self.ramp_deg
        return h * (up[0] - down[0]), h / w * (up[1] - down[1]), h / w**2 * (up[2] - down[2])


@dataclass(frozen=True)
class Circle:
    """A parallel at one elevation, wanted from `first_deg` to `last_deg` of the arm's azimuth."""

    elevation_deg: float
    first_deg: float
    last_deg: float
    lifts: tuple[Lift, ...]

    def at(self, azimuth_deg: FloatArray) -> Law:
        """Elevation and its derivatives by azimuth, each (n,)."""
        value, slope, bend = np.full_like(azimuth_deg, self.elevation_deg), *np.zeros((2, len(azimuth_deg)))
        for lift in self.lifts:
            v, s, b = lift.at(azimuth_deg)
            value, slope, bend = value + v, slope + s, bend + b
        return value, slope, bend


@dataclass(frozen=True)
class Coverage:
    """What the circles are to cover: which side of the sample, with which pitch, the sample axes at `sample_deg`."""

    instrument: Instrument
    sample_deg: tuple[float, float]
    pitch_deg: float
    sphere: str  # "whole", "front" or "back"

    def wanted(self, q_deg: FloatArray) -> NDArray[np.bool_]:
        """Which readings (n, axes) look from the wanted side, half a pitch more included."""
        if self.sphere == "whole":
            return np.ones(len(q_deg), dtype=np.bool_)
        outgoing = Kinematics(self.instrument.axes).directions(q_deg)[1]
        side = 1.0 if self.sphere == "front" else -1.0
        return np.asarray(side * outgoing[:, 2] >= -np.sin(np.radians(0.5 * self.pitch_deg)))

    def readings(self, azimuth_deg: FloatArray, elevation_deg: FloatArray) -> FloatArray:
        """Readings (n, axes) of the arm at these angles."""
        return readings(self.instrument, self.sample_deg, azimuth_deg, elevation_deg)


def elevations(instrument: Instrument, pitch_deg: float) -> FloatArray:
    """Elevations (n,) of the circles, rising: multiples of the pitch, so that the arm's equator, the plane of source
    and mirror direction, is one of them.

    Where more than 3/4 of a pitch would be left to a pole or limit, one more circle lies at that limit, or half a pitch
    from the pole.
    """
    axis = instrument.axes[axis_numbers(instrument, "detector")[1]]
    low = max(axis.min_deg + _MARGIN_DEG, -90.0 + 0.5 * pitch_deg)
    high = min(axis.max_deg - _MARGIN_DEG, 90.0 - 0.5 * pitch_deg)
    steps = np.arange(np.ceil(low / pitch_deg - 1e-9), np.floor(high / pitch_deg + 1e-9) + 1.0)
    found = pitch_deg * steps
    if found[0] - max(axis.min_deg, -90.0) > 0.75 * pitch_deg:
        found = np.concatenate(([low], found))
    if min(axis.max_deg, 90.0) - found[-1] > 0.75 * pitch_deg:
        found = np.concatenate((found, [high]))
    return found


def circles(coverage: Coverage, speed_deg_per_s: float, beyond_deg: float) -> list[Circle]:
    """The circles from low to high. The azimuth turns at `speed_deg_per_s` and overshoots the ends by `beyond_deg`.

    Raises UsageError if a zone cannot be passed within the elevation's limits or if nothing is in reach.
    """
    azimuth_axis = coverage.instrument.axes[axis_numbers(coverage.instrument, "detector")[0]]
    left = max(-180.0, azimuth_axis.min_deg + beyond_deg + CLEARANCE_DEG)
    right = min(180.0, azimuth_axis.max_deg - beyond_deg - CLEARANCE_DEG)
    inner = np.arange(left, right + 1e-9, GRID_DEG)
    wide = np.arange(left - beyond_deg, right + beyond_deg + 1e-9, GRID_DEG)
    found = []
    for elevation in elevations(coverage.instrument, coverage.pitch_deg):
        wanted = inner[coverage.wanted(coverage.readings(inner, np.full_like(inner, elevation)))]
        if len(wanted) > 0:
            lifts = _lifts(coverage, float(elevation), wide, speed_deg_per_s)
            last = right if wanted[-1] == inner[-1] else float(wanted[-1])
            found.append(Circle(float(elevation), float(wanted[0]), last, lifts))
    if not found:
        raise UsageError(f'coarse.sphere: the arm reaches nothing of "{coverage.sphere}": plan another side')
    return found


def _lifts(coverage: Coverage, elevation_deg: float, azimuth_deg: FloatArray, speed: float) -> tuple[Lift, ...]:
    inside = in_zone(coverage.readings(azimuth_deg, np.full_like(azimuth_deg, elevation_deg)), coverage.instrument)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(np.int8)))
    lifts = []
    for start, end in edges.reshape(-1, 2):
        part = azimuth_deg[start:end]
        height = _height(coverage, elevation_deg, part)
        axis = coverage.instrument.axes[axis_numbers(coverage.instrument, "detector")[1]]
        force = _LIFT_SHARE * FORCE_SHARE * axis.max_acceleration_deg_per_s2
        ramp = speed * max(
            np.sqrt(STEP_BEND * abs(height) / force), STEP_SLOPE * abs(height) / (0.5 * axis.max_velocity_deg_per_s)
        )
        from_deg = -_FAR_DEG if start == 0 else float(part[0]) - GRID_DEG - CLEARANCE_DEG
        to_deg = _FAR_DEG if end == len(azimuth_deg) else float(part[-1]) + GRID_DEG + CLEARANCE_DEG
        lifts.append(Lift(from_deg, to_deg, height, float(ramp)))
    return tuple(lifts)


def _height(coverage: Coverage, elevation_deg: float, azimuth_deg: FloatArray) -> float:
    """The smallest change of elevation that leads past the zone, with clearance."""
    for size in np.arange(GRID_DEG, _HIGHEST_LIFT_DEG, GRID_DEG):
        for sign in (1.0, -1.0):
            beside = coverage.readings(azimuth_deg, np.full_like(azimuth_deg, elevation_deg + sign * size))
            past = elevation_deg + sign * (size + CLEARANCE_DEG)
            axis = coverage.instrument.axes[axis_numbers(coverage.instrument, "detector")[1]]
            if axis.min_deg <= past <= axis.max_deg and not in_zone(beside, coverage.instrument).any():
                return float(sign * (size + CLEARANCE_DEG))
    raise UsageError(f"coarse.pitch_deg: the circle at elevation {elevation_deg:g} deg finds no way past the zones")


def unreachable(coverage: Coverage, incident: tuple[float, float]) -> list[UnreachableDirection]:
    """Directions of the circles, a pitch apart, that limits or zones keep the arm from, with the reason of each."""
    pitch = coverage.pitch_deg
    planned = elevations(coverage.instrument, pitch)
    beyond = pitch * np.arange(1.0, 180.0 / pitch + 1.0)
    above, below = planned[-1] + beyond, planned[0] - beyond
    # A row that falls beyond a pole by less than half a pitch is the pole itself.
    above, below = above[above < 90.0 + 0.5 * pitch], below[below > -90.0 - 0.5 * pitch]
    rows = np.concatenate((np.maximum(below, -90.0), planned, np.minimum(above, 90.0)))
    counts = np.maximum(1, np.rint(360.0 * np.cos(np.radians(rows)) / pitch).astype(int))
    elevation = np.repeat(rows, counts)
    azimuth = np.concatenate([np.arange(n) * 360.0 / n - 180.0 for n in counts])
    q = coverage.readings(azimuth, elevation)
    q = q[coverage.wanted(q)]
    theta, phi = angles_deg_from_unit(Kinematics(coverage.instrument.axes).directions(q)[1])
    return [
        UnreachableDirection(*incident, float(theta[i]), float(phi[i]), reason)
        for i, reason in enumerate(reasons_out_of_reach(q, coverage.instrument))
        if reason is not None
    ]
