"""as_json.py: a comparison as one JSON object: metrics and integrals, without the points.

Names are stable; a figure that is undefined is null, so NaN and infinity never appear. A is the reference.

    {"a", "b", "b_kind": "dataset" | "scenario" | "matrices" | "tree" | "model" | "simulation", "reference": "a",
     "settings": {"incident_tolerance_deg", "floor_per_sr", "cone_deg"},
     "global_accordance_percent": {"lowest", "mean"},           over the distributions, whole
     "distributions": [{
       "channel", "incident_deg": [theta, phi], "b_channel", "b_incident_deg": [theta, phi],
       "route": "same points" | "evaluated" | "interpolated", "shared_effects": [NAME],
       "interpolation_per_sr": {"rms", "largest"} | null,       estimated error of interpolated values of B
       "metrics": {"whole" | "reflection" | "transmission": {
         "points", "solid_angle_sr", "left_out": {"masked_a", "masked_b", "outside_b"},
         "global_accordance_percent": METRIC, "global_accordance_by_uncertainty_percent", "accordance_class",
         "local_accordance_percent": METRIC, "local_accordance_beyond_uncertainty_percent",
         "local_accordance_undefined", "local_accordance_both_zero",
         "bias_per_sr": METRIC, "bias_percent": METRIC, "rmse_per_sr": METRIC, "cv": METRIC,
         "within_percent": [SHARE], "floor_per_sr", "under_floor", "under_floor_sr",
         "within_u": [SHARE], "without_uncertainty",
         "chi_square_per_point", "chi_square_with_correlations_per_point"}},
       "integrals": [{"name", "a", "b", "u_a", "u_b", "delta_percent", "signed_percent", "u_percent", "in_u"}],
       "scatter_plane": {"reflection" | "transmission": {
         "points", "left_out", "cv_rmsd": METRIC, "within_percent": [SHARE], "under_floor"}}}],
     "unmatched_a": [TEXT], "unmatched_b": [TEXT], "remarks": [TEXT]}

METRIC is {"value", "u", "by_solid_angle", "u_by_solid_angle", "from_uncertainty", "in_u"}, SHARE {"limit", "value",
"by_solid_angle"}; result.py says what each means.
"""

from dataclasses import asdict
from typing import Any

import numpy as np

from gonio.compare.result import Comparison, Pair, Profile


def as_json(comparison: Comparison) -> dict[str, Any]:
    """The object that `gonio compare --json` prints: plain values, no NaN."""
    found = [
        pair.metrics["whole"].global_accordance_percent.value for pair in comparison.pairs if "whole" in pair.metrics
    ]
    values = [value for value in found if value is not None]
    plain = {
        "a": comparison.a_name,
        "b": comparison.b_name,
        "b_kind": comparison.b_kind,
        "reference": "a",
        "settings": asdict(comparison.settings),
        "global_accordance_percent": {
            "lowest": min(values) if values else None,
            "mean": float(np.mean(values)) if values else None,
        },
        "distributions": [_pair(pair) for pair in comparison.pairs],
        "unmatched_a": comparison.unmatched_a,
        "unmatched_b": comparison.unmatched_b,
        "remarks": comparison.remarks,
    }
    return {name: _finite(value) for name, value in plain.items()}


def _pair(pair: Pair) -> dict[str, Any]:
    return {
        "channel": pair.channel,
        "incident_deg": [pair.incident_theta_deg, pair.incident_phi_deg],
        "b_channel": pair.b_channel,
        "b_incident_deg": [pair.b_incident_theta_deg, pair.b_incident_phi_deg],
        "route": pair.route,
        "shared_effects": pair.shared_effects,
        "interpolation_per_sr": _interpolation(pair),
        "metrics": {
            region: {key: value for key, value in asdict(metrics).items() if key != "region"}
            for region, metrics in pair.metrics.items()
        },
        "integrals": [asdict(integral) for integral in pair.integrals],
        "scatter_plane": {profile.region: _profile(profile) for profile in pair.profiles},
    }


def _interpolation(pair: Pair) -> dict[str, float] | None:
    if pair.interpolation_per_sr is None or not pair.used.any():
        return None
    error = pair.interpolation_per_sr[pair.used]
    return {"rms": float(np.sqrt(np.mean(error**2))), "largest": float(np.abs(error).max())}


def _profile(profile: Profile) -> dict[str, Any]:
    return {
        "points": int(profile.used.sum()),
        "left_out": int((~profile.used).sum()),
        "cv_rmsd": asdict(profile.cv_rmsd),
        "within_percent": [asdict(share) for share in profile.within_percent],
        "under_floor": profile.under_floor,
    }


def _finite(value: Any) -> Any:
    """The same with every number plain, those that are not finite as None."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value
