"""written_whole.py: an HDF5 file that is written beside its place and moved there: a reader never sees half of one."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from gonio.units.errors import UsageError


@contextmanager
def written_whole(path: Path, what: str) -> Iterator[h5py.File]:
    """A new file; it takes its place when the block ends well. UsageError, naming `what`, if the folder takes none."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with h5py.File(beside, "w") as file:
            yield file
        with beside.open("rb") as written:
            os.fsync(written.fileno())
        os.replace(beside, path)
    except OSError as error:
        raise UsageError(f"{path}: cannot write the {what} ({error}): check folder, rights and space") from error
    finally:
        beside.unlink(missing_ok=True)
