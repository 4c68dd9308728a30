"""writer.py: writes what comes over the link, unprocessed, to an MCAP file that is readable at any time.

Unchunked and uncompressed: a chunk that a killed writer leaves open is lost with all that is in it.
"""

import errno
import os
import time
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any, Self

from mcap.writer import CompressionType, IndexType, Writer

from gonio.protocol.frames import Frame
from gonio.protocol.generated import records
from gonio.rawlog.layout import FRAME_ENCODING, META_TOPIC, PROFILE, TOPICS, pack_metadata, schema_of
from gonio.units.errors import UsageError

SYNC_INTERVAL_S = 1.0  # real time that a power cut may cost
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # disk, quota, or the largest file that is allowed


class RawLogWriter:
    """One segment. The file is made under its final name and must not exist; nothing in it is ever changed."""

    def __init__(self, path: Path, metadata: dict[str, Any]) -> None:
        """Create the file and write `metadata` (plain JSON). Raises UsageError when it exists or cannot be made."""
        try:
            self._file = path.open("xb")
        except FileExistsError as error:
            raise UsageError(f"{path}: exists and is never overwritten: choose another name or --resume") from error
        except OSError as error:
            raise UsageError(f"{path}: cannot be made: {error.strerror}") from error
        self.path = path
        self.frames = 0
        self._count = 0
        self._finished = False
        self._failed = False
        self._synced_at = time.monotonic()
        self._writer = Writer(
            self._file, compression=CompressionType.NONE, index_types=IndexType.NONE, use_chunking=False
        )
        self._channels: dict[int, int] = {}
        try:
            self._begin(metadata)
        except (OSError, UsageError) as error:
            self._file.raw.close()
            path.unlink()  # nothing is in it that --resume could go on from
            raise error if isinstance(error, UsageError) else self._failure(error) from error

    def _begin(self, metadata: dict[str, Any]) -> None:
        """Schemas, channels and metadata; on the disk before the first frame comes."""
        self._writer.start(profile=PROFILE, library="gonio")
        schema = self._writer.register_schema("gonio.metadata", "", b"")
        meta_channel = self._writer.register_channel(META_TOPIC, "json", schema)
        schemas: dict[str, int] = {}
        for kind, topic in TOPICS.items():
            name, encoding, data = schema_of(kind)
            if name not in schemas:
                schemas[name] = self._writer.register_schema(name, encoding, data)
            self._channels[kind] = self._writer.register_channel(topic, FRAME_ENCODING, schemas[name])
        self._add(meta_channel, pack_metadata(metadata), 0)
        self._sync()
        directory = os.open(self.path.resolve().parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)

    def _failure(self, error: OSError) -> UsageError:
        """The rest would not follow on: no more is written. What is there stays readable to its last whole frame."""
        self._failed = True
        remedy = "free space" if error.errno in _NO_ROOM else "check the disk"
        return UsageError(
            f"{self.path}: cannot be written ({error.strerror}), so the scan ends here: {remedy}, then continue with"
            " --resume"
        )

    def _add(self, channel: int, data: bytes, time_ns: int) -> None:
        if self._failed:
            return
        try:
            # The sequence counts the file's messages: the reader sees one that is missing.
            self._writer.add_message(channel, max(time_ns, 0), data, max(time_ns, 0), self._count & 0xFFFFFFFF)
            self._file.flush()
            if time.monotonic() - self._synced_at >= SYNC_INTERVAL_S:
                self._sync()
        except OSError as error:
            raise self._failure(error) from error
        self._count += 1

    def _sync(self) -> None:
        self._file.flush()
        os.fdatasync(self._file.fileno())
        self._synced_at = time.monotonic()

    def write(self, frame: Frame, link_time_ns: int) -> None:
        """Append a firmware frame, whole; kinds without a topic (HELLO) are left out."""
        channel = self._channels.get(frame.kind)
        if channel is not None:
            self._add(channel, frame.raw, link_time_ns)
            self.frames += 1

    def write_request(self, raw: bytes, link_time_ns: int) -> None:
        """Append a REQUEST frame of the host, whole."""
        self._add(self._channels[records.FRAME_REQUEST], raw, link_time_ns)

    def fileno(self) -> int:
        """The file's descriptor."""
        return self._file.fileno()

    def finish(self) -> None:
        """Write the footer and close: the reader then knows that nothing is missing. Safe to call twice.

        Raises UsageError when the footer has no room.
        """
        if self._finished:
            return
        self._finished = True
        try:
            if not self._failed:
                self._writer.finish()
                self._sync()
        except OSError as error:
            raise self._failure(error) from error
        finally:
            # What is still buffered after a failure has nowhere to go.
            (self._file.raw if self._failed else self._file).close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        # What ended the scan is what the user must read.
        with suppress(UsageError) if kind else nullcontext():
            self.finish()
