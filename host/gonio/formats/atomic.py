"""atomic.py: write files beside their places and move them there: a reader never sees half of one or of a set."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from gonio.units.errors import UsageError


def write_bytes(path: Path, content: bytes) -> None:
    """Writes `content` to `path`; the old file stays until the new one is complete. UsageError when that fails."""
    write_set({path: content})


def write_set(files: Mapping[Path, bytes]) -> None:
    """Writes all files or none: each is complete beside its place before the first is moved; should a move fail, those
    that were new are taken away again. UsageError when that fails."""
    parts = {path: path.with_name(f".{path.name}.{os.getpid()}.part") for path in files}
    moved: list[Path] = []
    path = next(iter(files), Path())
    try:
        for path, content in files.items():
            parts[path].write_bytes(content)
        for path, part in parts.items():
            new = not path.exists()
            os.replace(part, path)
            if new:
                moved.append(path)
    except OSError as error:
        for done in moved:
            done.unlink(missing_ok=True)
        raise UsageError(f"{path}: cannot be written, {error.strerror}: choose another place") from error
    finally:
        for part in parts.values():
            with suppress(OSError):  # gone already when all went well
                part.unlink()


@contextmanager
def growing(path: Path) -> Iterator[BinaryIO]:
    """A file to write piece by piece; it takes its place when the block ends well. UsageError when that fails."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            yield file
        os.replace(part, path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written, {error.strerror}: choose another place") from error
    finally:
        with suppress(OSError):  # gone already when all went well
            part.unlink()
