"""reciprocity.py: how far a model keeps f(i, o) = f(o, i), and points averaged to keep it where that is asked for.

Measured data are not reciprocal to the last digit; nothing is symmetrised unless the user asks.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Origin
from gonio.model.channel import Fitted
from gonio.model.nodes.points import Component, Points

FloatArray = NDArray[np.float64]

_MOST_PAIRS = 400  # per measured direction
_MOST_AVERAGED = 20_000  # points per measured direction that are averaged; thinned out evenly
_LEAST_COSINE = np.cos(np.radians(85.0))  # closer to grazing a BSDF is mostly the error of its cosine


def residual(model: Fitted, points: dict[Component, list[Points]]) -> dict[str, dict[str, Any]]:
    """Per component, over pairs of a measured direction and points about it that the model knows as incident ones too.

    relative_rms: of f(i, o) - f(o, i) over the rms of their mean, both weighted by solid angle; rms_u: of the
    difference in units of its standard uncertainty (both taken as uncertain as the point, relatively).
    """
    result = {}
    for component, all_points in points.items():
        parts = [_pairs(model, component, p) for p in all_points]
        known = [p for p in parts if p is not None]
        if not known:
            continue
        there, back, u, sr = (np.concatenate([p[k] for p in known]) for k in range(4))
        difference = there - back
        in_u = np.divide(difference, u, out=np.zeros_like(u), where=u > 0.0)  # u is 0 where there is no light at all
        size = np.sqrt(sr @ (0.25 * (there + back) ** 2))
        result[component.name] = {
            "pairs": len(there),
            "relative_rms": float(np.sqrt(sr @ difference**2) / max(size, 1e-300)),
            "rms_u": float(np.sqrt(np.mean(in_u**2))),
        }
    return result


def _pairs(
    model: Fitted, component: Component, points: Points
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None:
    """BSDF there and back, uncertainty of their difference, solid angle."""
    rows = np.flatnonzero(points.unit[:, 2] > _LEAST_COSINE)
    if len(rows) > _MOST_PAIRS:
        rows = np.sort(np.random.default_rng(0).choice(rows, _MOST_PAIRS, replace=False))
    if len(rows) == 0 or points.incident[2] < _LEAST_COSINE:
        return None
    back, known = _reverse(model, component, points.incident, points.unit[rows])
    rows, back = rows[known], back[known]
    if len(rows) == 0:
        return None
    light, away = _sides(component, points.incident[None], points.unit[rows])
    cosine = points.unit[rows, 2]
    there = model.dsf_per_sr(light, away) / cosine
    u_there = np.sqrt(points.variance_per_sr2[rows]) / cosine
    relative = u_there / np.maximum(np.abs(points.dsf_per_sr[rows]) / cosine, u_there)
    u = np.hypot(u_there, relative * back)
    return there, back, np.maximum(u, 1e-300), points.solid_angle_sr[rows]


def _sides(component: Component, incident: FloatArray, outgoing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Folded directions put back on their sides of the sample."""
    below = np.array([1.0, 1.0, -1.0])
    return (
        incident if component.incident_front else incident * below,
        outgoing if component.outgoing_front else outgoing * below,
    )


def _reverse(
    model: Fitted, component: Component, incident: FloatArray, outgoing: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """BSDF (m,) for light from folded outgoing directions (m, 3) towards the incident one, and where it is known: not
    absent, not extrapolated."""
    reverse = Component(component.outgoing_front, component.incident_front)
    own = model.components.get(reverse)
    if own is None:
        return np.zeros(len(outgoing)), np.zeros(len(outgoing), dtype=bool)
    known = own.resolver.origin(outgoing) == Origin.INTERPOLATED
    known |= own.measured(outgoing)
    light, away = _sides(reverse, outgoing, np.broadcast_to(incident, outgoing.shape))
    value = model.dsf_per_sr(light, np.ascontiguousarray(away), np.arange(len(outgoing)))
    return np.asarray(value / incident[2]), known


def averaged(model: Fitted, points: dict[Component, list[Points]]) -> dict[Component, list[Points]]:
    """Points with the mean of what was measured and what the model says for the way back, as BSDF, where it knows
    that; many points are thinned out."""
    return {component: [_averaged(model, component, p) for p in own] for component, own in points.items()}


def _averaged(model: Fitted, component: Component, points: Points) -> Points:
    step = -(-len(points.unit) // _MOST_AVERAGED)
    thin = points.some(np.arange(0, len(points.unit), step))
    unit, dsf = thin.unit, np.array(thin.dsf_per_sr)
    steep = unit[:, 2] > _LEAST_COSINE
    back, known = _reverse(model, component, points.incident, unit[steep])
    both = np.flatnonzero(steep)[known]
    dsf[both] = 0.5 * (dsf[both] + back[known] * unit[both, 2])
    return replace(thin, dsf_per_sr=dsf)
