"""resume.py: what an interrupted scan has already measured, read from its raw log."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gonio.plan.program import Program
from gonio.plan.resume import remaining
from gonio.protocol.blocks import pose_block, sample_block
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.segment_reader import Segment
from gonio.units.errors import UsageError

# Reduction interpolates over the next SYNC positions: the last few of them have no neighbour on the other side.
EDGE_NS = 20_000_000


@dataclass(frozen=True)
class Measured:
    """Paths that are whole in the log, and the one that is partly there: (path id, path time up to which it is)."""

    done: frozenset[int]
    partial: tuple[int, int] | None


def covered_until_ns(segment: Segment) -> int:
    """Controller time up to which the log has both samples and poses; 0 when it has none."""
    if not segment.sample_payloads or not segment.pose_payloads:
        return 0
    header, samples = sample_block(segment.sample_payloads[-1])
    _, poses = pose_block(segment.pose_payloads[-1])
    sample_end_ns = int(header["first_time_ns"]) + round(len(samples) * float(header["period_ns"]))
    pose_end_ns = int(poses["sync_time_ns"][-1]) if len(poses) else 0
    return min(sample_end_ns, pose_end_ns) - EDGE_NS


def measured(segment: Segment) -> Measured:
    """What one segment has.

    An event counts only when samples and poses reach beyond it: a killed host may have written it, and then nothing
    more. Such a path is flown again from the last Status that they do reach.
    """
    covered_ns = covered_until_ns(segment)
    moves = {path["path_id"] for path in segment.metadata["paths"] if path["kind"] == "move"}
    done: set[int] = set()
    running: int | None = None
    reached_ns = 0
    for event in segment.events:
        if event.time_ns > covered_ns:
            break
        body = event.WhichOneof("body")
        if body == "path" and event.path.end == pb.PATH_RUNNING:
            running, reached_ns = event.path.path_id, 0
        elif body == "path" and event.path.end == pb.PATH_FINISHED:
            done.add(event.path.path_id)
            running = None
        elif body == "path" and event.path.path_id == running:
            reached_ns = event.path.path_time_ns
        elif body == "status" and event.status.path_id == running:
            reached_ns = max(reached_ns, event.status.path_time_ns)
    partial = (running, reached_ns) if running is not None and running not in moves and reached_ns > 0 else None
    return Measured(frozenset(done), partial)


def digest(text: str | bytes) -> str:
    """SHA-256 in hexadecimal; says whether a plan or an instrument file is the one of the log."""
    return hashlib.sha256(text.encode() if isinstance(text, str) else text).hexdigest()


def remaining_program(program: Program, segments: Sequence[Segment]) -> Program:
    """What is left of a program after these segments: each was the rest of the one before."""
    for segment in segments:
        part = measured(segment)
        program = remaining(program, set(part.done), part.partial)
    return program


def check_same_scan(segments: Sequence[Segment], plan_sha256: str, instrument_sha256: str, plan: Path) -> None:
    """Raise UsageError when the log is of another plan or instrument, or holds damage."""
    for segment in segments:
        if segment.damaged:
            raise UsageError(f"{segment.problem}; it cannot be resumed: reduce what is good, and scan anew")
        for key, value, what in (
            ("plan_sha256", plan_sha256, f"plan {plan}"),
            ("instrument_sha256", instrument_sha256, "instrument file"),
        ):
            if segment.metadata.get(key) != value:
                raise UsageError(f"{segment.path}: was written with another {what}: resume with the same, or scan anew")
