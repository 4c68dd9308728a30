"""near.py: points within lobes, and in cells, by numpy: what _model.near_lobes and sorted_cells do."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


def near_lobes(
    unit: FloatArray, frame: FloatArray, whitening: FloatArray, reach: float
) -> tuple[IndexArray, IndexArray, FloatArray]:
    """See _model.pyi."""
    if len(frame) != len(whitening):
        raise ValueError("one frame and whitening per lobe are needed")
    start, rows, places = [0], [np.zeros(0, dtype=np.int64)], [np.zeros((0, 2))]
    for axes, w in zip(frame, whitening, strict=True):
        angle = reach / np.linalg.svd(w, compute_uv=False)[1]
        row = np.flatnonzero(unit @ axes[2] >= (np.cos(angle) if angle < np.pi else -2.0))
        local = unit[row] @ axes.T
        across = np.hypot(local[:, 0], local[:, 1])
        # At the antipode all azimuths meet: one of them.
        opposite = (local[:, 2] < 0.0) & (across < 1e-9)
        local[opposite, 0] = across[opposite] = 1e-9
        stretch = np.where(across > 0.0, np.arctan2(across, local[:, 2]) / np.maximum(across, 1e-300), 1.0)
        start.append(start[-1] + len(row))
        rows.append(row)
        places.append((local[:, :2] * stretch[:, None]) @ w.T)
    return np.array(start, dtype=np.int64), np.concatenate(rows), np.concatenate(places)


def sorted_cells(
    unit: FloatArray, value: FloatArray, variance: FloatArray, weight: FloatArray, size: int, most: int
) -> tuple[IndexArray, IndexArray, IndexArray, FloatArray, FloatArray]:
    """See _model.pyi."""
    if not len(value) == len(variance) == len(weight) == len(unit):
        raise ValueError("one value, variance and weight per point is needed")
    if len(unit) == 0:
        none = np.zeros(0, dtype=np.int64)
        return none, np.zeros(1, dtype=np.int64), none, np.zeros(0), np.zeros((0, 6))
    disc = unit[:, :2] / np.sqrt(1.0 + unit[:, 2:])
    cell = np.clip((disc + 1.0) * (0.5 * size), 0, size - 1).astype(np.int64)
    key = cell[:, 1] * size + cell[:, 0]
    row = np.argsort(key, kind="stable")
    home, first, count = np.unique(key[row], return_index=True, return_counts=True)
    v, noise, w = value[row], variance[row], weight[row]
    total, load, square, mean_noise = np.add.reduceat(np.stack((w, w * v, w * v * v, w * noise)), first, axis=1)
    calm = square - load**2 / total <= 0.64 * load**2 / total + 2.0 * mean_noise
    every = np.where((count > most) & calm, -(-count // most), 1)
    kept = (np.arange(len(row)) - np.repeat(first, count)) % np.repeat(every, count) == 0
    share = np.where(every > 1, total / np.add.reduceat(w * kept, first), 1.0)
    stay = np.add.reduceat(kept.astype(np.int64), first)
    start = np.concatenate(([0], np.cumsum(stay)))
    row, v, noise, w = row[kept], v[kept], noise[kept], w[kept] * np.repeat(share, stay)
    columns = np.stack((w, w * v, w * w * noise, *(w[:, None] * unit[row]).T), axis=1)
    return home, start, row, w, np.add.reduceat(columns, start[:-1])
