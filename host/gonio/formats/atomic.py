"""atomic.py: write a file beside its place and move it there, so that a reader never sees half of it."""

import os
from contextlib import suppress
from pathlib import Path

from gonio.units.errors import UsageError


def write_bytes(path: Path, content: bytes) -> None:
    """Writes `content` to `path`; the old file stays until the new one is complete. UsageError when that fails."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written, {error.strerror}: choose another place") from error
    finally:
        with suppress(OSError):  # gone already when all went well
            part.unlink()
