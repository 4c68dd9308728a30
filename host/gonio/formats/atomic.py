"""atomic.py: write a file beside its place and move it there, so that a reader never sees half of it."""

import os
from pathlib import Path

from gonio.units.errors import UsageError


def write_bytes(path: Path, content: bytes) -> None:
    """Writes `content` to `path`; the old file stays until the new one is complete. UsageError when that fails."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UsageError(f"cannot write {path}: {error.strerror}; choose another folder") from error
