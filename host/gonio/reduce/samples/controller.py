"""controller.py: how the controller was: kernel, what its drives lack, how late it woke, how well it knew the time."""

from collections.abc import Iterable
from itertools import zip_longest
from typing import Any

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import RawLog
from gonio.reduce.samples.pairing import time_u_us
from gonio.units.instrument import Instrument

_THREADS = {pb.THREAD_MOTION: "motion", pb.THREAD_STREAM: "stream"}


def controller_facts(log: RawLog, instrument: Instrument) -> dict[str, Any]:
    """For the provenance, plain JSON; what the log does not tell is left out, so a twin in virtual time has nothing.

    kernel, realtime (False when one segment was not), notes (drive: fallbacks in use), latency (see latency_of),
    position_time_u_us (axis: standard uncertainty).
    """
    infos = [segment.info for segment in log.segments if segment.info is not None]
    facts: dict[str, Any] = {}
    if kernels := list(dict.fromkeys(info.kernel for info in infos if info.kernel)):
        facts["kernel"] = "; ".join(kernels)
        facts["realtime"] = all(info.realtime for info in infos if info.kernel)
    if notes := {f"node {node.node}": node.notes for info in infos for node in info.nodes if node.notes}:
        facts["notes"] = notes
    if latency := latency_of(log):
        facts["latency"] = latency
    if log.pose_sigma_us.any():
        facts["position_time_u_us"] = {axis.name: time_u_us(axis, log.pose_sigma_us) for axis in instrument.axes}
    return facts


def latency_of(log: RawLog) -> dict[str, dict[str, Any]]:
    """How late each thread woke during the scan: thread: wakeups, bins (as protocol/gonio.proto has them), and max_us,
    which is the longest since the firmware's start."""
    found: dict[str, dict[str, Any]] = {}
    for number in range(len(log.segments)):
        own = [e.latency for e, of in zip(log.events, log.event_segment, strict=True) if of == number]
        for thread, name in _THREADS.items():
            reports = [latency for latency in own if latency.thread == thread]
            if not reports:
                continue
            total = found.setdefault(name, {"wakeups": 0, "max_us": 0, "bins": []})
            # They count from the firmware's start: what was before the scan is not part of it.
            first = reports[0] if len(reports) > 1 else pb.Latency()
            total["wakeups"] += reports[-1].wakeups - first.wakeups
            total["max_us"] = max(total["max_us"], reports[-1].max_us)
            total["bins"] = _sum(total["bins"], _sum(reports[-1].bins, (-count for count in first.bins)))
    return found


def late_at_most_us(latency: dict[str, Any], share: float) -> float:
    """By how much at most this share of the wake-ups was late: the upper end of their bin [us]."""
    needed = share * sum(latency["bins"])
    so_far = 0
    for index, count in enumerate(latency["bins"]):
        so_far += count
        if so_far >= needed:
            return float(min(2**index, latency["max_us"]))
    return float(latency["max_us"])


def _sum(a: Iterable[int], b: Iterable[int]) -> list[int]:
    return [x + y for x, y in zip_longest(a, b, fillvalue=0)]
