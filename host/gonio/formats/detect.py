"""detect.py: which format a file of points has, by its content."""

from pathlib import Path
from typing import Literal

from gonio.formats import csv_read, nist_csv, pab
from gonio.formats.text_numbers import lines_of
from gonio.units.errors import UsageError

PointFormat = Literal["pab", "nist", "csv"]
_BEGINNING = 65536


def point_format(path: Path) -> PointFormat:
    """The format of a file of points. Raises UsageError where none fits."""
    try:
        with path.open("rb") as file:
            beginning = file.read(_BEGINNING)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read, {error.strerror}: check name and rights") from error
    if not beginning.strip():
        raise UsageError(f"{path}: is empty: name a file with points")
    if pab.looks_like_pab(beginning):
        return "pab"
    if csv_read.looks_like_points(beginning):
        return "csv"
    if set(nist_csv.COLUMNS) <= {cell.strip() for cell in lines_of(beginning)[0].split(",")}:
        return "nist"
    raise UsageError(
        f"{path}: is neither pab text (#incident_angle ...), a NIST BRDF table nor a CSV table with theta_s_deg:"
        " name its --format, or convert it"
    )
