"""detect.py: which format a file of points has, by its content."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from gonio.dataset.bsdf import Dataset
from gonio.formats.pab import dataset as pab_dataset
from gonio.formats.pab import text as pab
from gonio.formats.tables import csv_read
from gonio.formats.tables import nist as nist_csv
from gonio.formats.text_numbers import lines_of
from gonio.units.errors import UsageError

PointFormat = Literal["pab", "nist", "csv"]
_BEGINNING = 65536


def beginning_of(path: Path) -> bytes:
    """The first bytes of a file, UsageError where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(_BEGINNING)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read, {error.strerror}: check name and rights") from error


def looks_like_xml(beginning: bytes) -> bool:
    """Whether a file with these first bytes is XML, perhaps with other lines before it, in any encoding."""
    plain = beginning[:8192].replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xfe\xff \t\r\n")
    return plain.startswith(b"<") or b"<?xml" in plain or b"<WindowElement" in plain


def looks_like_points(beginning: bytes) -> bool:
    """Whether a file with these first bytes holds points in one of the formats."""
    return bool(beginning.strip()) and _point_format(beginning) is not None


def _point_format(beginning: bytes) -> PointFormat | None:
    if pab.looks_like_pab(beginning):
        return "pab"
    if csv_read.looks_like_points(beginning):
        return "csv"
    if set(nist_csv.COLUMNS) <= {cell.strip() for cell in lines_of(beginning)[0].split(",")}:
        return "nist"
    return None


def point_format(path: Path) -> PointFormat:
    """The format of a file of points. Raises UsageError where none fits."""
    beginning = beginning_of(path)
    if not beginning.strip():
        raise UsageError(f"{path}: is empty: name a file with points")
    found = _point_format(beginning)
    if found is not None:
        return found
    raise UsageError(
        f"{path}: is neither pab text (#incident_angle ...), a NIST BRDF table nor a CSV table with theta_s_deg:"
        " name its --format, or convert it"
    )


def read_points(paths: Sequence[Path]) -> Dataset:
    """Points of one or, of pab text, of several files. Raises UsageError where they cannot be read."""
    found = point_format(paths[0])
    if found == "pab":
        return pab_dataset.read(paths)
    return nist_csv.read(paths[0]) if found == "nist" else csv_read.read(paths[0])
