"""validate.py: checks a WINDOW XML file: schema, fields, units, bands, matrices, energy, negative values."""

import importlib.resources
import itertools
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
import xmlschema

from gonio.formats.findings import Findings
from gonio.formats.klems import BASES
from gonio.formats.klems_matrices import BANDS, PROCESSES, SIDES
from gonio.formats.window_reader import WindowBsdf, read

Profile = Literal["window", "radiance"]
ENERGY_TOLERANCE = 1e-4  # files carry about six digits
_MOST_SCHEMA_ERRORS = 20
_NEEDED_NUMBERS = ("ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR")


def validate(path: Path, profile: Profile = "window") -> Findings:
    """Findings about a file for one reader: WINDOW (schema, all fields and matrices) or Radiance (what it loads).

    Raises UsageError when the file cannot be read at all: foreign, cut off, too large.
    """
    content = read(path)
    findings = content.findings
    _schema(content, findings, profile)
    _matrices(content, findings, profile)
    _values(content, findings)
    if profile == "window":
        _fields(content, findings)
    return findings


@cache
def _window_schema() -> xmlschema.XMLSchema:
    source = importlib.resources.files("gonio.formats") / "data" / "BSDF-v1.7.7.xsd"
    return xmlschema.XMLSchema(source.read_text(encoding="utf-8"))


def _schema(content: WindowBsdf, findings: Findings, profile: Profile) -> None:
    severity: Literal["error", "note"] = "error" if profile == "window" else "note"
    errors = _window_schema().iter_errors(content.root)
    for error in itertools.islice(errors, _MOST_SCHEMA_ERRORS):
        where = (error.path or "").rpartition("/")[2] or "document"
        findings.add(severity, "schema", where, " ".join((error.reason or "not valid").split())[:200])


def _fields(content: WindowBsdf, findings: Findings) -> None:
    for name in ("Name", "Manufacturer"):
        if name not in content.text:
            findings.add("error", "field", name, "is missing or empty; WINDOW's engine needs it")
    if content.thickness_mm is None:
        findings.add("error", "field", "Thickness", "is missing; WINDOW's engine needs it")
    for name in _NEEDED_NUMBERS:
        value = content.numbers.get(name)
        if value is None:
            findings.add("error", "field", name, "is missing; WINDOW's engine needs it")
        elif name != "ThermalConductivity" and not 0 <= value <= 1:
            findings.add("error", "field", name, f"is {value:g}, not between 0 and 1")
    if content.basis.rings != BASES["klems-full"].rings:
        findings.add("warning", "basis", content.basis.name[:40], "WINDOW's engine takes Klems full only")


def _matrices(content: WindowBsdf, findings: Findings, profile: Profile) -> None:
    severity: Literal["error", "note"] = "error" if profile == "window" else "note"
    for band in BANDS:
        for process in PROCESSES:
            for side in SIDES:
                matrix = content.matrices.get((band, process, side))
                where = f"{band} {process} {side}"
                if matrix is None:
                    findings.add(severity, "missing", where, "there is no such matrix")
                elif not matrix.any():
                    findings.add("note", "zeros", where, "all values are zero: not measured?")


def _values(content: WindowBsdf, findings: Findings) -> None:
    size = content.basis.projected_solid_angle_sr
    for (band, process, side), matrix in content.matrices.items():
        if np.any(matrix < 0):
            row, column = np.unravel_index(int(np.argmin(matrix)), matrix.shape)
            findings.add(
                "error",
                "negative",
                f"{band} {process} {side}",
                f"{np.count_nonzero(matrix < 0)} negative values, the lowest {matrix.min():g} "
                f"in row {row + 1}, column {column + 1}",
            )
    for band in BANDS:
        for side in SIDES:
            parts = [content.matrices[k] for process in PROCESSES if (k := (band, process, side)) in content.matrices]
            if not parts:
                continue
            total = size @ np.sum(parts, axis=0)
            if total.max() > 1 + ENERGY_TOLERANCE:
                worst = int(np.argmax(total))
                count = np.count_nonzero(total > 1 + ENERGY_TOLERANCE)
                findings.add(
                    "error",
                    "energy",
                    f"{band} {side}",
                    f"transmission plus reflection exceed 1 in {count} columns, "
                    f"the most {total[worst]:.4f} in column {worst + 1}",
                )
