"""places.py: files named on the command line are looked at before any work: inputs there, outputs possible."""

import os
from collections.abc import Sequence
from pathlib import Path

from gonio.units.errors import UsageError


def check_inputs(*paths: Path | None) -> None:
    """UsageError for a path that is missing, a directory or not readable; None is passed over."""
    for path in paths:
        if path is None:
            continue
        if not path.exists():
            raise UsageError(f"{path}: no such file: check the name")
        if path.is_dir():
            raise UsageError(f"{path}: is a directory: name a file")
        if not os.access(path, os.R_OK):
            raise UsageError(f"{path}: you may not read it: check its rights")


def check_outputs(*paths: Path | None, inputs: Sequence[Path | None] = ()) -> None:
    """UsageError for an output that cannot be written, is named twice or is one of the inputs; None is passed over."""
    named: list[Path] = [path.resolve() for path in inputs if path is not None]
    for path in paths:
        if path is None:
            continue
        folder = path.parent
        if path.is_dir():
            raise UsageError(f"{path}: is a directory: name a file to write")
        if not folder.is_dir():
            raise UsageError(f"{path}: there is no folder {folder}: make it or choose another")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise UsageError(f"{path}: the folder {folder} is not writable: choose another")
        if path.resolve() in named:
            raise UsageError(f"{path}: is named twice, and would be overwritten: choose another name for the output")
        named.append(path.resolve())
