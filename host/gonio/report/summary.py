"""summary.py: summary.json: what was measured, the truth where it is known, and the differences."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.formats import atomic
from gonio.reduce.integrals.hemispheres import zero_forty_five
from gonio.reduce.integrals.truth_beside import KnownTruth
from gonio.report.comparison import difference_entry, known_values, measured_peaks, truth_entry


def build_summary(dataset: Dataset, truth: KnownTruth | None = None) -> dict[str, Any]:
    """A plain object; differences are measured minus truth, relative ones divided by the truth, None where it is 0.

    rho_measured and tau_measured are of the measured directions alone, rho_estimate and tau_estimate of the hemisphere
    with a guess for masked ones; a peak's truth is fitted like the peak.
    """
    return {
        "sample": dataset.sample_name,
        "front_faces": dataset.front_faces,
        "symmetry": dataset.symmetry,
        "polarisation": dataset.polarisation,
        "points": int(sum(len(d.theta_deg) for d in dataset.distributions)),
        "counters": dataset.provenance.get("counters", {}),
        "distributions": [_distribution(d, truth) for d in dataset.distributions],
    }


def write_summary(dataset: Dataset, path: Path, *, truth: KnownTruth | None = None) -> dict[str, Any]:
    """Writes the summary as JSON, whole or not at all, and returns it."""
    summary = build_summary(dataset, truth)
    atomic.write_bytes(path, (json.dumps(_plain(summary), indent=2, allow_nan=False) + "\n").encode())
    return summary


def _distribution(d: Distribution, truth: KnownTruth | None) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "incident_deg": [d.incident_theta_deg, d.incident_phi_deg],
        "channel": d.channel,
        "wavelength_nm": d.wavelength_nm,
        "points": len(d.theta_deg),
        "measured_points": int(np.count_nonzero(d.measured)),
        "p_i": d.p_i,
        "integrals": dict(d.integrals),
        "zero_forty_five": zero_forty_five(d),
        "peaks": measured_peaks(d),
    }
    if truth is not None:
        known = known_values(d, truth)
        entry["truth"] = truth_entry(d, known)
        entry["differences"] = difference_entry(d, known)
    return entry


def _plain(value: Any) -> Any:
    """JSON has no NaN: it becomes null; numpy scalars become Python's."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
