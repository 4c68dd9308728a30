"""evaluate.py: DSF of a component's model, resolved for incident directions (slices.py), at outgoing directions."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gonio.model.backend import model
from gonio.model.slices import Grids, Slices

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

_NONE = np.zeros(0, dtype=np.int64)
_NO_WEIGHTS = np.zeros(0)
_NO_GRIDS = (np.zeros(0, dtype=np.float32), _NONE, _NONE)


def evaluate(slices: Slices, grids: Grids, unit: FloatArray, which: IndexArray | None = None) -> FloatArray:
    """DSF [1/sr] (m,) towards folded unit vectors (m, 3) in the slices `which` (m,); None: all in the first.

    Lobes end at 8.5 standard deviations, where 2e-16 of the peak is left; what lies beside them (patches) ends with
    its grid. ValueError where an index names no slice, lobe or grid.
    """
    rows = _NONE if which is None else np.ascontiguousarray(which, dtype=np.int64)
    return model.evaluate(
        (slices.scale, slices.lobe_start, slices.field_start),
        (slices.lobe_frame, slices.lobe_whitening, slices.lobe_peak_per_sr, slices.patch_start),
        (slices.patch_grid, slices.patch_weight),
        (slices.field_grid, slices.field_weight, slices.field_matrix, slices.field_shift, slices.field_as_bsdf),
        (grids.values, grids.start, grids.size),
        np.ascontiguousarray(unit, dtype=np.float64),
        rows,
    )


def lobes_at(frame: FloatArray, whitening: FloatArray, peak_per_sr: FloatArray, unit: FloatArray) -> FloatArray:
    """Sum (m,) [1/sr] of lobes (l,) alone towards unit vectors (m, 3); frame, whitening: see Slices."""
    number = len(peak_per_sr)
    return model.evaluate(
        (np.ones(1), np.array([0, number]), np.zeros(2, dtype=np.int64)),
        (frame, whitening, peak_per_sr, np.zeros(number + 1, dtype=np.int64)),
        (_NONE, _NO_WEIGHTS),
        (_NONE, _NO_WEIGHTS, np.zeros((0, 2, 2)), np.zeros((0, 2)), np.zeros(0, dtype=np.bool_)),
        _NO_GRIDS,
        np.ascontiguousarray(unit, dtype=np.float64),
        _NONE,
    )


def near_lobes(
    frame: FloatArray, whitening: FloatArray, unit: FloatArray, reach: float
) -> tuple[list[IndexArray], list[FloatArray]]:
    """Of each lobe the rows (n,) of the unit vectors (m, 3) within `reach` standard deviations along its longer axis,
    and their whitened coordinates (n, 2)."""
    start, row, place = model.near_lobes(np.ascontiguousarray(unit, dtype=np.float64), frame, whitening, reach)
    parts = list(pairwise(start.tolist()))
    return [row[a:b] for a, b in parts], [place[a:b] for a, b in parts]
