"""neighbourhoods.py: numbers of the cells of a grid on the sphere, all of about one size."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def numbers(theta_deg: FloatArray, phi_deg: FloatArray, size_deg: float) -> NDArray[np.int64]:
    """Number (n,) of the grid cell that each direction lies in: rings `size_deg` wide, divided into arcs as long as
    that. Numbers run from 0 without gaps."""
    ring = np.floor(np.minimum(theta_deg, 180.0 - 1e-9) / size_deg).astype(np.int64)
    middle = np.radians((ring + 0.5) * size_deg)
    arcs = np.maximum(np.rint(360.0 / size_deg * np.sin(middle)), 1.0)
    arc = np.floor(np.mod(phi_deg, 360.0) / 360.0 * arcs).astype(np.int64)
    most = int(360.0 / size_deg) + 2
    return np.asarray(np.unique(ring * most + arc, return_inverse=True)[1])


def thinned(theta_deg: FloatArray, phi_deg: FloatArray, most: int) -> NDArray[np.intp]:
    """Indices of at most `most` of the directions, evenly over where they are."""
    chosen = np.arange(len(theta_deg))
    size_deg = 0.25
    while len(chosen) > most:
        chosen = np.sort(np.unique(numbers(theta_deg, phi_deg, size_deg), return_index=True)[1])
        size_deg *= 1.25
    return chosen
