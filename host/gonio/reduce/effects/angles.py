"""angles.py: effects on where each point looks: zeros of the axes, tilt and offset of the sample, time of the pose."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.reduce.corrections.light import Gains
from gonio.reduce.effects.features import Followed, retro_weight
from gonio.reduce.effects.gradient import Slope
from gonio.reduce.effects.receiver import nearer_rel, shift_rad, spot_per_offset
from gonio.reduce.effects.turns import Turns
from gonio.reduce.points import Points
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]

_CHUNK = 1 << 12  # points at a time: what they need stays in the processor's cache
# A slope that the fit cannot tell from noise may add no more than this to a point's variance.
_NOISE_SHARE = 0.05
_SIGNIFICANT = 9.2  # |gradient|^2 over its noise variance: chi square of two components, 1 %
# (1/2) f'' e^2 has the rms sqrt(3)/2 |f''| u^2 for e ~ N(0, u), its mean included.
_SECOND = np.sqrt(0.75)
_STANDS_COUNTS = 3.0  # an axis whose readings stay within so many counts stands


@dataclass
class AngleChanges:
    """Columns (n,) [1/sr per standard deviation]; how fast the DSF changes along the path (n,) [1/sr per s]; its
    variance (n,) [1/sr^2] from the readings' resolution. NaN where masked."""

    columns: dict[str, FloatArray] = field(default_factory=dict)
    per_second: FloatArray = field(default_factory=lambda: np.zeros(0))
    resolution_variance: FloatArray = field(default_factory=lambda: np.zeros(0))


def angle_changes(points: Points, distribution: Distribution, instrument: Instrument, slope: Slope) -> AngleChanges:
    """All effects of angle, first and second order.

    First order: slope . (displacement of the outgoing direction - displacement of what the distribution follows, see
    features.py). Second order: all displacements together have the covariance C on the sphere, and the Hessian H makes
    of them 1/2 d^T H d, whose rms is sqrt(tr(HC)^2 / 4 + tr(HCHC) / 2): between 0.71 (round peak) and 0.87 tr(HC)
    (only one direction counts); the latter is stated. It is linear in H, so a peak that only moves keeps its integral.
    """
    n = len(points.path)
    changes = AngleChanges(per_second=np.zeros(n), resolution_variance=np.zeros(n))
    effects = _AngleEffects(distribution, points.unit, instrument)
    for path in np.unique(points.path[points.path >= 0]):
        index = np.flatnonzero(points.path == path)
        turns = Turns(instrument.axes, points.q_deg[index].mean(axis=0))
        resolution_u_rad = resolution_u_of_moving_rad(points.q_deg[index], instrument)
        for begin in range(0, len(index), _CHUNK):
            part = index[begin : begin + _CHUNK]
            # A slice costs no copy, and a path flown in one piece is one.
            own: Any = slice(part[0], part[-1] + 1) if part[-1] - part[0] + 1 == len(part) else part
            chunk = _Chunk.of(points, distribution, slope, own)
            for name, values in effects.columns(chunk, turns, resolution_u_rad).items():
                if name not in changes.columns:
                    changes.columns[name] = np.zeros(n)
                changes.columns[name][own] = values
            changes.per_second[own] = chunk.per_second
            changes.resolution_variance[own] = chunk.resolution_variance
    masked = np.flatnonzero(np.isnan(distribution.dsf_per_sr))
    for column in (*changes.columns.values(), changes.per_second, changes.resolution_variance):
        column[masked] = np.nan
    return changes


def resolution_u_of_moving_rad(q_deg: FloatArray, instrument: Instrument) -> FloatArray:
    """Standard uncertainty (axes,) of a single reading from the encoders' resolution, of a path's readings (n, axes):
    one count's rectangular distribution (GUM 4.3.7). What an axis that stands errs by is the same for all, and part of
    its zero: 0 here.

    The cubic through four readings would leave 0.7 to 1 of the variance, by how far the axis goes from SYNC to SYNC.
    """
    count_deg = np.array([1.0 / abs(axis.counts_per_deg) for axis in instrument.axes])
    moves = np.ptp(q_deg, axis=0) > _STANDS_COUNTS * count_deg
    return np.asarray(np.where(moves, np.radians(count_deg) / np.sqrt(12.0), 0.0))


@dataclass
class _Chunk:
    """Some points of one path; components first: vectors (3, n), readings (axes, n), symmetric matrices (6, n)."""

    unit: FloatArray
    dsf: FloatArray
    variance: FloatArray
    q_rad: FloatArray
    rate_rad_per_s: FloatArray
    high_weight: FloatArray
    gradient: FloatArray
    gradient_variance: FloatArray
    hessian: FloatArray
    per_second: FloatArray = field(default_factory=lambda: np.zeros(0))
    resolution_variance: FloatArray = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, points: Points, distribution: Distribution, slope: Slope, own: Any) -> "_Chunk":
        gradient, gradient_variance, hessian = slope.at(points.unit[own], own)
        return cls(
            unit=np.ascontiguousarray(points.unit[own].T),
            dsf=distribution.dsf_per_sr[own],
            variance=distribution.variance_per_sr2[own],
            q_rad=np.radians(np.ascontiguousarray(points.q_deg[own].T)),
            rate_rad_per_s=np.radians(np.ascontiguousarray(points.axis_rate_deg_per_s[own].T)),
            high_weight=points.high_weight[own],
            gradient=np.ascontiguousarray(gradient.T),
            gradient_variance=gradient_variance,
            hessian=np.ascontiguousarray(hessian.T),
        )


class _AngleEffects:
    """What the instrument's file states, for one incident direction."""

    def __init__(self, distribution: Distribution, unit: FloatArray, instrument: Instrument) -> None:
        calibration = instrument.calibration
        self.instrument = instrument
        self.zero_u_rad = float(np.radians(calibration.axis_zero_u_deg))
        self.tilt_u_rad = float(np.radians(calibration.tilt_u_deg))
        incident_deg = distribution.incident_theta_deg, distribution.incident_phi_deg
        retro = retro_weight(unit, distribution.dsf_per_sr, *incident_deg)
        self.followed = Followed.of(*incident_deg, retro)
        self.spot_u_mm = spot_per_offset(*incident_deg) * calibration.sample_offset_u_mm

    def columns(self, chunk: _Chunk, turns: Turns, resolution_u_rad: FloatArray) -> dict[str, FloatArray]:
        """Columns (n,) by name; leaves the change per second and the variance of the readings in the chunk."""
        axes, radius_mm = self.instrument.axes, self.instrument.arm_radius_mm
        share = self.followed.share(chunk.unit)
        moved = {}
        for axis, turn in zip(axes, turns.at(chunk.q_rad), strict=True):
            against = turn - self.followed.turn(share, turn[:, 0]) if axis.carries == "sample" else turn
            moved[f"axis {axis.name}"] = _cross(against, chunk.unit)
        tilted = {}
        for number, name in enumerate("xy"):
            # The sample's own normal turned by +t about x: seen from it everything else turns by -t.
            turn = -np.eye(3)[:, number : number + 1]
            tilted[f"tilt_{name}"] = _cross(turn - self.followed.turn(share, turn[:, 0]), chunk.unit)
        off = shift_rad(chunk.unit, self.spot_u_mm, radius_mm)
        of_axes = self.zero_u_rad**2 * _squares(moved.values())
        of_mount = self.tilt_u_rad**2 * _squares(tilted.values()) + _squares([off])
        gradient = _sober(chunk, of_axes[:3].sum(axis=0) + of_mount[:3].sum(axis=0))
        per_rad = {name: _dot(gradient, d) for name, d in moved.items()}
        found = {name: self.zero_u_rad * change for name, change in per_rad.items()}
        found |= {name: self.tilt_u_rad * _dot(gradient, d) for name, d in tilted.items()}
        found["sample_offset"] = chunk.dsf * nearer_rel(chunk.unit, self.spot_u_mm, radius_mm) + _dot(gradient, off)
        found |= second_order(chunk.hessian, of_axes, of_mount)
        chunk.resolution_variance = np.asarray(
            np.sum([(u * change) ** 2 for u, change in zip(resolution_u_rad, per_rad.values(), strict=True)], axis=0)
        )
        return found | self._pose_time(chunk, per_rad.values())

    def _pose_time(self, chunk: _Chunk, per_rad: Any) -> dict[str, FloatArray]:
        axes, gains = self.instrument.axes, Gains.of(self.instrument)
        along = [change * rate for change, rate in zip(per_rad, chunk.rate_rad_per_s, strict=True)]
        chunk.per_second = np.sum(along, axis=0)
        found = {}
        for axis, change in zip(axes, along, strict=True):
            found[f"pose_time {axis.name}"] = 1e-6 * axis.latch_delay_u_us * change
        for channel, weight in ((gains.high, chunk.high_weight), (gains.low, 1.0 - chunk.high_weight)):
            found[f"pose_time {channel.name} channel"] = -1e-6 * channel.delay_u_us * weight * chunk.per_second
        return found


def _sober(chunk: _Chunk, displacement_variance: FloatArray) -> FloatArray:
    """The gradient (3, n), less where it is noise alone and would show: shrunk by a factor that knows how large the
    noise is but not what it happens to be, so that sums over many points stay unbiased."""
    noise = chunk.gradient_variance * displacement_variance
    told = _dot(chunk.gradient, chunk.gradient) > _SIGNIFICANT * chunk.gradient_variance
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.sqrt(_NOISE_SHARE * chunk.variance / noise)
    return chunk.gradient * np.where(told | ~(factor < 1.0), 1.0, factor)


def second_order(hessian: FloatArray, of_axes: FloatArray, of_mount: FloatArray) -> dict[str, FloatArray]:
    """For covariances (6, n) of the displacement. Cross terms of axes and mount belong to the mount's share, as they
    are at a round peak, so that both columns together make the whole there, and both stay linear in the Hessian."""
    axes, mount = (_SECOND * _trace_of_product(hessian, covariance) for covariance in (of_axes, of_mount))
    axes_trace, mount_trace = of_axes[:3].sum(axis=0), of_mount[:3].sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = np.where(mount_trace > 0.0, np.sqrt(1.0 + 2.0 * axes_trace / mount_trace), 0.0)
    return {"axis_second": axes, "tilt_second": cross * mount}


def _trace_of_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Trace (n,) of the product of symmetric matrices (6, n), xx yy zz xy xz yz."""
    product = a * b
    return np.asarray(product[:3].sum(axis=0) + 2.0 * product[3:].sum(axis=0))


def _squares(displacements: Any) -> FloatArray:
    """Sum of d d^T (6, n) of vectors (3, n): xx yy zz xy xz yz."""
    parts = [np.stack((x * x, y * y, z * z, x * y, x * z, y * z)) for x, y, z in displacements]
    return np.asarray(np.sum(parts, axis=0))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a (3, n) or (3, 1) x b (3, n)."""
    return np.stack((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))
