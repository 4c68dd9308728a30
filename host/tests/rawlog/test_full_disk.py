"""test_full_disk.py: a raw log whose disk is full: one line, and all whole frames up to there are readable."""

import errno
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from small_log import METADATA, frames

from gonio.protocol.frames import FrameDecoder
from gonio.rawlog.segment_reader import read_segment
from gonio.rawlog.writer import RawLogWriter
from gonio.units.errors import InstrumentFault, UsageError

FRAMES = FrameDecoder().feed(b"".join(frames(40)))


class SmallDisk(io.FileIO):
    """A file on a disk with so many bytes: as a kernel does, it writes what still fits, then refuses."""

    def __init__(self, path: Path, room: int) -> None:
        super().__init__(path, "xb")
        self.room = room

    def write(self, data: Any) -> int:
        part = memoryview(data)[: self.room]
        if not len(part):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= len(part)
        return super().write(part)


OPEN = Path.open


def opened(room: int, path: Path, *how: Any, **names: Any) -> Any:
    """Path.open; a new file is on a small disk."""
    return io.BufferedWriter(SmallDisk(path, room)) if how == ("xb",) else OPEN(path, *how, **names)


@pytest.fixture
def small_disk(monkeypatch: pytest.MonkeyPatch) -> Any:
    """small_disk(room): files that are made have so much room."""

    def make(room: int) -> None:
        monkeypatch.setattr(Path, "open", lambda path, *how, **names: opened(room, path, *how, **names))

    return make


def size_of_whole_log(folder: Path) -> tuple[int, int]:
    """Bytes before the first frame and after the footer."""
    with RawLogWriter(folder / "whole.mcap", METADATA) as writer:
        begin = (folder / "whole.mcap").stat().st_size
        for frame in FRAMES:
            writer.write(frame, 1)
    return begin, (folder / "whole.mcap").stat().st_size


def test_every_place_where_the_disk_may_be_full(tmp_path: Path, small_disk: Any, recwarn: Any) -> None:
    """Wherever it happens: one sentence; what is there are the first frames of the whole log, cut and not damaged."""
    begin, end = size_of_whole_log(tmp_path)
    path = tmp_path / "raw.mcap"
    for room in range(begin, end, 37):
        small_disk(room)
        written = 0
        with pytest.raises(UsageError, match=r"No space left.*free space, then continue with --resume") as caught:  # noqa: PT012, SIM117
            with RawLogWriter(path, METADATA) as writer:
                for frame in FRAMES:
                    writer.write(frame, 1)
                    written += 1
        assert "\n" not in str(caught.value)
        writer.write(FRAMES[0], 2)  # what comes while the instrument stops
        segment = read_segment(path)
        assert not segment.damaged
        assert not segment.complete
        assert segment.messages == 1 + written
        path.unlink()
    assert not recwarn.list


def test_no_room_for_the_first_bytes_leaves_no_file(tmp_path: Path, small_disk: Any) -> None:
    """Nothing to resume: the name stays free."""
    begin, _ = size_of_whole_log(tmp_path)
    for room in (0, 100, begin // 2, begin - 1):
        small_disk(room)
        with pytest.raises(UsageError, match="No space left"):
            RawLogWriter(tmp_path / "raw.mcap", METADATA)
        assert not (tmp_path / "raw.mcap").exists()


def test_what_ended_the_scan_is_not_hidden_by_the_footer(tmp_path: Path, small_disk: Any) -> None:
    begin, _ = size_of_whole_log(tmp_path)
    small_disk(begin + 5)
    with pytest.raises(InstrumentFault, match="node 3"), RawLogWriter(tmp_path / "raw.mcap", METADATA):
        raise InstrumentFault("node 3: heartbeat stopped")


def test_a_real_full_device(tmp_path: Path) -> None:
    """The kernel's own refusal (/dev/full), in a process whose end is quiet."""
    script = f"""
import os, sys
sys.path[:0] = {sys.path!r}
from pathlib import Path
from small_log import METADATA, frames
from gonio.protocol.frames import FrameDecoder
from gonio.rawlog.writer import RawLogWriter
from gonio.units.errors import UsageError
with RawLogWriter(Path({str(tmp_path / "raw.mcap")!r}), METADATA) as writer:
    with Path("/dev/full").open("wb") as full:
        os.dup2(full.fileno(), writer.fileno())
    try:
        writer.write(FrameDecoder().feed(frames(1)[0])[0], 1)
    except UsageError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "No space left" in done.stdout
    assert read_segment(tmp_path / "raw.mcap").metadata["sample"] == METADATA["sample"]
