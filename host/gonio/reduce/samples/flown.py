"""flown.py: the samples of each path that was flown, paired with their poses and turned into light."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.geometry.kinematics import SOURCE_LAB, Kinematics
from gonio.rawlog.reader import RawLog
from gonio.reduce.corrections import dark as dark_correction
from gonio.reduce.corrections import light, linearity
from gonio.reduce.corrections.chain import Switches
from gonio.reduce.corrections.dark import Dark
from gonio.reduce.corrections.light import Gains, light_of
from gonio.reduce.samples.pairing import PoseTrack
from gonio.reduce.samples.strobes import beside_lost_strobes
from gonio.reduce.samples.timeline import PathInterval, inside, path_intervals, shutter_closed_ns
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]
MEASURING = ("reference", "coarse", "peak")
ALL_ON = Switches()
_CHUNK = 1 << 14  # samples at a time: what they need stays in the processor's cache


@dataclass
class Flown:
    """One path, or the part of one that a segment holds. Arrays over its samples (n,), vectors (n, 3)."""

    path_id: int
    kind: str
    name: str
    incident_deg: tuple[float, float] | None
    finished: bool
    time_ns: NDArray[np.int64]  # of the light, controller clock
    incident: FloatArray  # (3,), sample frame: the mean
    unit: FloatArray  # the arm's direction: in the lab frame for a reference scan, else in the sample frame
    cosine_from_source: FloatArray  # of the angle between detector and source
    q_deg: FloatArray  # (n, axes)
    axis_rate_deg_per_s: FloatArray  # (n, axes)
    high_weight: FloatArray
    signal: FloatArray  # dark-subtracted and linear, low-gain counts
    dark_variance: FloatArray
    dark_u_counts: FloatArray
    monitor_counts: FloatArray
    flags: NDArray[np.uint16]


@dataclass
class Losses:
    """Samples that were recorded on a path but have no place among the points."""

    pose_lost: int = 0
    clock_unsettled: int = 0
    notes: list[str] = field(default_factory=list)


def flown_paths(
    log: RawLog, instrument: Instrument, losses: Losses, switches: Switches = ALL_ON
) -> tuple[list[Flown], Dark]:
    """All measuring paths of all segments, in the order flown, and the darks of the last segment that has some.

    Each segment has its own clock and is paired with its own poses and darks; one without darks (the scan was cut off
    before) uses another's. Raises UsageError where no segment has a dark.
    """
    tools = _Tools(Gains.of(instrument), Kinematics(instrument.axes), instrument.calibration.nonlinearity, switches)
    strobe_lost = beside_lost_strobes(log)
    parts = [_Part.of(log, strobe_lost, number) for number in range(max(len(log.sha256s), 1))]
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
                flown += _measure(part, interval, entry, (track, dark), tools, losses)
    return flown, last


@dataclass
class _Part:
    """One segment's samples (n,), events and darks."""

    samples: NDArray[np.void]
    time_ns: NDArray[np.int64]
    settled: NDArray[np.bool_]
    strobe_lost: NDArray[np.bool_]
    events: list[Any]
    closed_ns: NDArray[np.int64]
    dark: Dark | None

    @classmethod
    def of(cls, log: RawLog, strobe_lost: NDArray[np.bool_], number: int) -> "_Part":
        begin, end = np.searchsorted(log.sample_segment, (number, number + 1))
        samples, time_ns = log.samples[begin:end], log.sample_time_ns[begin:end]
        events = [event for event, segment in zip(log.events, log.event_segment, strict=True) if segment == number]
        closed_ns = shutter_closed_ns(events, int(time_ns[-1]) if len(time_ns) else 0)
        dark = Dark.measure(time_ns, samples, inside(time_ns, closed_ns))
        settled = log.sample_settled[begin:end]
        return cls(samples, time_ns, settled, strobe_lost[begin:end], events, closed_ns, dark)

    @property
    def first_ns(self) -> int:
        return int(self.time_ns[0]) if len(self.time_ns) else 0

    @property
    def last_ns(self) -> int:
        return int(self.time_ns[-1]) if len(self.time_ns) else 0


@dataclass(frozen=True)
class _Tools:
    gains: Gains
    kinematics: Kinematics
    nonlinearity: float
    switches: Switches


def _measure(
    part: _Part,
    interval: PathInterval,
    entry: dict[str, Any],
    around: tuple[PoseTrack, Dark],
    tools: _Tools,
    losses: Losses,
) -> Iterator[Flown]:
    (track, dark), gains, switches = around, tools.gains, tools.switches
    # A block's time may be stamped before the clock settles; those samples are not in order and not used anyway.
    on_path = (part.time_ns >= interval.begin_ns) & (part.time_ns <= interval.end_ns)
    on_path &= ~inside(part.time_ns, part.closed_ns)
    losses.clock_unsettled += int(np.count_nonzero(on_path & ~part.settled))
    index = np.flatnonzero(on_path & part.settled)
    samples, strobe_ns = part.samples[index], part.time_ns[index]
    high_weight = gains.high_weight(samples) if switches.on(light.NAME) else np.zeros(len(samples))
    delay_ns = gains.delay_ns(high_weight)
    poses = track.poses_at(strobe_ns, delay_ns)
    q_deg, rate, flags = poses.q_deg, poses.rate_deg_per_s, poses.flags
    kept = flags & PointFlag.POSE_LOST == 0
    lost = len(kept) - int(np.count_nonzero(kept))
    losses.pose_lost += lost
    if lost == len(kept):
        return
    if lost:
        index, samples, strobe_ns, q_deg, rate = index[kept], samples[kept], strobe_ns[kept], q_deg[kept], rate[kept]
        high_weight, delay_ns, flags = high_weight[kept], delay_ns[kept], flags[kept]
    found = light_of(samples, strobe_ns, high_weight, dark, gains, subtract=switches.on(dark_correction.NAME))
    signal, dark_variance, dark_u = found.signal, found.dark_variance, found.dark_u
    if switches.on(linearity.NAME) and tools.nonlinearity:
        signal, rise = linearity.linearised(signal, high_weight, gains, tools.nonlinearity)
        dark_variance, dark_u = dark_variance * rise**2, dark_u * np.abs(rise)
    lost_strobe = np.where(part.strobe_lost[index], np.uint16(PointFlag.STROBE_LOST), np.uint16(0))
    incident, unit, cosine = _directions(tools.kinematics, q_deg, in_lab=entry["kind"] == "reference")
    theta = entry.get("incident_theta_deg")
    yield Flown(
        path_id=interval.path_id,
        kind=entry["kind"],
        name=str(entry.get("name", interval.path_id)),
        incident_deg=None if theta is None else (float(theta), float(entry["incident_phi_deg"])),
        finished=interval.finished,
        time_ns=strobe_ns - np.rint(delay_ns).astype(np.int64),
        incident=incident,
        unit=unit,
        cosine_from_source=cosine,
        q_deg=q_deg,
        axis_rate_deg_per_s=rate,
        high_weight=high_weight,
        signal=signal,
        dark_variance=dark_variance,
        dark_u_counts=dark_u,
        monitor_counts=found.monitor_counts,
        flags=found.flags | flags | lost_strobe,
    )


def _directions(
    kinematics: Kinematics, q_deg: FloatArray, *, in_lab: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean incident direction (3,), the arm's directions (n, 3), and the cosine (n,) between both."""
    n = len(q_deg)
    unit, cosine, total = np.empty((n, 3)), np.empty(n), np.zeros(3)
    for begin in range(0, n, _CHUNK):
        part = slice(begin, begin + _CHUNK)
        if in_lab:
            unit[part] = kinematics.detector_in_lab(q_deg[part])
            cosine[part] = unit[part] @ SOURCE_LAB
            continue
        incident, unit[part] = kinematics.directions(q_deg[part])
        cosine[part] = np.einsum("ij,ij->i", incident, unit[part])
        total += incident.sum(axis=0)
    return SOURCE_LAB if in_lab else total / n, unit, cosine
