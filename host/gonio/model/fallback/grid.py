"""grid.py: multilevel bilinear approximation of scattered data by numpy: what _model.fit_grid and grid_at do.

A level's least-squares system needs of the points in each cell only the moments sum w x^a y^b (x, y: 0 to 1 over the
cell), and a coarser cell's moments follow from its four cells': the points are looked at once.
"""

import numpy as np
from numpy.typing import NDArray

from gonio.model.fallback.thin_plate import span_holes

FloatArray = NDArray[np.float64]

_POINTS_PER_BIN = 16.0
_MOST_BINS = 64.0
_PASSES = 2
_PASSES_FINEST = 4
_HESITATION = 0.02  # a node whose cells have points, but near their other corners, follows them less
_CELLS_SPANNED = 32  # of the level at which holes are spanned
_KNOWN = 0.1  # least share of the cells' points that a node has to be no hole
_CAUTION = 2.0  # times the variance that noise is taken to have


def grid_at(values: FloatArray, half_width: float, position: FloatArray) -> FloatArray:
    """See _model.pyi."""
    cells = len(values) - 1
    if cells < 1 or values.shape != (cells + 1, cells + 1):
        raise ValueError("a grid has as many rows as columns, two at least")
    at = np.clip((position / half_width + 1.0) * (0.5 * cells), 0.0, cells)
    low = np.minimum(at, cells - 1).astype(np.int64)
    x, y = (at - low).T
    j, i = low.T
    below = values[i, j] * (1.0 - x) + values[i, j + 1] * x
    above = values[i + 1, j] * (1.0 - x) + values[i + 1, j + 1] * x
    return np.asarray(below * (1.0 - y) + above * y)


def fit_grid(
    position: FloatArray, value: FloatArray, variance: FloatArray, weight: FloatArray, half_width: float, size: int
) -> FloatArray:
    """See _model.pyi."""
    cells = size - 1
    if cells < 1 or cells & (cells - 1):
        raise ValueError("a grid has 2^p + 1 nodes along each side")
    if not len(position) == len(value) == len(variance) == len(weight):
        raise ValueError("one value, variance and weight per position is needed")
    used = np.isfinite(value) & (weight > 0.0) & np.all(np.abs(position) <= half_width, axis=1)
    if not np.any(used):
        return np.zeros((size, size))
    value, variance, weight = value[used], variance[used], weight[used]
    noisy = bool(np.any(variance > 0.0))
    at = np.clip((position[used] / half_width + 1.0) * (0.5 * cells), 0.0, cells)
    low = np.minimum(at, cells - 1).astype(np.int64)
    x, y = (at - low).T
    cell = low[:, 1] * cells + low[:, 0]
    mass = _moments(cell, x, y, weight, cells, 3)
    load = _moments(cell, x, y, weight * value, cells, 2)
    noise = _moments(cell, x, y, weight**2 * variance, cells, 3) if noisy else None
    levels = [(mass, load, noise)]
    while levels[-1][0].shape[-1] > 1:
        of = levels[-1]
        levels.append((_coarser(of[0]), _coarser(of[1]), None if of[2] is None else _coarser(of[2])))
    nodes = np.full((2, 2), np.sum(load[0, 0]) / np.sum(mass[0, 0]))
    while levels:
        own_mass, own_load, own_noise = levels.pop()
        if own_mass.shape[-1] > 1:
            nodes = _finer(nodes)
        divisor, blur, known = _ground(own_mass, own_noise)
        for _ in range(_PASSES if levels else _PASSES_FINEST):
            nodes += _correction(nodes, own_mass, own_load, divisor, blur)
        if own_mass.shape[-1] == min(_CELLS_SPANNED, cells):
            nodes = span_holes(nodes, known, blur)
    return nodes


def _moments(cell: NDArray[np.int64], x: FloatArray, y: FloatArray, of: FloatArray, cells: int, n: int) -> FloatArray:
    """Sums of `of` x^a y^b over the points of each cell, (a, b, row, column), a and b below n."""
    return np.array(
        [[np.bincount(cell, of * x**a * y**b, cells * cells).reshape(cells, cells) for b in range(n)] for a in range(n)]
    )


def _coarser(moments: FloatArray) -> FloatArray:
    """Of cells twice as wide: a point's place in one is (x + 0 or 1) / 2."""
    n = len(moments)
    # Row: power a of the place in the wide cell; column: coefficient of each power of the place in the narrow one.
    left = np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.25]])[:n, :n]
    right = np.array([[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.5, 0.25]])[:n, :n]
    total = np.zeros((n, n, moments.shape[2] // 2, moments.shape[3] // 2))
    for row, of_y in enumerate((left, right)):
        for column, of_x in enumerate((left, right)):
            total += np.einsum("ac,bd,cdij->abij", of_x, of_y, moments[:, :, row::2, column::2])
    return total


def _finer(nodes: FloatArray) -> FloatArray:
    """The same bilinear function on nodes half as far apart."""
    size = 2 * len(nodes) - 1
    result = np.empty((size, size))
    result[::2, ::2] = nodes
    result[1::2, ::2] = 0.5 * (nodes[1:] + nodes[:-1])
    result[:, 1::2] = 0.5 * (result[:, 2::2] + result[:, :-1:2])
    return result


def _to_nodes(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Sums (s, s) of what the cells give to their nodes at (0, 0), (1, 0), (0, 1), (1, 1) (x, y)."""
    result = np.zeros((a.shape[0] + 1, a.shape[1] + 1))
    result[:-1, :-1] += a
    result[:-1, 1:] += b
    result[1:, :-1] += c
    result[1:, 1:] += d
    return result


def _share(m: FloatArray) -> FloatArray:
    """Sums over points times their bilinear weight, from moments up to xy."""
    return _to_nodes(m[0, 0] - m[1, 0] - m[0, 1] + m[1, 1], m[1, 0] - m[1, 1], m[0, 1] - m[1, 1], m[1, 1])


def _share_squared(m: FloatArray) -> FloatArray:
    """Sums over points times the square of their bilinear weight, from moments up to x^2 y^2."""
    at_0 = m[:, 0] - 2.0 * m[:, 1] + m[:, 2]  # times (1 - y)^2
    return _to_nodes(at_0[0] - 2.0 * at_0[1] + at_0[2], at_0[2], m[0, 2] - 2.0 * m[1, 2] + m[2, 2], m[2, 2])


def _ground(mass: FloatArray, noise: FloatArray | None) -> tuple[FloatArray, FloatArray | None, NDArray[np.bool_]]:
    """Of the nodes: what residuals about them are divided by (0 where there are none), the variance that noise gives to
    their mean, and whether they are no holes."""
    share = _share(mass)
    around = _to_nodes(*([mass[0, 0]] * 4))
    divisor = np.where(around > 0.0, share + _HESITATION * around, 0.0)
    known = (around > 0.0) & (share >= _KNOWN * around)
    if noise is None:
        return divisor, None, known
    there = divisor > 0.0
    variance = np.maximum(_share_squared(noise), 0.0) / np.where(there, divisor, 1.0) ** 2
    return divisor, np.where(there, variance, 0.0), known


def _correction(
    nodes: FloatArray, mass: FloatArray, load: FloatArray, divisor: FloatArray, variance: FloatArray | None
) -> FloatArray:
    """Weighted mean of the residuals about each node, shrunk by what noise there is in it."""
    constant = nodes[:-1, :-1]
    along_x = nodes[:-1, 1:] - constant
    along_y = nodes[1:, :-1] - constant
    along_xy = nodes[1:, 1:] - nodes[1:, :-1] - along_x
    left = np.array(
        [
            [
                load[a, b]
                - constant * mass[a, b]
                - along_x * mass[a + 1, b]
                - along_y * mass[a, b + 1]
                - along_xy * mass[a + 1, b + 1]
                for b in range(2)
            ]
            for a in range(2)
        ]
    )
    there = divisor > 0.0
    step = np.where(there, _share(left) / np.where(there, divisor, 1.0), 0.0)
    if variance is None:
        return step
    power = _about(step**2)
    return np.asarray(step * np.maximum(0.0, 1.0 - _CAUTION * _about(variance) / np.where(power > 0.0, power, 1.0)))


def _about(of: FloatArray) -> FloatArray:
    """Sums over each node and its neighbours with the weights 1 4 6 4 1 along both coordinates."""
    for axis in (0, 1):
        padded = np.pad(of, [(2, 2) if k == axis else (0, 0) for k in range(2)])
        shifted = [np.take(padded, np.arange(k, k + of.shape[axis]), axis) for k in range(5)]
        of = shifted[0] + shifted[4] + 4.0 * (shifted[1] + shifted[3]) + 6.0 * shifted[2]
    return of


def suitable_size(position: FloatArray, half_width: float, most_cells: int) -> int:
    """See _model.pyi."""
    inside = position[np.all(np.abs(position) <= half_width, axis=1)]
    if len(inside) == 0:
        return 2
    bins = int(np.clip(np.sqrt(len(inside) / _POINTS_PER_BIN), 1.0, _MOST_BINS))
    index = np.minimum((inside / half_width + 1.0) * (0.5 * bins), bins - 1).astype(np.int64)
    number = np.sort(np.bincount(index[:, 1] * bins + index[:, 0], minlength=bins * bins))
    usual = number[np.searchsorted(2 * np.cumsum(number), len(inside))]  # half of the points have no more about them
    return int(2 ** np.clip(np.rint(np.log2(bins * np.sqrt(usual))), 0, np.log2(most_cells))) + 1
