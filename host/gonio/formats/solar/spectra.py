"""spectra.py: standard solar spectra as shares of bands of wavelength (data/README.md says where they come from)."""

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

_TABLES = {"astm-g173": "solar_astm_g173.csv", "iso-9050": "solar_iso_9050.csv"}
SPECTRA = tuple(_TABLES)
NAMES = {
    "astm-g173": "ASTM G173-03 (global, 37 degrees tilt, air mass 1.5)",
    "iso-9050": "ISO 9050 (global, air mass 1.5)",
}


@dataclass(frozen=True)
class Spectrum:
    """Bands that follow each other: edges (n + 1,) [nm], share (n,) of the whole, sum 1."""

    name: str
    edges_nm: FloatArray
    share: FloatArray

    def between(self, from_nm: float, to_nm: float) -> float:
        """Share of a range; within a band it is spread evenly."""
        below = np.interp([from_nm, to_nm], self.edges_nm, np.concatenate(([0.0], np.cumsum(self.share))))
        return float(below[1] - below[0])


@cache
def spectrum_named(name: str) -> Spectrum:
    """By the name that the command line uses; UsageError names the choices."""
    if name not in _TABLES:
        raise UsageError(f"no solar spectrum {name!r}: choose one of {', '.join(SPECTRA)}")
    text = (files("gonio.formats") / "data" / _TABLES[name]).read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    if name == "astm-g173":
        edges = np.array([float(rows[0]["from_nm"]), *(float(row["to_nm"]) for row in rows)])
        power = np.array([float(row["irradiance_w_per_m2"]) for row in rows])
    else:
        # The standard's weights belong to wavelengths, each to the range that is nearest to it.
        wavelength = np.array([float(row["wavelength_nm"]) for row in rows])
        edges = np.concatenate((wavelength[:1], 0.5 * (wavelength[1:] + wavelength[:-1]), wavelength[-1:]))
        power = np.array([float(row["share"]) for row in rows])
    return Spectrum(name, edges, power / power.sum())
