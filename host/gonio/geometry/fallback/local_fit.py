"""local_fit.py: local cubic and quadratic fits by numpy: what _sphere.local_fit does, and described in local_fit.py."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

FloatArray = NDArray[np.float64]

_CELL = 0.4  # of the radius
_FEWEST = 12
_FEWEST_FOR_CUBIC = 16
_QUADRATIC, _CUBIC = 6, 10
_MOST = 96  # no more cells than this have their middle within twice a radius of 2.5 cells
_WIDEST_RAD = 0.5
_WIDER = 2.0  # where a radius does not do, as at borders, so much more with the same cells
_GROWTH = np.sqrt(2.0)
_LEVELS = 11
_INDEPENDENT = 1e-3  # least share of a column of the fit that the columns before it may leave
_POINTS_AT_ONCE = 1 << 16
_SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def local_fit(
    unit: FloatArray, values: FloatArray, variance: FloatArray, used: NDArray[np.bool_], radius: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """See _sphere.pyi."""
    n = len(unit)
    result = np.full(n, np.nan), np.full((n, 3), np.nan), np.full((n, 6), np.nan), np.full(n, np.nan)
    left = np.arange(n)
    own_products = np.stack([unit[used, i] * unit[used, j] for i, j in _SYMMETRIC], axis=1)
    clusters = np.ones(int(used.sum())), unit[used], own_products, values[used], variance[used]
    for level in range(_LEVELS):
        reach = radius * _GROWTH**level
        if not used.any() or not len(left) or reach > _WIDEST_RAD:
            break
        clusters = _joined(*clusters, _CELL * reach)
        for wider in (1.0, _WIDER):
            again = [left[:0]]
            for begin in range(0, len(left), _POINTS_AT_ONCE):
                own = left[begin : begin + _POINTS_AT_ONCE]
                found, fits = _fitted(unit[own], wider * reach, *clusters[1:])
                for column, fit in zip(result, fits, strict=True):
                    column[own[found]] = fit
                again.append(own[~found])
            left = np.concatenate(again)
    return result


def _joined(
    count: FloatArray, unit: FloatArray, products: FloatArray, values: FloatArray, variance: FloatArray, cell: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Smaller clusters joined in cells: number of points (k,), and over these the means of direction (k, 3), its
    products xx yy zz xy xz yz (k, 6) and value (k,), and the variance of that mean (k,). Cells are rows of polar angle,
    divided in azimuth."""
    rows = int(np.ceil(np.pi / cell))
    polar = np.arctan2(np.hypot(unit[:, 0], unit[:, 1]), unit[:, 2])
    row = np.minimum((polar * (rows / np.pi)).astype(np.int64), rows - 1)
    columns = np.maximum(1, np.ceil(2.0 * rows * np.sin((np.arange(rows) + 0.5) * np.pi / rows))).astype(np.int64)
    turn = np.arctan2(unit[:, 1], unit[:, 0]) / (2.0 * np.pi)
    turn = np.where(turn < 0.0, turn + 1.0, turn)
    column = np.minimum((turn * columns[row]).astype(np.int64), columns[row] - 1)
    cells, group = np.unique((row << 32) | column, return_inverse=True)
    total = np.asarray(np.bincount(group, count, len(cells)), dtype=np.float64)

    def mean(of: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(group, count * of, len(cells)) / total)

    direction, squares = (np.stack([mean(one) for one in of.T], axis=1) for of in (unit, products))
    return total, direction, squares, mean(values), mean(count * variance) / total


def _fitted(
    unit: FloatArray, reach: float, direction: FloatArray, products: FloatArray, value: FloatArray, noise: FloatArray
) -> tuple[NDArray[np.bool_], tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
    """Which points (n,) have a fit, and the fits of those."""
    k = min(_MOST, len(direction))
    apart, near = cKDTree(direction).query(unit, k=k, distance_upper_bound=reach)
    apart, near = apart.reshape(len(unit), k), near.reshape(len(unit), k)
    there = np.isfinite(apart)
    found = there.sum(axis=1) >= _FEWEST
    unit, apart, near, there = unit[found], apart[found], near[found], there[found]
    near = np.where(there, near, 0)
    weight = np.where(there, (1.0 - np.where(there, apart / reach, 0.0) ** 2) ** 2, 0.0)
    e1, e2 = tangents(unit)
    # Means of 1, x, y, x^2/2, xy, y^2/2 over each cell, in units of the radius.
    mean, square = direction[near], products[near]
    x, y = (np.einsum("nkj,nj->nk", mean, e) / reach for e in (e1, e2))

    def product(u: FloatArray, v: FloatArray) -> FloatArray:
        pairs = np.stack(
            [u[:, i] * v[:, j] if i == j else u[:, i] * v[:, j] + u[:, j] * v[:, i] for i, j in _SYMMETRIC], axis=1
        )
        return np.asarray(np.einsum("nkj,nj->nk", square, pairs) / reach**2)

    # Third powers: as if the points of a cell lay evenly about their mean.
    xx, xy, yy = product(e1, e1), product(e1, e2), product(e2, e2)
    columns = [np.ones_like(x), x, y, 0.5 * xx, xy, 0.5 * yy, (3.0 * x * xx - 2.0 * x**3) / 6.0]
    columns += [0.5 * (2.0 * x * xy + y * xx - 2.0 * x * x * y), 0.5 * (2.0 * y * xy + x * yy - 2.0 * x * y * y)]
    columns += [(3.0 * y * yy - 2.0 * y**3) / 6.0]
    rows = np.stack(columns, axis=2)
    normal = np.einsum("nk,nki,nkj->nij", weight, rows, rows)
    right = np.einsum("nk,nki,nk->ni", weight, rows, value[near])
    fixed = independent(normal)
    quadratic = (there.sum(axis=1) < _FEWEST_FOR_CUBIC) | (fixed < _CUBIC)
    for column in range(_QUADRATIC, _CUBIC):  # no cubic terms: each is its own equation, with nothing on the right
        normal[quadratic, column, :] = 0.0
        normal[quadratic, :, column] = 0.0
        normal[quadratic, column, column] = 1.0
        right[quadratic, column] = 0.0
        rows[quadratic, :, column] = 0.0
    good = fixed >= _QUADRATIC
    found[np.flatnonzero(found)[~good]] = False
    normal, right, rows, weight, near = normal[good], right[good], rows[good], weight[good], near[good]
    e1, e2 = e1[good], e2[good]
    inverse = np.linalg.inv(normal)
    fit = np.einsum("nij,nj->ni", inverse, right)
    spread = np.einsum("nij,nkj->nki", inverse[:, 1:3], rows) * weight[:, :, None]
    gradient_variance = 0.5 * np.einsum("nki,nk->n", spread**2, noise[near]) / reach**2
    gradient = (fit[:, 1:2] * e1 + fit[:, 2:3] * e2) / reach
    hessian = np.stack(
        [
            fit[:, 3] * e1[:, i] * e1[:, j]
            + fit[:, 4] * (e1[:, i] * e2[:, j] + e1[:, j] * e2[:, i])
            + fit[:, 5] * e2[:, i] * e2[:, j]
            for i, j in _SYMMETRIC
        ],
        axis=1,
    )
    return found, (fit[:, 0], gradient, hessian / reach**2, gradient_variance)


def independent(normal: FloatArray) -> NDArray[np.int64]:
    """How many columns (n,) of the fit there are before one that is nearly made of those before it: by the pivots of
    Cholesky's decomposition (n, 10, 10) against the diagonal."""
    rest = normal.copy()
    count = np.zeros(len(normal), dtype=np.int64)
    for k in range(normal.shape[1]):
        pivot = rest[:, k, k]
        scale = normal[:, k, k]
        if k in (1, 2):  # along a line the other coordinate is next to nothing on the scale of the radius
            scale = np.maximum(scale, normal[:, 0, 0])
        good = (count == k) & (pivot > _INDEPENDENT * scale)
        count[good] += 1
        safe = np.where(good, pivot, np.inf)
        rest = rest - rest[:, :, k, None] * rest[:, k, None, :] / safe[:, None, None]
    return count


def tangents(unit: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (n, 3) square to each of `unit` and to each other."""
    helper = np.where(np.abs(unit[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    e1 = np.cross(helper, unit)
    e1 /= np.linalg.norm(e1, axis=1)[:, None]
    return e1, np.cross(unit, e1)
