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


def sorted_cells(unit: FloatArray, size: int) -> tuple[IndexArray, IndexArray, IndexArray]:
    """See _model.pyi."""
    disc = unit[:, :2] / np.sqrt(1.0 + unit[:, 2:])
    cell = np.clip((disc + 1.0) * (0.5 * size), 0, size - 1).astype(np.int64)
    key = cell[:, 1] * size + cell[:, 0]
    order = np.argsort(key, kind="stable")
    home, first = np.unique(key[order], return_index=True)
    return order, home, np.append(first, len(key))
