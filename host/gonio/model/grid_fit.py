"""grid_fit.py: a smooth function on a square grid through scattered, noisy points, over their holes."""

import numpy as np
from numpy.typing import NDArray

from gonio.model.backend import model

FloatArray = NDArray[np.float64]

MOST_CELLS = 512


def fit_grid(
    position: FloatArray, value: FloatArray, variance: FloatArray, weight: FloatArray, *, half_width: float, size: int
) -> FloatArray:
    """Nodes (size, size) over [-half_width, half_width]^2, row i along the second coordinate, size = 2^p + 1.

    From position (n, 2), value (n,), variance (n,) of its noise and weight (n,). Points without weight or value, or
    outside, are passed over; without any: zeros.

    From one cell to the finest grid, each level corrects what the coarser one left over: a node takes the mean of its
    points' residuals, weighted with their bilinear weight and their own, several times over (Jacobi's iteration of
    the weighted least squares, begun from the smooth side). Nodes without points keep what the coarser level says.
    Where the points are noisy a correction c of variance v is multiplied by max(0, 1 - 2 <v> / <c^2>): Wiener's filter
    in the positive part of James and Stein, with means over the node and its neighbours (5 x 5, binomial weights), and
    with twice the variance for so few of them.

    At the level of 33 x 33 nodes holes are spanned by a thin plate (host/native/model/thin_plate.hpp), which continues
    slope and curvature of what lies around them: a cosine is met within about a fifth of the hole's radius squared.
    """
    return model.fit_grid(
        np.ascontiguousarray(position, dtype=np.float64),
        np.ascontiguousarray(value, dtype=np.float64),
        np.ascontiguousarray(variance, dtype=np.float64),
        np.ascontiguousarray(weight, dtype=np.float64),
        half_width,
        size,
    )


def grid_at(values: FloatArray, half_width: float, position: FloatArray) -> FloatArray:
    """Bilinear value (n,) of nodes (s, s) at positions (n, 2), at the nearest rim where outside."""
    return model.grid_at(
        np.ascontiguousarray(values, dtype=np.float64), half_width, np.ascontiguousarray(position, dtype=np.float64)
    )


def suitable_size(position: FloatArray, half_width: float) -> int:
    """Size 2^p + 1 of a grid whose nodes lie about as far apart as the points (n, 2) do, at most 513.

    Apart: the root of the area per point, which half of the points lie nearer together than; the area is counted in
    bins, so that the points of a track with wide gaps beside it do not seem near each other.
    """
    return model.suitable_size(np.ascontiguousarray(position, dtype=np.float64), half_width, MOST_CELLS)
