"""timeline.py: what a raw log's events say about time: which path flew when, and when the shutter was closed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated import gonio_pb2 as pb

# A shutter's blade takes tens of milliseconds; this much on either side of its event is neither light nor dark.
SHUTTER_SETTLE_NS = 100_000_000


@dataclass(frozen=True)
class PathInterval:
    """From the moment a path begins to move to its end, controller clock."""

    path_id: int
    begin_ns: int
    end_ns: int
    finished: bool


def path_intervals(events: Iterable[pb.Event], last_ns: int) -> list[PathInterval]:
    """The paths that flew, in order; one that the log cuts off ends, unfinished, at `last_ns`."""
    intervals: list[PathInterval] = []
    running: tuple[int, int] | None = None
    for event in events:
        if event.WhichOneof("body") != "path":
            continue
        state = event.path
        if running is not None and (state.end != pb.PATH_RUNNING or state.path_id != running[0]):
            finished = state.end == pb.PATH_FINISHED and state.path_id == running[0]
            intervals.append(PathInterval(*running, event.time_ns, finished))
            running = None
        if state.end == pb.PATH_RUNNING and running is None:
            running = (state.path_id, event.time_ns)
    if running is not None:
        intervals.append(PathInterval(*running, max(last_ns, running[1]), finished=False))
    return intervals


def shutter_closed_ns(events: Iterable[pb.Event], last_ns: int) -> NDArray[np.int64]:
    """Intervals (k, 2), controller clock, in which every report said that the shutter was closed, less its own time."""
    reports: list[tuple[int, bool]] = []
    for event in events:
        body = event.WhichOneof("body")
        if body == "status":
            reports.append((event.time_ns, event.status.shutter_open))
        elif body == "output" and event.output.output == pb.OUTPUT_SHUTTER:
            reports.append((event.time_ns, event.output.on))
    reports.sort(key=lambda report: report[0])
    closed: list[tuple[int, int]] = []
    since: int | None = None
    for time_ns, is_open in [*reports, (last_ns + SHUTTER_SETTLE_NS, True)]:
        if is_open and since is not None:
            closed.append((since + SHUTTER_SETTLE_NS, time_ns - SHUTTER_SETTLE_NS))
            since = None
        elif not is_open and since is None:
            since = time_ns
    return np.array([pair for pair in closed if pair[1] > pair[0]], dtype=np.int64).reshape(-1, 2)


def inside(time_ns: NDArray[np.int64], intervals_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which times (n,) lie in any of the sorted, disjoint intervals (k, 2)."""
    if not len(intervals_ns):
        return np.zeros(len(time_ns), dtype=bool)
    index = np.searchsorted(intervals_ns[:, 0], time_ns, side="right") - 1
    return np.asarray((index >= 0) & (time_ns <= intervals_ns[np.maximum(index, 0), 1]))


# These run from the firmware's start, through all scans; the others begin with the acquisition.
_SINCE_START = frozenset(
    (
        "syncs",
        "sync_echoes_lost",
        "tpdo_late",
        "tpdo_missing",
        "tpdo_duplicate",
        "can_overflow",
        "can_error_frames",
        "poses_dropped",
        "cycles_missed",
        "can_setpoints_dropped",
        "can_bus_offs",
        "clock_steps",
        "edges_lost",
    )
)


def counted(events: Sequence[pb.Event], first_sample_ns: int) -> dict[str, int]:
    """What the firmware counted in a segment (lost samples, edges, frames, ...), by protocol name; zeros when it sent
    no counters. What it had counted before the first sample, in earlier scans too, is not part of it."""
    reports = [event for event in events if event.WhichOneof("body") == "counters"]
    last = reports[-1].counters if reports else pb.Counters()
    earlier = [report for report in reports if report.time_ns <= first_sample_ns]
    # A scan of an instrument that is homed takes its first sample before the first report is due, at most a second on.
    before = (earlier[-1:] or reports[:-1][:1] or [pb.Event()])[-1].counters
    return {
        field.name: int(getattr(last, field.name))
        - (int(getattr(before, field.name)) if field.name in _SINCE_START else 0)
        for field in pb.Counters.DESCRIPTOR.fields
    }
