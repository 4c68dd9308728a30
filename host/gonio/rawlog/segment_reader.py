"""segment_reader.py: reads one MCAP file of a raw log up to its first bad record, and says what stopped it.

Nothing is believed unchecked: payloads by the link frame's own CRC, the order of messages by their running number, the
metadata by its CRC. A flipped bit is found, or it is in a place that no result depends on (MCAP's own times, schemas).
"""

import hashlib
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from google.protobuf.message import DecodeError
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from gonio.protocol.blocks import BlockError, pose_block, sample_block
from gonio.protocol.frames import HEADER_SIZE, MAX_PAYLOAD, FrameError, decode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.layout import PROFILE, unpack_metadata
from gonio.units.errors import UsageError

_RECORD = struct.Struct("<BQ")  # opcode, length
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_LONGEST_MESSAGE = _MESSAGE.size + HEADER_SIZE + MAX_PAYLOAD
_BEFORE_MESSAGES = frozenset({Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL})
_SUMMARY = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS, Opcode.SUMMARY_OFFSET})


class _Stopped(Exception):  # noqa: N818 - control flow inside this file
    """The end of what can be read; `cut` when the file simply ends there."""

    def __init__(self, why: str, *, cut: bool = False) -> None:
        super().__init__(why)
        self.cut = cut


@dataclass
class Segment:
    """What one file holds, up to its first bad record."""

    path: Path
    sha256: str
    metadata: dict[str, Any]
    sample_payloads: list[memoryview] = field(default_factory=list)
    pose_payloads: list[memoryview] = field(default_factory=list)
    events: list[pb.Event] = field(default_factory=list)
    requests: list[pb.Request] = field(default_factory=list)
    info: pb.Info | None = None  # what the firmware last said of itself and the drives: after boot, with their notes
    messages: int = 0
    link_gap_frames: int = 0  # firmware frames that the host never got
    complete: bool = False  # the footer is there
    problem: str | None = None
    damaged: bool = False  # more than a file that simply ends


def read_segment(path: Path) -> Segment:
    """Read one file. Raises UsageError when it cannot be read, is no raw log, or has no whole metadata."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    return parse_segment(path, data)


def parse_segment(path: Path, data: bytes) -> Segment:
    """Read a file's bytes; `path` names it. Raises UsageError as read_segment does."""
    if data[: len(MCAP0_MAGIC)] != MCAP0_MAGIC:
        raise UsageError(f"{path}: not a raw log (no MCAP file); gonio scan writes them")
    parser = _Parser(path, data)
    try:
        parser.run()
    except _Stopped as stop:
        segment = parser.segment
        if segment is None:
            raise UsageError(f"{path}: {stop} before the metadata: nothing of it can be used") from stop
        segment.damaged = not stop.cut
        segment.problem = (
            f"{path}: {stop} at byte {parser.position}; {len(segment.sample_payloads)} sample blocks and"
            f" {len(segment.pose_payloads)} pose blocks before it are good"
        )
    assert parser.segment is not None
    return parser.segment


class _Parser:
    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        self.data = data
        self.view = memoryview(data)
        self.position = len(MCAP0_MAGIC)
        self.segment: Segment | None = None
        self._last_frame = 0

    def run(self) -> None:
        self._header()
        while True:
            opcode, body = self._record()
            if opcode == Opcode.MESSAGE:
                self._message(body)
            elif opcode == Opcode.DATA_END and self.segment is not None and len(body) == 4:
                break
            elif self.segment is not None or opcode not in _BEFORE_MESSAGES:
                raise _Stopped(f"a record of kind {opcode} that does not belong there")
            self._advance(body)
        assert self.segment is not None
        while opcode != Opcode.FOOTER:
            self._advance(body)
            opcode, body = self._record()
            if opcode != Opcode.FOOTER and opcode not in _SUMMARY:
                raise _Stopped("a damaged summary")
        self._advance(body)
        if self.data[self.position :] != MCAP0_MAGIC:
            raise _Stopped("a damaged end of file")
        self.segment.complete = True

    def _record(self) -> tuple[int, memoryview]:
        if self.position + _RECORD.size > len(self.data):
            raise _Stopped("the file ends", cut=True)
        opcode, length = _RECORD.unpack_from(self.data, self.position)
        if self.segment is not None and opcode == Opcode.MESSAGE and length > _LONGEST_MESSAGE:
            raise _Stopped("a message that is too long")
        start = self.position + _RECORD.size
        if start + length > len(self.data):
            raise _Stopped("the file ends inside a record", cut=True)
        return opcode, self.view[start : start + length]

    def _advance(self, body: memoryview) -> None:
        self.position += _RECORD.size + len(body)

    def _header(self) -> None:
        opcode, body = self._record()
        size = int.from_bytes(body[:4], "little")
        if opcode != Opcode.HEADER or bytes(body[4 : 4 + size]) != PROFILE.encode():
            raise UsageError(f"{self.path}: an MCAP file, but not a raw log of gonio")
        self._advance(body)

    def _message(self, body: memoryview) -> None:
        if len(body) < _MESSAGE.size:
            raise _Stopped("a message that is too short")
        number = _MESSAGE.unpack_from(body)[1]
        content = body[_MESSAGE.size :]
        if self.segment is None:
            metadata = unpack_metadata(bytes(content))
            if metadata is None or number != 0:
                raise _Stopped("damaged")
            self.segment = Segment(self.path, hashlib.sha256(self.data).hexdigest(), metadata)
        else:
            if number != self.segment.messages & 0xFFFFFFFF:
                raise _Stopped(f"message {self.segment.messages} is missing")
            self._frame(self.segment, content)
        self.segment.messages += 1

    def _frame(self, segment: Segment, content: memoryview) -> None:
        try:
            frame = decode_frame(bytes(content))
            if frame is None or len(frame.raw) != len(content):
                raise _Stopped("a link frame that does not fill its message")
            payload = frame.payload
            if frame.kind == records.FRAME_SAMPLES:
                sample_block(payload)
                segment.sample_payloads.append(payload)
            elif frame.kind == records.FRAME_POSES:
                pose_block(payload)
                segment.pose_payloads.append(payload)
            elif frame.kind == records.FRAME_EVENT:
                segment.events.append(pb.Event.FromString(bytes(payload)))
            elif frame.kind == records.FRAME_REPLY:
                reply = pb.Reply.FromString(bytes(payload))
                segment.info = reply.info if reply.HasField("info") else segment.info
            elif frame.kind == records.FRAME_REQUEST:
                segment.requests.append(pb.Request.FromString(bytes(payload)))
                return
        except (FrameError, BlockError, DecodeError) as error:
            raise _Stopped("a damaged link frame") from error
        if frame.sequence > self._last_frame and self._last_frame:
            segment.link_gap_frames += frame.sequence - self._last_frame - 1
        self._last_frame = frame.sequence
