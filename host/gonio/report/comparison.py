"""comparison.py: a distribution's integrals and peaks in tables, and beside those of a known truth."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.reduce.integrals.truth_beside import KnownTruth, beside

_PEAK_KEY = re.compile(r"peak (?P<name>.+) (?P<field>\w+)")
_ABOUT = re.compile(r"(mirror|retro|through) \S+/\S+")
HEMISPHERES = ("rho", "tau")
_PEAK_FIELDS = ("theta_deg", "phi_deg", "height_per_sr", "sigma_deg", "integral", "ground_per_sr")


def known_values(d: Distribution, truth: KnownTruth | None) -> dict[str, float]:
    """What `gonio.reduce.truth_beside.beside` says, nothing without a truth."""
    return {} if truth is None else beside(d, truth)


def word_for(d: Distribution) -> str:
    """How its values came about: "simulated" or "measured"."""
    return "simulated" if np.any(d.flags & PointFlag.SIMULATED) else "measured"


def measured_peaks(d: Distribution) -> dict[str, dict[str, float]]:
    """Peaks of a distribution by name, from its integrals "peak NAME field"."""
    peaks: dict[str, dict[str, float]] = {}
    for key, value in d.integrals.items():
        match = _PEAK_KEY.fullmatch(key)
        if match:
            peaks.setdefault(match["name"], {})[match["field"]] = value
    return peaks


def short_name(peak: str) -> str:
    """Name of a peak without the incident direction: "mirror 30/0" is "mirror"."""
    match = _ABOUT.fullmatch(peak)
    return match[1] if match else peak


def relative(measured: float | None, known: float | None) -> float | None:
    """(measured - known) / known; None where one is missing or the known value is 0."""
    if measured is None or known is None or known == 0.0 or not np.isfinite(measured - known):
        return None
    return (measured - known) / known


def truth_entry(d: Distribution, known: Mapping[str, float]) -> dict[str, Any]:
    """The truth for summary.json: hemispheres over the whole and over the measured directions, peaks by name."""
    integrals = {}
    for name in HEMISPHERES:
        if f"{name}_truth" in known:
            integrals[f"{name}_estimate"] = known[f"{name}_truth"]
            integrals[f"{name}_measured"] = known[f"{name}_truth_measured"]
    peaks = {
        name: {field: known[f"peak {name} {field}_truth"] for field in _PEAK_FIELDS}
        for name in measured_peaks(d)
        if f"peak {name} sigma_deg_truth" in known
    }
    return {"integrals": integrals, "peaks": peaks}


def difference_entry(d: Distribution, known: Mapping[str, float]) -> dict[str, Any]:
    """Measured minus truth for summary.json, in the order and by the names of `truth_entry`."""
    integrals = {}
    for name in HEMISPHERES:
        pairs = (f"{name}_measured", f"{name}_truth_measured"), (f"{name}_estimate", f"{name}_truth")
        for value, reference in pairs:
            if value in d.integrals and reference in known:
                integrals[value] = _difference(d.integrals[value], known[reference])
    peaks = {
        name: {
            "direction_deg": known[f"peak {name} direction_error_deg"],
            "sigma": _difference(found["sigma_deg"], known[f"peak {name} sigma_deg_truth"]),
            "integral": _difference(found["integral"], known[f"peak {name} integral_truth"]),
        }
        for name, found in measured_peaks(d).items()
        if f"peak {name} sigma_deg_truth" in known
    }
    return {"integrals": integrals, "peaks": peaks}


def _difference(measured: float, known: float) -> dict[str, float | None]:
    return {"absolute": measured - known, "relative": relative(measured, known)}
