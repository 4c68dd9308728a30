"""pairing.py: where the axes stood when a sample's light came: cubic through the SYNC positions around that moment."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.protocol.generated import records
from gonio.units.instrument import Axis

FloatArray = NDArray[np.float64]

# Positions at these many missing SYNCs inside the four used are still interpolated; beyond, the pose counts as lost. At
# the limit a cubic over 12 ms errs by under 1e-4 degrees for a fourth derivative of 2e4 deg/s^4 (hard jerk changes).
MAX_MISSING_SYNCS = 3
_CHUNK = 1 << 14  # samples at a time: what they need stays in the processor's cache
# The time of a CLOCK_STEP pose was mapped across a step of the controller's clock: nobody knows when it was.
_UNUSABLE = records.POSE_ECHO_LOST | records.POSE_POSITION_UNKNOWN | records.POSE_CLOCK_STEP


@dataclass(frozen=True)
class AxisTrack:
    """One axis' usable positions. Times in ns after `origin_ns` of the track they belong to, shape (m,)."""

    time_ns: FloatArray  # when the position was true: SYNC echo plus latch delay
    sync_number: NDArray[np.int64]
    newton: FloatArray  # (4, m - 3) divided differences of the cubic through points k .. k + 3, degrees and ns


@dataclass(frozen=True)
class Poses:
    """Readings and rates (n, axes) in degrees and degrees/s, NaN where the pose is lost, and PointFlag bits (n,)."""

    q_deg: FloatArray
    rate_deg_per_s: FloatArray
    flags: NDArray[np.uint16]


@dataclass(frozen=True)
class PoseTrack:
    """The positions of a segment, ready to be asked for the pose at any time."""

    origin_ns: int
    axes: tuple[AxisTrack, ...]

    @classmethod
    def from_poses(cls, poses: NDArray[np.void], axes: Sequence[Axis]) -> "PoseTrack":
        """`poses`: POSE_DTYPE, shape (m,), of one segment. A position counts if its drive answered that SYNC in time,
        the SYNC's own echo was seen and its time is known, and so is the position; times must rise."""
        origin_ns = int(poses["sync_time_ns"][0]) if len(poses) else 0
        # Differences of int64 first: absolute nanoseconds do not fit a float.
        time_ns = (poses["sync_time_ns"] - origin_ns).astype(np.float64)
        tracks = []
        for number, axis in enumerate(axes):
            usable = ((poses["valid"] >> number) & 1 == 1) & (poses["flags"] & _UNUSABLE == 0)
            t, sync = time_ns[usable], poses["sync_number"][usable].astype(np.int64)
            rising = np.ones(len(t), dtype=bool)
            rising[1:] = t[1:] > np.maximum.accumulate(t)[:-1]
            t, sync = t[rising] + 1e3 * axis.latch_delay_us, sync[rising]
            position_deg = poses["position_counts"][usable, number][rising] / axis.counts_per_deg
            tracks.append(AxisTrack(t, sync, _divided_differences(t, position_deg)))
        return cls(origin_ns, tuple(tracks))

    def pose_at(
        self, time_ns: NDArray[np.int64], delay_ns: FloatArray | float = 0.0
    ) -> tuple[FloatArray, NDArray[np.uint16]]:
        """Readings (n, axes) in degrees at controller times (n,) less `delay_ns` (scalar or (n,)), and flags (n,).

        Flags: POSE_LOST (reading NaN) outside the track or where more than MAX_MISSING_SYNCS of the SYNCs around it
        have no position of some axis; INTERPOLATED_POSE where fewer are missing.
        """
        found = self.poses_at(time_ns, delay_ns)
        return found.q_deg, found.flags

    def poses_at(self, time_ns: NDArray[np.int64], delay_ns: FloatArray | float = 0.0) -> Poses:
        """As pose_at, with the axes' rates."""
        t = (np.asarray(time_ns, dtype=np.int64) - self.origin_ns).astype(np.float64) - delay_ns
        q_deg, rate = np.empty((len(t), len(self.axes))), np.empty((len(t), len(self.axes)))
        missing = np.zeros(len(t), dtype=np.int64)
        for begin in range(0, len(t), _CHUNK):
            part = slice(begin, begin + _CHUNK)
            for number, axis in enumerate(self.axes):
                q_deg[part, number], rate[part, number], of_axis = _evaluate(axis, t[part])
                np.maximum(missing[part], of_axis, out=missing[part])
        rate *= 1e9  # per ns to per s
        lost = missing > MAX_MISSING_SYNCS
        if lost.any():
            q_deg[lost] = rate[lost] = np.nan
        flags = np.where(lost, PointFlag.POSE_LOST, np.where(missing > 0, PointFlag.INTERPOLATED_POSE, 0))
        return Poses(q_deg, rate, flags.astype(np.uint16))


def time_u_us(axis: Axis, stamp_sigma_us: NDArray[np.float32]) -> float:
    """Standard uncertainty of the time when an axis stood at a position: of its latch delay and of the SYNC's stamps
    (m,), which are independent."""
    stamps_us = stamp_sigma_us.astype(np.float64)
    known_us = stamps_us[np.isfinite(stamps_us)]
    return float(np.hypot(axis.latch_delay_u_us, np.sqrt(np.mean(known_us**2)) if len(known_us) else 0.0))


def _divided_differences(t: FloatArray, y: FloatArray) -> FloatArray:
    """Newton's coefficients (4, m - 3) of the cubics through four successive points at unequal times."""
    if len(t) < 4:
        return np.zeros((4, 0))
    first = np.diff(y) / np.diff(t)
    second = np.diff(first) / (t[2:] - t[:-2])
    third = np.diff(second) / (t[3:] - t[:-3])
    return np.stack((y[:-3], first[:-2], second[:-1], third))


def _evaluate(axis: AxisTrack, t: FloatArray) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Reading and its rate (per ns) at times t (n,), and how many SYNCs are missing among the four used; outside the
    track, all of them."""
    points = len(axis.time_ns)
    never = np.full(len(t), MAX_MISSING_SYNCS + 1)
    if points < 4:
        nowhere = np.full(len(t), np.nan)
        return nowhere, nowhere, never
    after = np.searchsorted(axis.time_ns, t, side="right")
    outside = (after == 0) | (t > axis.time_ns[-1])
    # Two points on either side; at the ends of the track the first or last four.
    k = np.clip(after - 2, 0, points - 4)
    c, node = axis.newton, axis.time_ns
    value, rate = c[3][k], np.zeros(len(t))
    for term in (2, 1, 0):
        from_node = t - node[k + term]
        rate = value + from_node * rate
        value = c[term][k] + from_node * value
    missing = axis.sync_number[k + 3] - axis.sync_number[k] - 3
    return value, rate, np.where(outside, never, missing)
