"""coverage.py: which part of the sphere belongs to each point: cells, no farther than the tracks lie apart."""

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.cells import Cells, cells
from gonio.geometry.pitch import path_pitch_rad, reach_rad

FloatArray = NDArray[np.float64]

REACH_FACTOR = 1.5  # of the local pitch


def cells_of_paths(unit: FloatArray, path: NDArray[np.int32], factor: float = REACH_FACTOR) -> Cells:
    """Cells of all points (n, 3), masked ones and those that no path flew (path -1) among them, cut at theta = 90.

    `path` (n,) as in Points. Points that were not flown mark holes in the tracks: they reach as far as their own
    spacing wants, but no farther than the tracks do, and no track reaches farther because of them.
    """
    flown = path >= 0
    reach = np.minimum(factor * path_pitch_rad(unit, path), np.pi)
    if flown.any():
        reach[~flown] = np.minimum(reach[~flown], reach[flown].max())
    return cells(unit, reach_rad=reach, shared=flown)


def cells_of_scattered(unit: FloatArray, factor: float = REACH_FACTOR) -> Cells:
    """Cells of points (n, 3) of which no path is known."""
    return cells(unit, reach_rad=reach_rad(unit, np.full(len(unit), -1, dtype=np.int32), factor))
