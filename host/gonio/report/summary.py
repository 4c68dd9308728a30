"""summary.py: summary.json: what was measured, the truth where it is known, and the differences."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.formats import atomic
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.report.covered import covered_reflectance, zero_forty_five
from gonio.report.truth import DsfTruth, expected_peaks, measured_peaks

HEMISPHERICAL = ("rho", "tau")


def build_summary(dataset: Dataset, truth: DsfTruth | None = None) -> dict[str, Any]:
    """A plain object; differences are measured minus truth, relative ones divided by the truth, None where it is 0."""
    return {
        "sample": dataset.sample_name,
        "front_faces": dataset.front_faces,
        "symmetry": dataset.symmetry,
        "polarisation": dataset.polarisation,
        "points": int(sum(len(d.theta_deg) for d in dataset.distributions)),
        "counters": dataset.provenance.get("counters", {}),
        "distributions": [_distribution(d, truth) for d in dataset.distributions],
    }


def write_summary(dataset: Dataset, path: Path, *, truth: DsfTruth | None = None) -> dict[str, Any]:
    """Writes the summary as JSON, whole or not at all, and returns it."""
    summary = build_summary(dataset, truth)
    atomic.write_bytes(path, (json.dumps(_plain(summary), indent=2, allow_nan=False) + "\n").encode())
    return summary


def _distribution(d: Distribution, truth: DsfTruth | None) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "incident_deg": [d.incident_theta_deg, d.incident_phi_deg],
        "channel": d.channel,
        "wavelength_nm": d.wavelength_nm,
        "points": len(d.theta_deg),
        "measured_points": int(np.count_nonzero(d.measured)),
        "p_i": d.p_i,
        "integrals": dict(d.integrals),
        "zero_forty_five": zero_forty_five(d),
        "covered_reflectance": vars(covered_reflectance(d)),
        "peaks": measured_peaks(d),
    }
    if truth is None:
        return entry
    known = truth.integrals(d.incident_theta_deg, d.incident_phi_deg)
    peaks = expected_peaks(truth, d.incident_theta_deg, d.incident_phi_deg)
    entry["truth"] = {
        "integrals": known,
        "peaks": {name: dict(vars(peak)) for name, peak in peaks.items()},
    }
    entry["differences"] = {
        "integrals": {
            name: _difference(d.integrals[name], known[name])
            for name in HEMISPHERICAL
            if name in d.integrals and name in known
        },
        "peaks": {
            name: {
                "direction_deg": float(
                    angle_between_deg(
                        unit_from_angles_deg(found["theta_deg"], found["phi_deg"]),
                        unit_from_angles_deg(peaks[name].theta_deg, peaks[name].phi_deg),
                    )
                ),
                "sigma": _difference(found["sigma_deg"], peaks[name].sigma_deg),
                "integral": _difference(found["integral"], peaks[name].integral),
            }
            for name, found in entry["peaks"].items()
            if name in peaks
        },
    }
    return entry


def _difference(measured: float, known: float) -> dict[str, float | None]:
    return {"absolute": measured - known, "relative": (measured - known) / known if known else None}


def _plain(value: Any) -> Any:
    """JSON has no NaN: it becomes null; numpy scalars become Python's."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
