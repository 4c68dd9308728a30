"""asked_table.py: a table of pairs of directions, answered row by row: BSDF, origin, or the reason for having none."""

import csv
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray, Origin
from gonio.formats import atomic
from gonio.formats.asking import REASONS, Answers
from gonio.formats.text_numbers import shortest
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

ANGLES = ("theta_i_deg", "phi_i_deg", "theta_s_deg", "phi_s_deg")
ADDED = ("bsdf", "origin", "reason")
ROWS_AT_ONCE = 200_000
_LIMITS_DEG = (180.0, 720.0, 360.0, 720.0)  # as in tables of points: theta may be signed
_ORIGIN_NAMES = np.array([origin.name.lower() for origin in Origin], dtype=object)
_REASON_TEXTS = np.array(list(REASONS.values()), dtype=object)
_MOST_LENGTH = 65536  # of a line

Ask = Callable[[FloatArray, FloatArray, IndexArray], Answers]


@dataclass
class Counts:
    """What became of the rows."""

    rows: int = 0
    without_value: int = 0
    extrapolated: int = 0
    reasons: dict[str, int] = field(default_factory=dict)


def answer(source: Path, target: Path, ask: Ask) -> Counts:
    """Writes the table `source` with the columns ADDED to `target`, whole or not at all.

    Needed columns: ANGLES, by name, in any order; all others pass through as they are, comment lines (#) and empty ones
    too. A row that cannot be answered gets a reason and no value. `ask` gets incident (k, 3), outgoing (m, 3), which
    (m,), with m at most ROWS_AT_ONCE. Raises UsageError where the file cannot be read, lacks a column or has one of
    ADDED already.
    """
    counts = Counts()
    try:
        file = source.open(encoding="utf-8-sig", errors="surrogateescape")
    except OSError as error:
        raise UsageError(f"{source}: cannot be read, {error.strerror}: check name and rights") from error
    with file, atomic.growing(target) as out:
        lines = iter(line.rstrip("\n") for line in file)
        before, header = _header(lines, source.name)
        columns = _columns(header, source.name)
        put = [*before, ",".join([header, *ADDED])]
        while True:
            out.write(("\n".join(put) + "\n").encode("utf-8", errors="surrogateescape"))
            rows = list(islice(lines, ROWS_AT_ONCE))
            if not rows:
                return counts
            put = _answered(rows, columns, len(_cells(header)), ask, counts)


def _header(lines: Iterator[str], name: str) -> tuple[list[str], str]:
    before: list[str] = []
    for line in lines:
        if len(line) > _MOST_LENGTH:
            break
        if line.strip() and not line.startswith("#"):
            return before, line
        before.append(line)
    raise UsageError(f"{name}: has no header: it needs the columns {', '.join(ANGLES)}")


def _columns(header: str, name: str) -> list[int]:
    names = [cell.strip() for cell in _cells(header)]
    missing = [column for column in ANGLES if column not in names]
    if missing:
        raise UsageError(f"{name}: has no column {', '.join(missing)}: add it")
    there = [column for column in ADDED if column in names]
    if there:
        raise UsageError(f"{name}: has a column {there[0]} already: rename it")
    return [names.index(column) for column in ANGLES]


def _cells(line: str) -> list[str]:
    if '"' not in line:
        return line.split(",")
    return next(csv.reader([line]), [])


def _answered(lines: list[str], columns: list[int], width: int, ask: Ask, counts: Counts) -> list[str]:
    """The lines with what was found behind them; empty lines and comments as they are."""
    texts: list[list[str]] = []
    places: list[int] = []
    result = list(lines)
    for place, line in enumerate(lines):
        if not line.strip() or line.startswith("#"):
            continue
        cells = _cells(line) if len(line) <= _MOST_LENGTH else []
        counts.rows += 1
        if len(cells) != width:
            kept = [*cells[:width], *[""] * (width - len(cells))]
            reason = f"{len(cells)} cells instead of {width}" if cells else "the line is too long"
            result[place] = ",".join([*(_quoted(cell) for cell in kept), "", "", reason])
            _count(counts, f"not {width} cells" if cells else reason)
            continue
        texts.append([cells[column] for column in columns])
        places.append(place)
    if places:
        for place, ending in zip(places, _endings(texts, ask, counts), strict=True):
            result[place] = lines[place] + ending
    return result


def _endings(texts: list[list[str]], ask: Ask, counts: Counts) -> list[str]:
    """What is put behind each row."""
    angles = np.array([_numbers(column) for column in zip(*texts, strict=True)])
    bad = ~np.isfinite(angles)
    impossible = ~bad & (np.abs(angles) > np.array(_LIMITS_DEG)[:, None])
    good = ~(bad | impossible).any(axis=0)
    value = np.full(len(good), "", dtype=object)
    origin = np.full(len(good), "", dtype=object)
    reason = np.full(len(good), "", dtype=object)
    for row, column in reversed(list(enumerate(ANGLES))):  # the first column's reason stays
        reason[impossible[row]] = f"{column} is no possible angle"
        reason[bad[row]] = f"{column} is no number"
    if good.any():
        theta_i, phi_i, theta_s, phi_s = angles[:, good]
        pairs, which = np.unique(theta_i + 1j * phi_i, return_inverse=True)
        found = ask(unit_from_angles_deg(pairs.real, pairs.imag), unit_from_angles_deg(theta_s, phi_s), which)
        texts_of = np.array(shortest(found.bsdf_per_sr), dtype=object)
        texts_of[np.isnan(found.bsdf_per_sr)] = ""
        value[good], origin[good] = texts_of, _ORIGIN_NAMES[found.origin]
        reason[good] = _REASON_TEXTS[found.reason]
        counts.extrapolated += int(np.sum(found.origin == Origin.EXTRAPOLATED))
    kinds, numbers = np.unique(reason.astype(str), return_counts=True)
    for text, number in zip(kinds.tolist(), numbers.tolist(), strict=True):
        if text:
            _count(counts, text, number)
    return [f",{v},{o},{r}" for v, o, r in zip(value, origin, reason, strict=True)]


def _count(counts: Counts, reason: str, number: int = 1) -> None:
    counts.without_value += number
    counts.reasons[reason] = counts.reasons.get(reason, 0) + number


def _numbers(cells: tuple[str, ...]) -> FloatArray:
    """NaN where a cell is no number."""
    try:
        return np.array(cells, dtype=object).astype(np.float64)
    except ValueError:
        return np.array([_number(cell) for cell in cells])


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def _quoted(cell: str) -> str:
    return '"' + cell.replace('"', '""') + '"' if any(c in cell for c in ',"') else cell
