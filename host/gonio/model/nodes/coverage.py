"""coverage.py: where in the hemisphere the points of an incident direction lie: within reach, between them, beyond."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.spatial import ConvexHull, QhullError, cKDTree

FloatArray = NDArray[np.float64]

SIZE = 64  # cells per side of the square about Lambert's disc
WITHIN, BETWEEN, BEYOND = 0, 1, 2  # a point is near; inside the points' hull; outside
_MANY = 15_000  # points, from which on counting them per cell says who is near
_REACH = 1.5  # times the usual distance of neighbouring points, as cells of integrals have it


def coverage(disc: FloatArray) -> NDArray[np.uint8]:
    """WITHIN, BETWEEN or BEYOND (SIZE, SIZE) for cells of Lambert's disc, row along y, from points (n, 2) on it."""
    middle = (np.arange(SIZE) + 0.5) * (2.0 / SIZE) - 1.0
    cells = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
    if len(disc) >= _MANY:
        row = _cell(disc)
        near = np.bincount(row, minlength=SIZE * SIZE).reshape(SIZE, SIZE) > 0
        disc = cells[near.ravel()]  # stand for their points in the hull
        near = binary_dilation(near)
    else:
        tree = cKDTree(disc)
        spacing = float(np.median(tree.query(disc, k=min(2, len(disc)))[0][:, -1])) if len(disc) > 1 else 0.0
        near = (tree.query(cells)[0] <= max(_REACH * spacing, 1.5 / SIZE)).reshape(SIZE, SIZE)
    inside = _in_hull(disc, cells).reshape(SIZE, SIZE)
    return np.where(near, WITHIN, np.where(inside, BETWEEN, BEYOND)).astype(np.uint8)


def look_up(grid: NDArray[np.uint8], xy: FloatArray) -> NDArray[np.uint8]:
    """The grid's values (m,) in directions with these x and y (m, 2) of unit vectors, z >= 0."""
    z = np.sqrt(np.maximum(1.0 - np.sum(xy**2, axis=1), 0.0))
    return np.asarray(grid.ravel()[_cell(xy / np.sqrt(1.0 + z)[:, None])])


def _cell(disc: FloatArray) -> NDArray[np.int64]:
    place = np.clip(((disc + 1.0) * (SIZE / 2)).astype(np.int64), 0, SIZE - 1)
    return np.asarray(place[:, 1] * SIZE + place[:, 0])


def _in_hull(disc: FloatArray, cells: FloatArray) -> NDArray[np.bool_]:
    try:
        hull = ConvexHull(disc)
    except QhullError:  # fewer than three, or all on one line
        return np.zeros(len(cells), dtype=bool)
    return np.asarray(np.all(cells @ hull.equations[:, :2].T + hull.equations[:, 2] <= 1e-9, axis=1))
