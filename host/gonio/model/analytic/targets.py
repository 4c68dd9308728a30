"""targets.py: what a component's hemispherical integral is tied to: the points' own, or an integrating sphere's."""

from collections.abc import Sequence

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.component import Component
from gonio.model.analytic.component_fit import theta_deg
from gonio.model.analytic.tie import Tie
from gonio.model.nodes.points import Points
from gonio.model.sphere_values import SphereRow

WHOLE = 0.98  # share of the cosine-weighted hemisphere from which on a sum over points is the whole


def own_values(component: Component, directions: Sequence[Points]) -> tuple[FloatArray, bool]:
    """rho or tau (n,) of the points, and whether the model had to stand in for what was not measured.

    Where points cover the hemisphere it is what the dataset states (else the sum over cells); where they do not, that
    is multiplied by the model's exact integral over the model's sum over the same cells.
    """
    values, filled = [], False
    for points in directions:
        value = points.stated if np.isfinite(points.stated) else points.integral
        share = float(points.solid_angle_sr @ points.unit[:, 2]) / np.pi
        if share < WHOLE:
            which = np.zeros(len(points.dsf_per_sr), dtype=np.int64)
            model = component.dsf_per_sr(points.incident[None, :], points.unit, which)
            seen = float(model @ points.solid_angle_sr)
            whole = float(component.integral(np.array([theta_deg(points)]))[0])
            value, filled = (value * whole / seen if seen > 0.0 else value), True
        values.append(value)
    return np.clip(np.array(values), 0.0, 1.0), filled


def tie_of(component: Component, directions: Sequence[Points], sphere: Sequence[SphereRow], sphere_name: str) -> Tie:
    """The tie of a component: the points' values at their angles, or, where a sphere measured, those multiplied by what
    makes them equal to the sphere's at its angles (in between linearly, beyond by the nearest)."""
    angles = np.array([theta_deg(points) for points in directions])
    value, filled = own_values(component, directions)
    source = "the points' hemispherical sums" + (", unmeasured parts filled by the model" if filled else "")
    if not sphere:
        return Tie(angles, value, source)
    at = np.array([row.theta_i_deg for row in sphere])
    measured = np.array([row.value for row in sphere])
    own = Tie(angles, value, source).at(at)
    ratio = np.where(own > 0.0, measured / np.where(own > 0.0, own, 1.0), 1.0)
    nodes = np.union1d(np.round(angles, 6), np.round(at, 6))
    factor = np.interp(nodes, at, ratio)
    tied = np.clip(Tie(angles, value, source).at(nodes) * factor, 0.0, 1.0)
    tied[np.searchsorted(nodes, np.round(at, 6))] = np.clip(measured, 0.0, 1.0)
    text = f"{sphere_name} at {', '.join(f'{angle:g}' for angle in at)} degrees"
    return Tie(nodes, tied, text if len(at) > 1 else f"{text}; with angle as {source}")
