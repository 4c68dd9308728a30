"""pairing_budget.py: how far the reduced direction of a sample is off, part by part, all axes swinging at 30 degrees/s.

Encoder positions, SYNC jitter and strobe latency are made in numpy; the figures with firmware and twin in between are
those of the level-1 tests. Run from host/: ../.venv/bin/python benchmarks/pairing_budget.py
"""

import sys

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import angle_between_deg
from gonio.geometry.kinematics import Kinematics
from gonio.protocol.generated.records import POSE_DTYPE
from gonio.reduce.pairing import PoseTrack
from gonio.units.instrument import Instrument, load_instrument

FloatArray = NDArray[np.float64]
DURATION_S = 60.0
SYNC_JITTER_US = 120.0
STROBE_LATENCY_US = 50.0
SAMPLES_PER_STROBE = 10
WINDOW_STROBES = 200
AMPLITUDE_DEG = np.array([15.0, 20.0, 25.0, 18.0])
MIDDLE_DEG = np.array([40.0, 90.0, 30.0, 0.0])


def readings_deg(time_s: NDArray[np.floating]) -> FloatArray:
    """Sinusoids of 30 degrees/s about the middle, each axis of its own period; shape (n, 4)."""
    phase = 30.0 / AMPLITUDE_DEG * time_s[:, None] + np.arange(4)
    return np.asarray(MIDDLE_DEG + AMPLITUDE_DEG * np.sin(phase))


def poses(instrument: Instrument, rng: np.random.Generator, *, jitter_us: float, quantised: bool) -> NDArray[np.void]:
    """Positions at SYNCs every 2 ms, moved by up to the jitter. Unquantised: an encoder 1000 times as fine."""
    count = round(DURATION_S * 500)
    sync_ns = np.arange(count, dtype=np.int64) * 2_000_000
    sync_ns += np.rint(rng.uniform(-jitter_us, jitter_us, count) * 1e3).astype(np.int64)
    found = np.zeros(count, dtype=POSE_DTYPE)
    found["sync_time_ns"], found["sync_number"], found["valid"] = sync_ns, np.arange(count) + 1, 0b1111
    scale = 1.0 if quantised else 1000.0
    for number, axis in enumerate(instrument.axes):
        at_s = sync_ns * 1e-9 + axis.latch_delay_us * 1e-6
        found["position_counts"][:, number] = np.rint(readings_deg(at_s)[:, number] * axis.counts_per_deg * scale)
    return found


def strobe_error_ns(rng: np.random.Generator) -> FloatArray:
    """Error of a line below the stamps of a window of strobes, at the window's end, for each sample after it (n,)."""
    strobes = round(DURATION_S * 1000 / SAMPLES_PER_STROBE)
    late_ns = rng.exponential(STROBE_LATENCY_US * 1e3, strobes)
    x = np.arange(WINDOW_STROBES, dtype=np.float64)
    error = np.zeros(strobes)
    for last in range(WINDOW_STROBES, strobes):
        y = late_ns[last - WINDOW_STROBES : last]
        error[last] = _hull_line_at(x, y, float(WINDOW_STROBES))
    return np.repeat(error, SAMPLES_PER_STROBE)


def _hull_line_at(x: FloatArray, y: FloatArray, where: float) -> float:
    """The lower convex hull's edge over the middle of x, continued to `where`."""
    hull: list[int] = []
    for i in range(len(x)):
        while len(hull) > 1 and (y[hull[-1]] - y[hull[-2]]) * (x[i] - x[hull[-2]]) >= (y[i] - y[hull[-2]]) * (
            x[hull[-1]] - x[hull[-2]]
        ):
            hull.pop()
        hull.append(i)
    right = next(k for k in range(1, len(hull)) if x[hull[k]] >= x.mean())
    a, b = hull[right - 1], hull[right]
    return float(y[a] + (y[b] - y[a]) / (x[b] - x[a]) * (where - x[a]))


def main() -> None:
    """Print maximum and rms of the outgoing direction's error for each part alone and for all together."""
    instrument = load_instrument(None)
    kinematics = Kinematics(instrument.axes)
    sample_ns = np.arange(2_100_000_000, round((DURATION_S - 0.1) * 1e9), 1_000_000, dtype=np.int64)
    truth = kinematics.directions(readings_deg(sample_ns * 1e-9))[1]
    strobe = strobe_error_ns(np.random.default_rng(2))[2100 : 2100 + len(sample_ns)]
    rows = (
        ("quantisation (400,000 counts per turn)", 0.0, True, False),
        (f"SYNC (jitter {SYNC_JITTER_US:g} us, cubic)", SYNC_JITTER_US, False, False),
        (f"strobe (latency {STROBE_LATENCY_US:g} us, envelope)", 0.0, False, True),
        ("all together", SYNC_JITTER_US, True, True),
    )
    for name, jitter_us, quantised, with_strobe in rows:
        found = poses(instrument, np.random.default_rng(1), jitter_us=jitter_us, quantised=quantised)
        q_deg, flags = PoseTrack.from_poses(found, instrument.axes).pose_at(
            sample_ns + np.rint(strobe * with_strobe).astype(np.int64)
        )
        direction = kinematics.directions(q_deg if quantised else q_deg / 1000.0)[1]
        error = angle_between_deg(direction, truth)
        rms = float(np.sqrt(np.mean(error**2)))
        sys.stdout.write(
            f"{name:45s} max {error.max():.6f} deg  rms {rms:.6f} deg  flagged {np.count_nonzero(flags)}\n"
        )


if __name__ == "__main__":
    main()
