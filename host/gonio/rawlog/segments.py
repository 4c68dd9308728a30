"""segments.py: the names of a raw log's segments: RAW.mcap, then RAW.2.mcap, RAW.3.mcap, each resume one more."""

from pathlib import Path

from gonio.units.errors import UsageError

SUFFIX = ".mcap"


def segment_path(first: Path, number: int) -> Path:
    """The file of segment `number` (from 1) of the log whose first file is `first`. Raises UsageError on its name."""
    if first.suffix != SUFFIX:
        raise UsageError(f"{first}: a raw log's name ends in {SUFFIX}")
    return first if number == 1 else first.with_name(f"{first.stem}.{number}{SUFFIX}")


def existing_segments(first: Path) -> list[Path]:
    """The segments of a log that are there, in order; stops at the first that is missing."""
    paths: list[Path] = []
    while (path := segment_path(first, len(paths) + 1)).exists():
        paths.append(path)
    return paths
