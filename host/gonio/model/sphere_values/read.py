"""read.py: reads a table of integrating-sphere values."""

import csv
import io
from collections import defaultdict
from pathlib import Path
from typing import get_args

import numpy as np

from gonio.model.sphere_values.table import (
    QUANTITIES,
    Quantity,
    SideOfLight,
    SphereSpectrum,
    SphereValues,
    sorted_spectra,
)
from gonio.units.errors import UsageError

MAX_BYTES = 64 * 2**20
_LARGEST = 1.2  # a reflectance or transmittance above this is a percentage or a mistake
_KNOWN = ("wavelength_nm", "theta_i_deg", "layers", "side", "u", *QUANTITIES)


def read_sphere(path: Path) -> SphereValues:
    """A CSV file with the columns wavelength_nm and at least one of tau_total, tau_diffuse, rho_total, rho_diffuse
    (as shares, not percent); optional theta_i_deg (0), layers (1), side (front), u (standard uncertainty of the line's
    values). Lines that begin with # are comments; an empty cell was not measured.

    Raises UsageError, one line with the line's number, for anything that is not such a table.
    """
    name = path.name
    rows = _rows(path)
    if not rows:
        raise UsageError(f"{path}: the table is empty: it needs a line with the names of its columns")
    header = [cell.strip() for cell in rows[0][1]]
    odd = [column for column in header if column not in _KNOWN]
    if odd or len(set(header)) < len(header):
        raise UsageError(f"{name}: column {(odd or ['named twice'])[0]!r} is not known; known are {', '.join(_KNOWN)}")
    present: list[Quantity] = [quantity for quantity in QUANTITIES if quantity in header]
    if "wavelength_nm" not in header or not present:
        raise UsageError(f"{name}: needs the column wavelength_nm and one of {', '.join(QUANTITIES)}")
    groups: dict[tuple[float, int, SideOfLight], dict[float, dict[str, float]]] = defaultdict(dict)
    for line, cells in rows[1:]:
        if len(cells) != len(header):
            raise UsageError(f"{name}: line {line} has {len(cells)} cells, the heading has {len(header)}")
        named = {column: cell.strip() for column, cell in zip(header, cells, strict=True)}
        key, values = _checked(named, name, line, present)
        wavelength = values["wavelength_nm"]
        if wavelength in groups[key]:
            raise UsageError(f"{name}: line {line} repeats {wavelength:g} nm of {key[0]:g} degrees, {key[1]} layers")
        groups[key][wavelength] = values
    if not groups:
        raise UsageError(f"{name}: the table has a heading and no values")
    spectra = []
    for (theta, layers, side), lines in groups.items():
        order = sorted(lines)
        columns = {q: np.array([lines[nm].get(q, np.nan) for nm in order]) for q in QUANTITIES}
        u = np.array([lines[nm].get("u", np.nan) for nm in order])
        spectra.append(SphereSpectrum(theta, layers, side, np.array(order), columns, u))
    return SphereValues(sorted_spectra(spectra), name)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line numbers and cells, without comments and empty lines."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read, {error.strerror}: check name and rights") from error
    if len(content) > MAX_BYTES:
        raise UsageError(f"{path}: larger than {MAX_BYTES // 2**20} MiB and not read: is it the right file?")
    try:
        found = list(enumerate(csv.reader(io.StringIO(content.decode("utf-8-sig"))), start=1))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path.name}: not readable as a CSV table, {error}") from error
    return [(line, cells) for line, cells in found if any(map(str.strip, cells)) and not cells[0].startswith("#")]


def _checked(
    named: dict[str, str], name: str, line: int, present: list[Quantity]
) -> tuple[tuple[float, int, SideOfLight], dict[str, float]]:
    values = {}
    for column, cell in named.items():
        if column == "side" or not cell:
            continue
        try:
            values[column] = float(cell)
        except ValueError as error:
            raise UsageError(f"{name}: line {line}: {column} {cell!r} is no number") from error
    side = named.get("side", "") or "front"
    if side not in get_args(SideOfLight):
        raise UsageError(f"{name}: line {line}: side {side!r} is neither front nor back")
    theta, layers = values.get("theta_i_deg", 0.0), values.get("layers", 1.0)
    if not 0.0 < values.get("wavelength_nm", np.nan) < 1e6:
        raise UsageError(f"{name}: line {line}: wavelength_nm is missing or impossible")
    if not 0.0 <= theta < 90.0:
        raise UsageError(f"{name}: line {line}: theta_i_deg {theta:g} is not from 0 to below 90")
    if layers not in (1.0, 2.0, 3.0):
        raise UsageError(f"{name}: line {line}: layers {layers:g} is not 1, 2 or 3")
    if not values.get("u", 0.0) >= 0.0 or not np.isfinite(values.get("u", 0.0)):
        raise UsageError(f"{name}: line {line}: u is not a number of 0 or more")
    for quantity in present:
        value = values.get(quantity, 0.0)
        if not -0.01 <= value <= _LARGEST:
            raise UsageError(f"{name}: line {line}: {quantity} {value:g} is no share of 0 to 1; percent? divide by 100")
    return (theta, int(layers), "front" if side == "front" else "back"), values
