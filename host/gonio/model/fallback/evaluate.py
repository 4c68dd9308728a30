"""evaluate.py: DSF of resolved models by numpy: what _model.evaluate does."""

import numpy as np
from numpy.typing import NDArray

from gonio.model.slices import LEAST_COSINE, PATCH_HALF_WIDTH

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

LOBE_REACH = 8.5  # standard deviations
_AT_ONCE = 100_000  # directions


def evaluate(
    slices: tuple[FloatArray, IndexArray, IndexArray],
    lobes: tuple[FloatArray, FloatArray, FloatArray, IndexArray],
    patches: tuple[IndexArray, FloatArray],
    fields: tuple[IndexArray, FloatArray, FloatArray, FloatArray, NDArray[np.bool_]],
    grids: tuple[NDArray[np.float32], IndexArray, IndexArray],
    unit: FloatArray,
    which: IndexArray,
) -> FloatArray:
    """See _model.pyi."""
    scale, lobe_start, field_start = slices
    if len(which) not in (0, len(unit)):
        raise ValueError("one slice per direction is needed")
    _check(slices, lobes, patches, fields, grids)
    if len(unit) and len(scale) == 0:
        raise ValueError("there is no slice")
    if len(which) and (which.min() < 0 or which.max() >= len(scale)):
        raise ValueError("no such slice")
    result = np.zeros(len(unit))
    is_unit = np.abs(np.sum(unit**2, axis=1) - 1.0) < 1e-6
    unit = np.where(is_unit[:, None], unit, np.array([0.0, 0.0, 1.0]))
    for first in range(0, len(unit), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        towards = unit[part]
        row = which[part] if len(which) else np.zeros(len(towards), dtype=np.int64)
        total = _lobes(lobe_start, lobes, patches, grids, towards, row)
        total += _fields(field_start, fields, grids, towards, row)
        result[part] = scale[row] * np.maximum(total, 0.0)
    return np.where(is_unit, result, np.nan)


def _check(
    slices: tuple[FloatArray, IndexArray, IndexArray],
    lobes: tuple[FloatArray, FloatArray, FloatArray, IndexArray],
    patches: tuple[IndexArray, FloatArray],
    fields: tuple[IndexArray, FloatArray, FloatArray, FloatArray, NDArray[np.bool_]],
    grids: tuple[NDArray[np.float32], IndexArray, IndexArray],
) -> None:
    """ValueError where sizes or indices do not agree."""
    values, start, size = grids
    if len(start) != len(size) or np.any(size < 2) or np.any(start < 0) or np.any(start + size**2 > len(values)):
        raise ValueError("a grid does not lie within the values")
    for own in (lobes[:3], patches, fields):
        if len({len(one) for one in own}) > 1:
            raise ValueError("a column is as long as the others of its kind")
    rows = ((slices[1], slices[0], lobes[2]), (lobes[3], lobes[2], patches[1]), (slices[2], slices[0], fields[1]))
    for first, row, item in rows:
        if len(first) != len(row) + 1 or first[0] != 0 or first[-1] != len(item) or np.any(np.diff(first) < 0):
            raise ValueError("first items of the slices or lobes do not fit")
    for grid in (patches[0], fields[0]):
        if np.any((grid < 0) | (grid >= len(size))):
            raise ValueError("there is no such grid")


def _spread(start: IndexArray, row: IndexArray) -> tuple[IndexArray, IndexArray]:
    """For items start[r]:start[r + 1] of each row (m,): which of the m asks, and the item; each (sum of numbers,)."""
    number = start[row + 1] - start[row]
    asks = np.repeat(np.arange(len(row)), number)
    item = np.arange(len(asks)) - np.repeat(np.cumsum(number) - number, number) + start[row][asks]
    return asks, item


def _lobes(
    lobe_start: IndexArray,
    lobes: tuple[FloatArray, FloatArray, FloatArray, IndexArray],
    patches: tuple[IndexArray, FloatArray],
    grids: tuple[NDArray[np.float32], IndexArray, IndexArray],
    unit: FloatArray,
    row: IndexArray,
) -> FloatArray:
    frame, whitening, peak, patch_start = lobes
    asks, lobe = _spread(lobe_start, row)
    # A lobe ends where the angle from its centre exceeds its reach along its longer axis.
    longest = LOBE_REACH / np.linalg.svd(whitening, compute_uv=False)[:, 1]
    end = np.cos(np.minimum(longest, np.pi)) - 1e-12
    near = np.einsum("ni,ni->n", frame[lobe, 2], unit[asks]) >= end[lobe]
    asks, lobe = asks[near], lobe[near]
    local = np.einsum("nij,nj->ni", frame[lobe], unit[asks])
    across = np.hypot(local[:, 0], local[:, 1])
    # At the antipode all azimuths meet: one of them.
    opposite = (local[:, 2] < 0.0) & (across < 1e-9)
    local[opposite, 0] = across[opposite] = 1e-9
    angle = np.arctan2(across, local[:, 2])
    stretch = np.where(across > 0.0, angle / np.maximum(across, 1e-300), 1.0)
    v = np.einsum("nij,nj->ni", whitening[lobe], local[:, :2] * stretch[:, None])
    r2 = np.sum(v**2, axis=1)
    value = np.where(r2 <= LOBE_REACH**2, peak[lobe] * np.exp(-0.5 * r2), 0.0)
    total = np.bincount(asks, value, len(unit)).astype(np.float64)  # of nothing: integers

    patch_grid, patch_weight = patches
    inside = np.max(np.abs(v), axis=1, initial=0.0) <= PATCH_HALF_WIDTH
    asks, lobe, v = asks[inside], lobe[inside], v[inside]
    pair, patch = _spread(patch_start, lobe)
    beside = patch_weight[patch] * _read(grids, patch_grid[patch], v[pair] / PATCH_HALF_WIDTH)
    return np.asarray(total + np.bincount(asks[pair], beside, len(unit)))


def _fields(
    field_start: IndexArray,
    fields: tuple[IndexArray, FloatArray, FloatArray, FloatArray, NDArray[np.bool_]],
    grids: tuple[NDArray[np.float32], IndexArray, IndexArray],
    unit: FloatArray,
    row: IndexArray,
) -> FloatArray:
    grid, weight, matrix, shift, as_bsdf = fields
    asks, item = _spread(field_start, row)
    across = np.einsum("nij,nj->ni", matrix[item], unit[asks, :2]) + shift[item]
    r2 = np.sum(across**2, axis=1)
    shifted = np.any(shift != 0.0, axis=1)[item]
    beyond = shifted & (r2 > 1.0)
    across[beyond] /= np.sqrt(r2[beyond])[:, None]
    z = np.where(shifted, np.sqrt(np.maximum(1.0 - r2, 0.0)), unit[asks, 2])
    value = weight[item] * _read(grids, grid[item], across / np.sqrt(1.0 + z)[:, None])
    value *= np.where(as_bsdf[item], unit[asks, 2] / np.maximum(z, LEAST_COSINE), 1.0)
    return np.asarray(np.bincount(asks, value, len(unit)), dtype=np.float64)


def _read(grids: tuple[NDArray[np.float32], IndexArray, IndexArray], grid: IndexArray, at: FloatArray) -> FloatArray:
    """Bilinear values (n,) of the grids (n,) at coordinates (n, 2) in [-1, 1]."""
    values, start, size = grids
    cells = (size[grid] - 1).astype(np.float64)
    x = np.clip((at[:, 0] + 1.0) * (0.5 * cells), 0.0, cells)
    y = np.clip((at[:, 1] + 1.0) * (0.5 * cells), 0.0, cells)
    j = np.minimum(x, cells - 1.0).astype(np.int64)
    i = np.minimum(y, cells - 1.0).astype(np.int64)
    x -= j
    y -= i
    corner = start[grid] + i * size[grid] + j
    up = size[grid]
    below = values[corner] * (1.0 - x) + values[corner + 1] * x
    above = values[corner + up] * (1.0 - x) + values[corner + up + 1] * x
    return np.asarray(below * (1.0 - y) + above * y, dtype=np.float64)
