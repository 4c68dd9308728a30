"""csv_read.py: reads plain tables of points: our own export, and others' with the same column names."""

import csv
import hashlib
import io
from collections import defaultdict
from itertools import islice
from pathlib import Path
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import MASKED, Dataset, Distribution, PointFlag, Polarisation, Side, Symmetry
from gonio.formats.tables.csv_write import FIELDS
from gonio.formats.text_numbers import fold_deg, lines_of, rounding_variance
from gonio.formats.xml_guard import read_limited
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

MAX_BYTES = 2**30
FORMAT = "points as CSV"
ANGLES = ("theta_i_deg", "phi_i_deg", "theta_s_deg", "phi_s_deg")
SYSTEMATIC = "stated"  # the effect that holds what a table calls systematic
_ROWS_AT_ONCE = 4096
_LIMITS_DEG = (180.0, 720.0, 360.0, 720.0)
_CHOICES: dict[str, tuple[str, ...]] = {
    "front_faces": get_args(Side),
    "polarisation": get_args(Polarisation),
    "symmetry": get_args(Symmetry),
}
_FLAGS = {str(flag.name).lower(): flag for flag in PointFlag if flag}


def looks_like_points(content: bytes) -> bool:
    """Whether the first line that is no comment names the columns of such a table."""
    for line in lines_of(content[:65536]):
        if line.strip() and not line.startswith("#"):
            return {"theta_s_deg", "phi_s_deg"} <= {cell.strip() for cell in line.split(",")}
    return False


def read(path: Path) -> Dataset:
    """One distribution per channel and incident direction, in the file's order.

    Needed: theta_i_deg, phi_i_deg, theta_s_deg, phi_s_deg and dsf_per_sr or bsdf_per_sr (converted with |cos theta_s|;
    DSF goes first where both are there). Optional: channel; u_dsf_per_sr (independent part), u_bsdf_per_sr or u (of
    the value's own quantity), u_combined_per_sr (what it has beyond the independent part becomes the effect
    SYSTEMATIC, one cause for the whole table); solid_angle_sr; count; flags (names joined by |; the value of a masked
    point is empty). A table without uncertainty has the variance of rounding to the last written digit.
    Raises UsageError, one line, for anything that is not such a table.
    """
    content = read_limited(path, MAX_BYTES)
    comments, columns, line_numbers = _columns(content, path.name)
    table = _Table(columns, line_numbers, path.name)
    about = _about(comments, path.name)
    groups: dict[tuple[str, float, float], list[int]] = defaultdict(list)
    for row, key in enumerate(zip(table.channel, *(column.tolist() for column in table.incident), strict=True)):
        groups[key].append(row)
    wavelengths = about.pop("wavelengths")
    distributions = [table.distribution(key, np.array(rows), wavelengths.get(key[0])) for key, rows in groups.items()]
    return Dataset(
        distributions,
        **about,
        provenance={
            "imported": {
                "file": path.name,
                "sha256": hashlib.sha256(content).hexdigest(),
                "format": FORMAT,
                "points": len(line_numbers),
                "quantity": "DSF" if table.is_dsf else "BSDF, converted with |cos theta_s|",
                "uncertainty": table.uncertainty,
            }
        },
    )


def _columns(content: bytes, name: str) -> tuple[list[str], dict[str, list[str]], list[int]]:
    """Comment lines, columns by name as text, and the line of each row."""
    comments: list[str] = []
    lines: list[str] = []
    line_numbers: list[int] = []
    for number, line in enumerate(lines_of(content), start=1):
        if line.startswith("#"):
            comments.append(line[1:].strip())
        elif line.strip():
            lines.append(line)
            line_numbers.append(number)
    reader = csv.reader(io.StringIO("\n".join(lines)), strict=True)
    try:
        header = [cell.strip() for cell in next(reader, [])]
        missing = [column for column in ANGLES if column not in header]
        if missing or not {"dsf_per_sr", "bsdf_per_sr"} & set(header):
            raise UsageError(f"{name}: has no column {', '.join(missing) or 'dsf_per_sr or bsdf_per_sr'}: add it")
        if len(set(header)) != len(header):
            raise UsageError(f"{name}: line {line_numbers[0]} names a column twice")
        columns: list[list[str]] = [[] for _ in header]
        while rows := list(islice(reader, _ROWS_AT_ONCE)):  # many lists alive at once keep Python's collector busy
            first = len(columns[0]) + 1
            for row, number in zip(rows, line_numbers[first : first + len(rows)], strict=True):
                if len(row) != len(header):
                    raise UsageError(
                        f"{name}: line {number} has {len(row)} cells instead of {len(header)}; the file is cut off or"
                        " damaged"
                    )
            for column, cells in zip(columns, zip(*rows, strict=True), strict=True):
                column.extend(cells)
    except csv.Error as error:
        raise UsageError(f"{name}: not readable as a CSV table, {error}") from error
    if len(columns[0]) != len(lines) - 1:
        raise UsageError(f"{name}: quoted cells go over several lines; this is no table of points")
    if len(lines) < 2:
        raise UsageError(f"{name}: the table is empty")
    return comments, dict(zip(header, columns, strict=True)), line_numbers[1:]


class _Table:
    """The columns as arrays, checked; rows in the file's order."""

    def __init__(self, columns: dict[str, list[str]], line_numbers: list[int], name: str) -> None:
        self.columns, self.line_numbers, self.name = columns, line_numbers, name
        rows = len(line_numbers)
        angles = [self._numbers(column) for column in ANGLES]
        for column, values, limit in zip(ANGLES, angles, _LIMITS_DEG, strict=True):
            self._require(np.abs(values) <= limit, f"an impossible {column}")
        self.incident = fold_deg(angles[0], angles[1])
        self.theta_deg, self.phi_deg = fold_deg(angles[2], angles[3])
        self.channel = [cell.strip() or "visible" for cell in columns.get("channel", ["visible"] * rows)]
        self.flags = self._flag_bits()
        self.measured = (self.flags & MASKED) == 0
        self.is_dsf = "dsf_per_sr" in columns
        value_column = "dsf_per_sr" if self.is_dsf else "bsdf_per_sr"
        factor = np.ones(rows) if self.is_dsf else np.abs(np.cos(np.radians(self.theta_deg)))
        value = self._numbers(value_column, empty=np.nan)
        self._require(np.isfinite(value) | ~self.measured, f"no {value_column}")
        self.dsf_per_sr = np.where(self.measured, value * factor, np.nan)
        self.variance_per_sr2, self.systematic_per_sr = self._variance(value_column, factor)
        self.solid_angle_sr = self._optional("solid_angle_sr", 0.0)
        self._require((self.solid_angle_sr >= 0.0) & (self.solid_angle_sr < 13.0), "an impossible solid_angle_sr")
        count = self._optional("count", 1.0)
        self._require((count == np.floor(count)) & (count >= 0) & (count < 2**31), "an impossible count")
        self.count = count.astype(np.int32)

    def distribution(
        self, key: tuple[str, float, float], rows: NDArray[np.intp], wavelength_nm: float | None
    ) -> Distribution:
        systematic = self.systematic_per_sr[rows]
        return Distribution(
            incident_theta_deg=key[1],
            incident_phi_deg=key[2],
            theta_deg=self.theta_deg[rows],
            phi_deg=self.phi_deg[rows],
            dsf_per_sr=self.dsf_per_sr[rows],
            variance_per_sr2=self.variance_per_sr2[rows],
            signal=self.dsf_per_sr[rows],
            normalisation=np.ones(len(rows)),
            count=self.count[rows],
            flags=self.flags[rows],
            solid_angle_sr=self.solid_angle_sr[rows],
            time_ns=np.zeros(len(rows), dtype=np.int64),
            channel=key[0],
            wavelength_nm=wavelength_nm,
            signal_unit="1/sr",
            effects={SYSTEMATIC: systematic} if np.nan_to_num(systematic).any() else {},
        )

    def _variance(self, value_column: str, factor: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Independent variance, and the root of what the combined uncertainty has beyond it."""
        own = next((c for c in (f"u_{value_column}", "u") if c in self.columns), None)
        if own is not None:
            u = self._optional(own, np.nan) * factor
            self._require((u >= 0.0) | ~self.measured, f"no or a negative {own}")
            variance = np.where(self.measured, u**2, np.nan)
            self.uncertainty = f"column {own}, independent"
        else:
            variance = rounding_variance(self.columns[value_column]) * factor**2
            variance = np.where(self.measured, variance, np.nan)
            self.uncertainty = "none stated in the file; variance is that of rounding to the last digit"
        combined_column = "u_combined_per_sr"
        if combined_column not in self.columns:
            return variance, np.zeros_like(variance)
        combined = self._optional(combined_column, np.nan)
        self._require((combined >= 0.0) | ~self.measured, f"no or a negative {combined_column}")
        beyond = combined**2 - variance
        # Twelve digits were written: what is left by rounding alone is nothing.
        beyond = np.where(beyond > 1e-11 * combined**2, beyond, np.where(np.isnan(beyond), np.nan, 0.0))
        self.uncertainty += f"; column {combined_column}, what it has beyond that as one systematic effect"
        return variance, np.sqrt(beyond)

    def _flag_bits(self) -> NDArray[np.uint16]:
        names = self.columns.get("flags")
        if names is None:
            return np.full(len(self.line_numbers), PointFlag.MEASURED, dtype=np.uint16)
        bits: dict[str, int] = {}
        for row, cell in enumerate(names):
            if cell in bits:
                continue
            words = [word.strip().lower() for word in cell.split("|") if word.strip()]
            unknown = [word for word in words if word not in _FLAGS]
            if unknown:
                raise UsageError(f"{self.name}: line {self.line_numbers[row]}: no flag is called {unknown[0][:40]!r}")
            bits[cell] = sum(int(_FLAGS[word]) for word in set(words))
        return np.array([bits[cell] for cell in names], dtype=np.uint16)

    def _optional(self, column: str, otherwise: float) -> FloatArray:
        if column not in self.columns:
            return np.full(len(self.line_numbers), otherwise)
        return self._numbers(column, empty=otherwise)

    def _numbers(self, column: str, *, empty: float | None = None) -> FloatArray:
        cells = self.columns[column]
        if empty is not None:
            cells = [cell if cell.strip() else repr(empty) for cell in cells]
        try:
            values = np.array([float(cell) for cell in cells])
        except ValueError:
            row = next(row for row, cell in enumerate(cells) if not _is_number(cell))
            raise UsageError(
                f"{self.name}: line {self.line_numbers[row]}: {column} {cells[row][:40]!r} is no number"
            ) from None
        allowed = np.isfinite(values) if empty is None else ~np.isinf(values)
        self._require(allowed, f"no finite {column}")
        return values

    def _require(self, good: NDArray[np.bool_], what: str) -> None:
        if not np.all(good):
            row = int(np.argmin(good))
            raise UsageError(f"{self.name}: line {self.line_numbers[row]} holds {what}: correct or remove it")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _about(comments: list[str], name: str) -> dict[str, Any]:
    """Fields of the dataset from comment lines `NAME: value`; where our own writer did not write, there are none."""
    found: dict[str, Any] = {"wavelengths": {}}
    if not comments or comments[0] != "gonio points":
        return found
    for comment in comments[1:]:
        key, _, text = (part.strip() for part in comment.partition(":"))
        if key in FIELDS:
            if key in _CHOICES and text not in _CHOICES[key]:
                raise UsageError(f"{name}: {key} {text[:40]!r} is none of {', '.join(_CHOICES[key])}")
            found[key] = text
        elif key in ("thickness_mm", "wavelength_nm"):
            number, _, channel = text.partition(" ")
            if not _is_number(number) or not 0.0 < float(number) < 1e9:
                raise UsageError(f"{name}: {key} {text[:40]!r} is no length")
            if key == "thickness_mm":
                found["thickness_mm"] = float(number)
            else:
                found["wavelengths"][channel] = float(number)
    return found
