"""points.py: some of a distribution's points, and their directions."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]


def taken(whole: Distribution, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> Distribution:
    """The chosen points, in that order, with all their columns; integrals and cells stay those of the whole."""
    n = len(whole.theta_deg)
    columns: dict[str, Any] = {
        k: v[chosen] for k, v in vars(whole).items() if isinstance(v, np.ndarray) and v.shape == (n,)
    }
    return replace(whole, **columns, effects={key: column[chosen] for key, column in whole.effects.items()})


def measured_points(distribution: Distribution) -> Distribution:
    """The points that hold a value."""
    return taken(distribution, distribution.measured)


def units(distribution: Distribution) -> FloatArray:
    """Directions (n, 3)."""
    return unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)


def path_numbers(distribution: Distribution) -> NDArray[np.int32]:
    """Path of each point (n,); -1 where it is not known."""
    n = len(distribution.theta_deg)
    return distribution.path if len(distribution.path) == n else np.full(n, -1, dtype=np.int32)


def effect_column(distribution: Distribution, key: str) -> FloatArray:
    """Column (n,) of an effect: one that a distribution does not have does not move it."""
    column = distribution.effects.get(key)
    return np.where(distribution.measured, 0.0, np.nan) if column is None else column
