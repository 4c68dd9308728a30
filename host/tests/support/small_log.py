"""small_log.py: a small raw log with every kind of frame, made with the real writer from bytes made with struct."""

import struct
from pathlib import Path
from typing import Any

from gonio.protocol.frames import FrameDecoder, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.writer import RawLogWriter

METADATA: dict[str, Any] = {"plan_sha256": "aa", "instrument_sha256": "bb", "sample": {"name": "tile"}, "x": 0.1}
SAMPLES_PER_BLOCK = 4
POSES_PER_BLOCK = 3


def sample_payload(block: int, *, count: int = SAMPLES_PER_BLOCK, window: int = 200, flags: int = 0) -> bytes:
    """Block `block` of samples numbered on, 1 ms apart from 5 s; high_counts is the sample's number."""
    first = block * count
    head = struct.pack(
        "<QqdIIIIfIII", first, 5_000_000_000 + first * 1_000_000, 1e6, block, count, 0, 0, 0.0, window, flags, 0
    )
    return head + b"".join(struct.pack("<iiihH", first + k, 1, 2, 2150, 0) for k in range(count))


def pose_payload(block: int, *, count: int = POSES_PER_BLOCK) -> bytes:
    head = struct.pack("<IIII", block, count, 4, 0)
    first = block * count
    return head + b"".join(
        struct.pack("<qIiiiiBBH", 5_000_000_000 + (first + k) * 2_000_000, first + k + 1, 1, 2, 3, 4, 15, 0, 0)
        for k in range(count)
    )


def frames(blocks: int) -> list[bytes]:
    """Numbered firmware frames: per block an event, samples and poses; at the end a reply."""
    payloads: list[tuple[int, bytes]] = []
    for block in range(blocks):
        event = pb.Event(time_ns=5_000_000_000 + block, log=pb.Log(text=f"block {block}"))
        payloads.append((records.FRAME_EVENT, event.SerializeToString()))
        payloads.append((records.FRAME_SAMPLES, sample_payload(block)))
        payloads.append((records.FRAME_POSES, pose_payload(block)))
    payloads.append((records.FRAME_REPLY, pb.Reply(id=1, code=pb.REPLY_OK).SerializeToString()))
    return [encode_frame(kind, number, 0, payload) for number, (kind, payload) in enumerate(payloads, 1)]


def write_log(path: Path, *, blocks: int = 3, finish: bool = True, metadata: dict[str, Any] | None = None) -> Path:
    """A raw log of so many blocks; without `finish` it ends before the footer, as after a kill."""
    with RawLogWriter(path, METADATA if metadata is None else metadata) as writer:
        request = pb.Request(id=1, get_info=pb.GetInfo())
        writer.write_request(encode_frame(records.FRAME_REQUEST, 1, 0, request.SerializeToString()), 1)
        for frame in FrameDecoder().feed(b"".join(frames(blocks))):
            writer.write(frame, 5_000_000_000)
    if not finish:
        data = path.read_bytes()
        path.write_bytes(data[: data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")])
    return path
