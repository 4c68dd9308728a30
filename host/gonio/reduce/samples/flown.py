"""flown.py: the samples of each path that was flown, paired with their poses and turned into light."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.geometry.kinematics import Kinematics
from gonio.rawlog.reader import RawLog
from gonio.reduce.corrections.light import Dark, Gains, light_of
from gonio.reduce.samples.pairing import PoseTrack
from gonio.reduce.samples.timeline import PathInterval, inside, path_intervals, shutter_closed_ns
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]
MEASURING = ("reference", "coarse", "peak")


@dataclass
class Flown:
    """One path, or the part of one that a segment holds. Arrays over its samples (n,), vectors (n, 3)."""

    path_id: int
    kind: str
    name: str
    incident_deg: tuple[float, float] | None
    finished: bool
    time_ns: NDArray[np.int64]  # of the light, controller clock
    incident: FloatArray  # sample frame
    outgoing: FloatArray
    detector_lab: FloatArray
    signal: FloatArray  # dark-subtracted, low-gain counts
    dark_variance: FloatArray
    monitor_counts: FloatArray
    flags: NDArray[np.uint16]


@dataclass
class Losses:
    """Samples that were recorded on a path but have no place among the points."""

    pose_lost: int = 0
    clock_unsettled: int = 0
    notes: list[str] = field(default_factory=list)


def flown_paths(log: RawLog, instrument: Instrument, losses: Losses) -> tuple[list[Flown], Dark]:
    """All measuring paths of all segments, in the order flown, and the darks of the last segment that has some.

    Each segment has its own clock and is paired with its own poses and darks; one without darks (the scan was cut off
    before) uses another's. Raises UsageError where no segment has a dark.
    """
    gains, kinematics = Gains.of(instrument), Kinematics(instrument.axes)
    parts = [_Part.of(log, number) for number in range(max(len(log.sha256s), 1))]
    darks = [part.dark for part in parts if part.dark is not None]
    if not darks:
        raise UsageError(
            "the raw log holds no stretch with the shutter closed: the offset is unknown; plan a [dark] step"
        )
    paths = {int(entry["path_id"]): entry for entry in log.metadata.get("paths", ())}
    flown: list[Flown] = []
    last = darks[0]
    for number, part in enumerate(parts):
        if part.dark is None:
            losses.notes.append(f"segment {number + 1} has no dark of its own: the offset is that of another segment")
        dark = last = part.dark or last.held_at(part.first_ns)
        track = PoseTrack.from_poses(log.poses[log.pose_segment == number], instrument.axes)
        for interval in path_intervals(part.events, part.last_ns):
            entry = paths.get(interval.path_id)
            if entry is not None and entry["kind"] in MEASURING:
                flown += _measure(part, interval, entry, track, (dark, gains, kinematics), losses)
    return flown, last


@dataclass
class _Part:
    """One segment's samples (n,), events and darks."""

    samples: NDArray[np.void]
    time_ns: NDArray[np.int64]
    settled: NDArray[np.bool_]
    events: list[Any]
    closed_ns: NDArray[np.int64]
    dark: Dark | None

    @classmethod
    def of(cls, log: RawLog, number: int) -> "_Part":
        begin, end = np.searchsorted(log.sample_segment, (number, number + 1))
        samples, time_ns = log.samples[begin:end], log.sample_time_ns[begin:end]
        events = [event for event, segment in zip(log.events, log.event_segment, strict=True) if segment == number]
        closed_ns = shutter_closed_ns(events, int(time_ns[-1]) if len(time_ns) else 0)
        dark = Dark.measure(time_ns, samples, inside(time_ns, closed_ns))
        return cls(samples, time_ns, log.sample_settled[begin:end], events, closed_ns, dark)

    @property
    def first_ns(self) -> int:
        return int(self.time_ns[0]) if len(self.time_ns) else 0

    @property
    def last_ns(self) -> int:
        return int(self.time_ns[-1]) if len(self.time_ns) else 0


def _measure(
    part: _Part,
    interval: PathInterval,
    entry: dict[str, Any],
    track: PoseTrack,
    tools: tuple[Dark, Gains, Kinematics],
    losses: Losses,
) -> Iterator[Flown]:
    dark, gains, kinematics = tools
    # A block's time may be stamped before the clock settles; those samples are not in order and not used anyway.
    on_path = (part.time_ns >= interval.begin_ns) & (part.time_ns <= interval.end_ns)
    on_path &= ~inside(part.time_ns, part.closed_ns)
    losses.clock_unsettled += int(np.count_nonzero(on_path & ~part.settled))
    index = np.flatnonzero(on_path & part.settled)
    samples, strobe_ns = part.samples[index], part.time_ns[index]
    high_weight = gains.high_weight(samples)
    delay_ns = gains.delay_ns(high_weight)
    q_deg, pose_flags = track.pose_at(strobe_ns, delay_ns)
    kept = pose_flags & PointFlag.POSE_LOST == 0
    losses.pose_lost += int(np.count_nonzero(~kept))
    if not kept.any():
        return
    light = light_of(samples[kept], strobe_ns[kept], high_weight[kept], dark, gains)
    incident, outgoing = kinematics.directions(q_deg[kept])
    theta = entry.get("incident_theta_deg")
    yield Flown(
        path_id=interval.path_id,
        kind=entry["kind"],
        name=str(entry.get("name", interval.path_id)),
        incident_deg=None if theta is None else (float(theta), float(entry["incident_phi_deg"])),
        finished=interval.finished,
        time_ns=strobe_ns[kept] - np.rint(delay_ns[kept]).astype(np.int64),
        incident=incident,
        outgoing=outgoing,
        detector_lab=kinematics.detector_in_lab(q_deg[kept]),
        signal=light.signal,
        dark_variance=light.dark_variance,
        monitor_counts=light.monitor_counts,
        flags=light.flags | pose_flags[kept],
    )
