"""layout.py: what writer and reader agree on: topics, schemas, and the guarded metadata document."""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import google_crc32c

from gonio.protocol.generated import records
from gonio.protocol.messages import event_schema

PROFILE = "gonio"
META_TOPIC = "/meta"
FRAME_ENCODING = "gonio-link-frame"  # whole frames: the header's CRC guards each message
TOPICS = {
    records.FRAME_SAMPLES: "/samples",
    records.FRAME_POSES: "/poses",
    records.FRAME_EVENT: "/events",
    records.FRAME_REPLY: "/replies",
    records.FRAME_REQUEST: "/requests",  # the only one from the host
}
_PROTOBUF = {
    records.FRAME_EVENT: "gonio.Event",
    records.FRAME_REPLY: "gonio.Reply",
    records.FRAME_REQUEST: "gonio.Request",
}
_PACKED = {records.FRAME_SAMPLES: "sample_block", records.FRAME_POSES: "pose_block"}


def schema_of(kind: int) -> tuple[str, str, bytes]:
    """Name, encoding and data of the MCAP schema for a frame kind's payload."""
    if kind in _PROTOBUF:
        return _PROTOBUF[kind], "protobuf", event_schema()
    return _PACKED[kind], "gonio-records", records_text()


def records_text() -> bytes:
    """The text of records.toml, which explains the packed payloads: packaged, else from the source tree."""
    packaged = files("gonio.protocol").joinpath("records.toml")
    if packaged.is_file():
        return packaged.read_bytes()
    return (Path(__file__).resolve().parents[3] / "protocol" / "records.toml").read_bytes()


def _canonical(metadata: dict[str, Any]) -> bytes:
    return json.dumps(metadata, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def pack_metadata(metadata: dict[str, Any]) -> bytes:
    """The /meta message: JSON with a CRC-32C over the canonical form of its content."""
    content = _canonical(metadata)
    return b'{"crc32c":"%08x","metadata":%s}' % (google_crc32c.value(content), content)


def unpack_metadata(data: bytes) -> dict[str, Any] | None:
    """The content of a /meta message, or None when it is damaged."""
    try:
        document = json.loads(data)
        metadata, crc = document["metadata"], document["crc32c"]
        good = isinstance(metadata, dict) and crc == f"{google_crc32c.value(_canonical(metadata)):08x}"
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return metadata if good else None
