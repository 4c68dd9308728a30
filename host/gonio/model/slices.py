"""slices.py: a component's model resolved for given incident directions: sums of terms that one loop can evaluate.

DSF = scale max(0, sum of lobes + sum of what is left beside them, on grids that move with the lobes + backgrounds).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

PATCH_HALF_WIDTH = 4.0  # of the grids beside lobes, in standard deviations of the lobe


@dataclass(frozen=True)
class Grids:
    """Square grids, interpolated bilinearly. Grid g has size[g] x size[g] nodes that span [-h, h]^2, h = 1 for
    backgrounds (Lambert's equal-area disc) and PATCH_HALF_WIDTH for patches; node (i, j), row i along the second
    coordinate, is values[start[g] + i * size[g] + j]."""

    values: NDArray[np.float32]
    start: IndexArray  # (g,)
    size: IndexArray  # (g,)

    @staticmethod
    def of(arrays: list[FloatArray]) -> "Grids":
        """From square arrays."""
        sizes = np.array([len(a) for a in arrays], dtype=np.int64)
        start = np.concatenate(([0], np.cumsum(sizes**2)))[:-1].astype(np.int64)
        flat = [np.asarray(a, dtype=np.float32).ravel() for a in arrays]
        return Grids(np.concatenate(flat) if flat else np.zeros(0, dtype=np.float32), start, sizes)


@dataclass(frozen=True)
class Slices:
    """k incident directions of one component (folded frame, hemisphere.py). Everything in float64 and int64.

    Lobes of slice s are lobe_start[s]:lobe_start[s + 1]; patches of lobe l are patch_start[l]:patch_start[l + 1];
    backgrounds of slice s are field_start[s]:field_start[s + 1].
    """

    scale: FloatArray  # (k,)
    lobe_start: IndexArray  # (k + 1,)
    lobe_frame: FloatArray  # (l, 3, 3) rows e1, e2, centre
    lobe_whitening: FloatArray  # (l, 2, 2): v = W u has unit covariance; the lobe is peak exp(-|v|^2 / 2)
    lobe_peak_per_sr: FloatArray  # (l,)
    patch_start: IndexArray  # (l + 1,)
    patch_grid: IndexArray  # (p,) its value at v is added with
    patch_weight: FloatArray  # (p,)
    field_start: IndexArray  # (k + 1,)
    field_grid: IndexArray  # (f,)
    field_weight: FloatArray  # (f,)
    # The outgoing direction's (x, y) is multiplied by this (2, 2) (a turn, perhaps a mirror image) and shifted: the
    # grid is read there. A shift out of the unit circle reads at its rim. (f, 2, 2), (f, 2)
    field_matrix: FloatArray
    field_shift: FloatArray
    # True: the grid's DSF is carried over as BSDF, times cos of the outgoing direction over cos where it is read
    # (this one not below LEAST_COSINE). (f,)
    field_as_bsdf: NDArray[np.bool_]


LEAST_COSINE = 0.05
