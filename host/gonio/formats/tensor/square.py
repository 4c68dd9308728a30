"""square.py: Shirley and Chiu's map between the unit square and the disc of direction cosines, and points in its cells.

P. Shirley, K. Chiu, "A low distortion map between disk and square", J. Graphics Tools 2(3), 1997: concentric squares
become concentric circles, areas stay in proportion. An area of the disc of (x, y) is a projected solid angle, so cells
of equal size in the square have equal projected solid angle, pi times their area.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


def square_from_disc(xy: FloatArray) -> FloatArray:
    """Places (..., 2) in [0, 1]^2 of direction cosines (..., 2) within the unit circle."""
    x, y = xy[..., 0], xy[..., 1]
    radius = np.hypot(x, y)
    along_x = np.abs(x) >= np.abs(y)
    major, minor = np.where(along_x, x, y), np.where(along_x, y, x)
    nothing = major == 0.0
    across = radius * np.arctan(minor / np.where(nothing, 1.0, np.abs(major))) / (np.pi / 4.0)
    along = np.copysign(radius, major)
    pair = np.stack((np.where(along_x, along, across), np.where(along_x, across, along)), axis=-1)
    return np.asarray(0.5 + 0.5 * pair)


def disc_from_square(place: FloatArray) -> FloatArray:
    """Direction cosines (..., 2) of places (..., 2) in [0, 1]^2. Inverse of `square_from_disc`."""
    pair = 2.0 * np.asarray(place, dtype=np.float64) - 1.0
    a, b = pair[..., 0], pair[..., 1]
    along_a = np.abs(a) >= np.abs(b)
    major, minor = np.where(along_a, a, b), np.where(along_a, b, a)
    angle = (np.pi / 4.0) * minor / np.where(major == 0.0, 1.0, np.abs(major))
    along, across = major * np.cos(angle), np.abs(major) * np.sin(angle)
    return np.stack((np.where(along_a, along, across), np.where(along_a, across, along)), axis=-1)


def on_diagonal(index: IndexArray, level: int) -> NDArray[np.bool_]:
    """Whether cells (n, 2) of a level's 2^level x 2^level grid lie on one of the square's diagonals."""
    last = (1 << level) - 1
    return np.asarray((index[:, 0] == index[:, 1]) | (index[:, 0] + index[:, 1] == last))


def cell_points(index: IndexArray, level: int, order: int, *, diagonal: bool) -> tuple[FloatArray, FloatArray]:
    """Gauss points of cells (n, 2), all on a diagonal or none: unit vectors (n, q, 3) with z >= 0, weights (n, q).

    The weights turn a sum of DSF into the cell's mean BSDF: integral of DSF over solid angle, over the integral of
    cos. Within a quarter of the square the larger coordinate is sin(theta), so an element of solid angle is
    (pi / 4) d(theta) d(minor): points are Gauss-Legendre's in theta and the minor coordinate, and grazing angles are
    nothing special. A cell on a diagonal is two triangles. Level 1 at least: no cell may hold the centre inside.
    """
    # Folded to where both coordinates are positive, and the larger first; the way back is kept.
    low = np.abs(2.0 * index / (1 << level) - 1.0)
    high = np.abs(2.0 * (index + 1) / (1 << level) - 1.0)
    sign = np.where(2 * index >= (1 << level), 1.0, -1.0)
    low, high = np.minimum(low, high), np.maximum(low, high)
    swapped = low[:, 1] > low[:, 0]
    low, high = (np.where(swapped[:, None], side[:, ::-1], side) for side in (low, high))
    node, gauss = np.polynomial.legendre.leggauss(order)
    node, gauss = 0.5 + 0.5 * node, 0.5 * gauss
    theta_low, theta_high = np.arcsin(low[:, 0]), np.arcsin(high[:, 0])
    span = theta_high - theta_low
    theta = (theta_low[:, None] + span[:, None] * node)[:, :, None]  # (n, order, 1)
    major = np.sin(theta)
    top = major if diagonal else high[:, 1][:, None, None]
    bottom = low[:, 1][:, None, None]
    minor = np.broadcast_to(bottom + (top - bottom) * node, (len(index), order, order))
    area = (high[:, 0] - low[:, 0]) * (high[:, 1] - low[:, 1])
    weight = gauss[:, None] * gauss * (span / area)[:, None, None] * np.broadcast_to(top - bottom, minor.shape)
    angle = (np.pi / 4.0) * minor / np.maximum(major, 1e-300)
    along, across = major * np.cos(angle), major * np.sin(angle)
    z = np.broadcast_to(np.cos(theta), minor.shape)
    n = len(index)
    flat = [values.reshape(n, -1) for values in (along, across, z)]
    points = np.stack(flat, axis=-1)
    weight = weight.reshape(n, -1)
    if diagonal:
        points = np.concatenate((points, points[:, :, [1, 0, 2]]), axis=1)
        weight = np.concatenate((weight, weight), axis=1)
    else:
        points[swapped] = points[swapped][:, :, [1, 0, 2]]
    points[:, :, :2] *= sign[:, None, :]
    return points, weight


def packed(index: IndexArray, level: int) -> IndexArray:
    """One whole number (n,) per cell of a level, from its numbers (n, c) along c coordinates."""
    key = index[:, 0].astype(np.int64)
    for column in range(1, index.shape[1]):
        key = (key << level) | index[:, column]
    return np.asarray(key)


def distinct(index: IndexArray, level: int) -> tuple[IndexArray, IndexArray]:
    """Distinct cells (u, c) among cells (n, c) of a level, and which of them each is (n,)."""
    key = packed(index, level)
    present = np.unique(key)
    count = index.shape[1]
    columns = [(present >> (level * (count - 1 - c))) & ((1 << level) - 1) for c in range(count)]
    return np.stack(columns, axis=1), np.searchsorted(present, key)
