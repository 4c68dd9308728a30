"""frames.py: link frames: encoding, and an incremental decoder that checks everything before it believes anything."""

import struct
from enum import Enum
from typing import NamedTuple

import google_crc32c

from gonio.protocol.generated import records
from gonio.units.errors import InstrumentFault

MAGIC = 0x4E47
VERSION = 1
HEADER_SIZE = 20
MAX_PAYLOAD = 65536
# These kinds are not numbered: their sequence is 0 (protocol/link.md).
UNNUMBERED = frozenset({records.FRAME_HELLO, records.FRAME_IDLE, records.FRAME_ALIVE})
_KINDS = frozenset(range(records.FRAME_HELLO, records.FRAME_ALIVE + 1))
_HEADER = struct.Struct("<HBBIII")  # without the CRC
_CRC = struct.Struct("<I")


class FrameProblem(Enum):
    """Why bytes are no frame; the names are those of protocol/vectors."""

    MAGIC = "magic"
    VERSION = "version"
    KIND = "kind"
    LENGTH = "length"
    CRC = "crc"


class FrameError(InstrumentFault):
    """The stream holds something that is no frame; nothing after it can be trusted."""

    def __init__(self, problem: FrameProblem, detail: str) -> None:
        super().__init__(f"the link is damaged: {detail}; check the cable and start again")
        self.problem = problem


class Frame(NamedTuple):
    """One frame; `raw` holds its bytes, header included."""

    kind: int
    sequence: int
    acknowledged: int
    raw: bytes

    @property
    def payload(self) -> memoryview:
        """The payload's bytes, in place."""
        return memoryview(self.raw)[HEADER_SIZE:]


def encode_frame(kind: int, sequence: int, acknowledged: int, payload: bytes = b"") -> bytes:
    """The bytes of a frame. Raises ValueError when the payload is longer than a frame can carry."""
    if len(payload) > MAX_PAYLOAD:
        raise ValueError(f"payload of {len(payload)} bytes; a frame carries {MAX_PAYLOAD}")
    head = _HEADER.pack(MAGIC, VERSION, kind, sequence, acknowledged, len(payload))
    return head + _CRC.pack(google_crc32c.value(head + payload)) + payload


def decode_frame(data: bytes, start: int = 0) -> Frame | None:
    """The frame that begins at `start`, or None when more bytes are needed. Raises FrameError."""
    available = len(data) - start
    if available >= 2 and data[start : start + 2] != b"GN":
        raise FrameError(FrameProblem.MAGIC, f"bytes {data[start : start + 2].hex()} where a frame should begin")
    if available < HEADER_SIZE:
        return None
    _, version, kind, sequence, acknowledged, length = _HEADER.unpack_from(data, start)
    if version != VERSION:
        raise FrameError(FrameProblem.VERSION, f"frame version {version}, this program speaks {VERSION}")
    if length > MAX_PAYLOAD:
        raise FrameError(FrameProblem.LENGTH, f"a frame says {length} bytes, {MAX_PAYLOAD} are possible")
    end = start + HEADER_SIZE + length
    if len(data) < end:
        return None
    raw = data[start:end]
    crc = google_crc32c.extend(google_crc32c.value(raw[:16]), raw[HEADER_SIZE:])
    if crc != _CRC.unpack_from(raw, 16)[0]:
        raise FrameError(FrameProblem.CRC, f"frame {sequence} (kind {kind}, {length} bytes) has a wrong check sum")
    if kind not in _KINDS:
        raise FrameError(FrameProblem.KIND, f"frame {sequence} is of unknown kind {kind}")
    return Frame(kind, sequence, acknowledged, raw)


class FrameDecoder:
    """Takes the stream in pieces of any size and gives whole frames."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[Frame]:
        """The frames that are complete now. Raises FrameError at the first bad one; use the decoder no more."""
        buffer = self._rest + data if self._rest else data
        frames: list[Frame] = []
        start = 0
        while (frame := decode_frame(buffer, start)) is not None:
            frames.append(frame)
            start += len(frame.raw)
        self._rest = buffer[start:]
        return frames
