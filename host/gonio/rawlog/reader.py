"""reader.py: a whole raw log, its segments joined, as numpy arrays and events."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.decode import decode_pose_blocks, decode_pose_sigmas, decode_sample_blocks
from gonio.rawlog.segment_reader import Segment, read_segment
from gonio.units.errors import UsageError


@dataclass
class RawLog:
    """A raw log as it came over the link. Every segment has its own boot: sample numbers, SYNC numbers and controller
    time start anew, so `sample_segment`, `pose_segment` and `event_segment` (index from 0) go with them.

    Arrays `sample_*` have shape (n,), `poses` and `pose_*` (m,), `sample_blocks` one row per block.
    """

    metadata: dict[str, Any]  # of the first segment (program, plan, instrument text, versions); paths of all segments
    segments: list[Segment]
    samples: NDArray[np.void]  # SAMPLE_DTYPE
    sample_number: NDArray[np.uint64]
    sample_time_ns: NDArray[np.int64]  # controller clock by the fitted sample clock; no delay corrected
    sample_settled: NDArray[np.bool_]
    sample_segment: NDArray[np.int32]
    sample_blocks: NDArray[np.void]  # SAMPLE_BLOCK_DTYPE
    poses: NDArray[np.void]  # POSE_DTYPE
    pose_sigma_us: NDArray[np.float32]  # standard uncertainty of sync_time_ns, of the CAN interface
    pose_segment: NDArray[np.int32]
    events: list[pb.Event]
    event_segment: list[int]

    @property
    def sha256s(self) -> list[str]:
        """SHA-256 of each file, in hexadecimal."""
        return [segment.sha256 for segment in self.segments]

    @property
    def time_origin_ns(self) -> NDArray[np.int64]:
        """Controller time of each segment's first sample (0 where it has none), shape (segments,)."""
        first = np.searchsorted(self.sample_segment, np.arange(len(self.segments)))
        present = np.isin(np.arange(len(self.segments)), self.sample_segment)
        origins = np.zeros(len(self.segments), np.int64)
        origins[present] = self.sample_time_ns[first[present]]
        return origins

    @property
    def complete(self) -> bool:
        """The last segment has its footer and no segment is damaged."""
        return self.problem is None

    @property
    def problem(self) -> str | None:
        """What stopped the reader and how much there is. A segment that just ends is no problem once it was resumed."""
        for segment in self.segments:
            if segment.problem and (segment.damaged or segment is self.segments[-1]):
                return segment.problem
        return None

    @property
    def damaged(self) -> bool:
        """Some file holds bytes that are not what was written; a file that merely ends is not damaged."""
        return any(segment.damaged for segment in self.segments)


def read_rawlog(paths: Sequence[Path]) -> RawLog:
    """Read the segments of one log, in order. Reading stops at the first bad record of each file; see `problem`.

    Raises UsageError for a file that is no raw log, or when the files are not segments of one scan.
    """
    if not paths:
        raise UsageError("no raw log named")
    segments = [read_segment(path) for path in paths]
    first = segments[0].metadata
    for segment in segments[1:]:
        for key in ("plan_sha256", "instrument_sha256"):
            if segment.metadata.get(key) != first.get(key):
                raise UsageError(f"{segment.path}: of another scan than {segments[0].path} ({key} differs)")
    decoded = [decode_sample_blocks(segment.sample_payloads) for segment in segments]
    poses = [decode_pose_blocks(segment.pose_payloads) for segment in segments]
    header_size = records.SAMPLE_BLOCK_DTYPE.itemsize
    headers = b"".join(payload[:header_size] for segment in segments for payload in segment.sample_payloads)
    return RawLog(
        metadata=first | {"paths": _all_paths(segments)},
        segments=segments,
        samples=np.concatenate([part.samples for part in decoded]),
        sample_number=np.concatenate([part.number for part in decoded]),
        sample_time_ns=np.concatenate([part.time_ns for part in decoded]),
        sample_settled=np.concatenate([part.settled for part in decoded]),
        sample_segment=_segment_index([len(part.samples) for part in decoded]),
        sample_blocks=np.frombuffer(headers, records.SAMPLE_BLOCK_DTYPE),
        poses=np.concatenate(poses),
        pose_sigma_us=np.concatenate([decode_pose_sigmas(segment.pose_payloads) for segment in segments]),
        pose_segment=_segment_index([len(part) for part in poses]),
        events=[event for segment in segments for event in segment.events],
        event_segment=[index for index, segment in enumerate(segments) for _ in segment.events],
    )


def _segment_index(counts: Sequence[int]) -> NDArray[np.int32]:
    return np.repeat(np.arange(len(counts), dtype=np.int32), counts)


def _all_paths(segments: Sequence[Segment]) -> list[dict[str, Any]]:
    """The paths of every segment's program; resumed ones keep the ids of what is measured, moves have fresh ones."""
    paths: dict[int, dict[str, Any]] = {}
    for segment in segments:
        for path in segment.metadata.get("paths", []):
            paths.setdefault(path["path_id"], path)
    return list(paths.values())
