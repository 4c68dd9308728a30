"""reporting.py: what stands in the model's record about a fitted component: parameters, both ABg fits, integrals."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.component import Component
from gonio.model.analytic.component_fit import Fitted, theta_deg
from gonio.model.analytic.simplex_fit import fit_simplex
from gonio.model.analytic.weighted_fit import WeightedFit, dsf_of
from gonio.model.analytic.weighting import left
from gonio.model.nodes.points import Points

_PAIRS = 400
_LARGEST_THETA_DEG = 75.0


def parameter_record(fitted: Fitted, fit: WeightedFit) -> dict[str, Any]:
    """Value, unit, standard uncertainty (None: at a bound, or without effect) per parameter; and the correlations of
    their fitted forms."""
    spread = np.sqrt(np.diag(fit.covariance))
    result: dict[str, Any] = {}
    for at, parameter in enumerate(fitted.component.family.parameters):
        u = float(spread[at] * (fit.values[at] if parameter.log else 1.0))
        result[parameter.name] = {
            "value": float(fit.values[at]),
            "unit": parameter.unit,
            "u": u if np.isfinite(u) else None,
        }
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit.covariance / np.outer(spread, spread)
    result["correlation"] = [[float(x) if np.isfinite(x) else None for x in row] for row in correlation]
    return result


def _line(component: Component, values: FloatArray, points: Points) -> dict[str, float]:
    """Errors and exact integral of parameters (p,), before any tie."""
    error = left(points, dsf_of(component.family, values, points))
    whole = component.family.integral(values[None, :], points.incident[None, :])
    return {
        "rms_per_sr": error.rms_per_sr,
        "cv": error.cv,
        "misplaced": error.misplaced,
        "integral": float(whole[0]),
    }


def fit_records(fitted: Fitted, directions: Sequence[Points]) -> list[dict[str, Any]]:
    """Per incident angle: measured integral; the weighted fit; of ABg also the simplex fit as published."""
    result = []
    for number, points in enumerate(directions):
        fit = fitted.fits[number if len(fitted.fits) > 1 else 0]
        entry: dict[str, Any] = {
            "theta_i_deg": theta_deg(points),
            "measured_integral": points.stated if np.isfinite(points.stated) else points.integral,
            "weighted": {**parameter_record(fitted, fit), **_line(fitted.component, fit.values, points)},
        }
        if fitted.component.family.name == "abg":
            published = fit_simplex(points)
            entry["as_published"] = {
                **{name: float(v) for name, v in zip(("A", "B", "g"), published.values, strict=True)},
                "rms_bsdf_per_sr": published.rms_bsdf_per_sr,
                "points": published.points,
                **_line(fitted.component, published.values, points),
            }
        result.append(entry)
    return result


def reciprocity(component: Component) -> float:
    """Root mean square of f(i, s) - f(s, i) over the mean of f, for pairs up to 75 degrees from the normal, seeded."""
    random = np.random.default_rng(1)
    z = random.uniform(np.cos(np.radians(_LARGEST_THETA_DEG)), 1.0, (2, _PAIRS))
    phi = random.uniform(0.0, 2.0 * np.pi, (2, _PAIRS))
    across = np.sqrt(1.0 - z**2)
    i, o = np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=-1)
    each = np.arange(_PAIRS)
    there, back = component.bsdf_per_sr(i, o, each), component.bsdf_per_sr(o, i, each)
    mean = float(np.mean(there + back)) / 2.0
    return float(np.sqrt(np.mean((there - back) ** 2))) / mean if mean > 0.0 else 0.0
