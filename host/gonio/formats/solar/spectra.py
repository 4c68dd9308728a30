"""spectra.py: spectra of sunlight as shares of bands of wavelength: one that comes along, others from a table."""

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

ASTM_G173 = "astm-g173"
_MOST_BYTES = 10_000_000


@dataclass(frozen=True)
class Spectrum:
    """Edges (n + 1,) [nm] of bands that follow each other, and `below` (n + 1,): the share of the whole up to each.

    `name`: as <Comments> and reports say it. Within a band the power is spread evenly, or, where `at_edges` (n + 1,)
    [1/nm] is known, goes linearly from one edge to the next.
    """

    name: str
    edges_nm: FloatArray
    below: FloatArray
    at_edges: FloatArray | None = None

    def between(self, from_nm: float, to_nm: float) -> float:
        """Share of a range."""
        return self._up_to(to_nm) - self._up_to(from_nm)

    def _up_to(self, nm: float) -> float:
        if self.at_edges is None:
            return float(np.interp(nm, self.edges_nm, self.below))
        nm = float(np.clip(nm, self.edges_nm[0], self.edges_nm[-1]))
        band = min(int(np.searchsorted(self.edges_nm, nm, side="right")) - 1, len(self.edges_nm) - 2)
        here = float(np.interp(nm, self.edges_nm, self.at_edges))
        return float(self.below[band] + 0.5 * (self.at_edges[band] + here) * (nm - self.edges_nm[band]))


def spectrum_named(name: str) -> Spectrum:
    """astm-g173, or the path of a CSV file. UsageError, one line, for anything else and for a table that does not do.

    A file has columns wavelength_nm, rising, and irradiance (any unit per nm; trapezoidal between the rows), or share
    (of the whole; a wavelength stands for the range that is nearest to it). Lines that begin with # are skipped.
    """
    if name == ASTM_G173:
        return _g173()
    path = Path(name)
    if path.suffix.lower() != ".csv" and not path.is_file():
        raise UsageError(f"no solar spectrum {name!r}: give {ASTM_G173}, or a FILE.csv with wavelength_nm,irradiance")
    return _of_file(path)


@cache
def _g173() -> Spectrum:
    text = (files("gonio.formats") / "data" / "solar_astm_g173.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    edges = np.array([float(rows[0]["from_nm"]), *(float(row["to_nm"]) for row in rows)])
    power = np.array([float(row["irradiance_w_per_m2"]) for row in rows])
    return Spectrum("ASTM G173-03 (global, 37 degrees tilt, air mass 1.5)", edges, _cumulated(power))


def _of_file(path: Path) -> Spectrum:
    wavelength, values, column = _columns(path)
    if len(wavelength) < 2 or not (np.diff(wavelength) > 0.0).all() or not wavelength[0] > 0.0:
        raise UsageError(f"{path}: wavelength_nm must be two values or more, over 0 and rising")
    if not (values >= 0.0).all() or not values.sum() > 0.0:
        raise UsageError(f"{path}: {column} must not be negative, and not zero everywhere")
    name = f"the table {path.name}"
    if column == "share":
        middle = 0.5 * (wavelength[1:] + wavelength[:-1])
        return Spectrum(name, np.concatenate((wavelength[:1], middle, wavelength[-1:])), _cumulated(values))
    power = 0.5 * (values[1:] + values[:-1]) * np.diff(wavelength)
    return Spectrum(name, wavelength, _cumulated(power), values / power.sum())


def _columns(path: Path) -> tuple[FloatArray, FloatArray, str]:
    """Wavelength [nm], values, and which column these are."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise UsageError(f"{path}: is larger than {_MOST_BYTES // 1_000_000} MB: no spectrum")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: the solar spectrum cannot be read: {type(error).__name__}") from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    header = [part.strip() for part in lines[0][1].split(",")] if lines else []
    found = [name for name in ("irradiance", "share") if name in header]
    if "wavelength_nm" not in header or len(found) != 1:
        raise UsageError(f"{path}: the first line must name wavelength_nm, and irradiance or share")
    wanted = [header.index("wavelength_nm"), header.index(found[0])]
    rows = []
    for number, line in lines[1:]:
        try:
            parts = line.split(",")
            rows.append([float(parts[k]) for k in wanted])
        except (ValueError, IndexError):
            raise UsageError(f"{path}, line {number}: {line[:40]!r} has no two numbers") from None
    values = np.array(rows, dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(values).all():
        raise UsageError(f"{path}: holds a value that is no number")
    return values[:, 0], values[:, 1], found[0]


def _cumulated(power: FloatArray) -> FloatArray:
    return np.asarray(np.concatenate(([0.0], np.cumsum(power))) / power.sum())
