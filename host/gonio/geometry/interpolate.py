"""interpolate.py: linear interpolation between irregular directions, on their Delaunay triangles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.geometry.backend import sphere

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Weights:
    """For each of m directions: index (m, 3) of three points, their weights (m, 3), which add up to 1, and inside
    (m,): whether the direction lies within the reach of a point of its triangle. Outside the weights are 0 and the
    indices those of some point."""

    index: NDArray[np.int64]
    weight: FloatArray
    inside: NDArray[np.bool_]

    def of(self, values: ArrayLike) -> FloatArray:
        """The values (n,) of the points at the directions (m,); NaN outside."""
        result = np.einsum("ij,ij->i", self.weight, np.asarray(values, dtype=np.float64)[self.index])
        return np.where(self.inside, result, np.nan)


class Interpolation:
    """Triangles of n directions (n, 3), made once for many queries.

    `reach_rad` (a number or (n,); None: no limit) ends what is known around each point; with `cut_at_horizon` the
    hemispheres z >= 0 and z < 0 know nothing of each other, and between the last points and the horizon a point's
    mirror image stands in.
    """

    def __init__(self, unit: ArrayLike, *, reach_rad: ArrayLike | None = None, cut_at_horizon: bool = True) -> None:
        points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
        reach = np.full(len(points), np.pi)
        if reach_rad is not None:
            reach = np.minimum(np.broadcast_to(np.asarray(reach_rad, dtype=np.float64), reach.shape), np.pi)
        self._locator = sphere.Locator(points, np.ascontiguousarray(reach), cut_at_horizon)

    def at(self, directions: ArrayLike) -> Weights:
        """Weights for the unit vectors (m, 3)."""
        wanted = np.ascontiguousarray(directions, dtype=np.float64).reshape(-1, 3)
        return Weights(*self._locator.at(wanted))
