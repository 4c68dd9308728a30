"""component_fit.py: a family fitted to one component: one set of parameters, or one per incident polar angle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.component import Component
from gonio.model.analytic.family import Family, Process
from gonio.model.analytic.starts import starts_of
from gonio.model.analytic.weighted_fit import WeightedFit, fit_weighted
from gonio.model.nodes.points import Points, joined
from gonio.model.nodes.symmetry import to_azimuth_0


@dataclass(frozen=True)
class Fitted:
    """A component without tie, and the fits behind it: one per incident angle, or a single one."""

    component: Component
    fits: tuple[WeightedFit, ...]


def by_polar_angle(points: Sequence[Points]) -> list[Points]:
    """Isotropic: turned to azimuth 0, those of one theta_i joined, in ascending order of it."""
    return sorted(joined([to_azimuth_0(p) for p in points]), key=theta_deg)


def theta_deg(points: Points) -> float:
    """Incident polar angle from the normal of the light's side."""
    x, y, z = points.incident
    return float(np.round(np.degrees(np.arctan2(np.hypot(x, y), z)), 9))


def fit_component(family: Family, process: Process, directions: Sequence[Points]) -> Fitted:
    """`directions` as of `by_polar_angle`."""
    angles = np.array([theta_deg(points) for points in directions])
    if family.per_direction:
        fits = tuple(fit_weighted(family, [points], starts_of(family, [points])) for points in directions)
    else:
        fits = (fit_weighted(family, directions, starts_of(family, directions)),)
        angles = angles[:1]
    return Fitted(Component(family, process, angles, np.array([fit.values for fit in fits])), fits)


def without(fitted: Fitted, directions: Sequence[Points], number: int) -> Component:
    """The component as it would be had direction `number` not been measured."""
    family, process = fitted.component.family, fitted.component.process
    if family.per_direction:
        kept = np.arange(len(directions)) != number
        return Component(family, process, fitted.component.theta_deg[kept], fitted.component.values[kept])
    rest = [points for at, points in enumerate(directions) if at != number]
    start: FloatArray = fitted.component.values
    again = fit_weighted(family, rest, start)
    return Component(family, process, fitted.component.theta_deg, again.values[None, :])
