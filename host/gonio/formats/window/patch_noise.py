"""patch_noise.py: the independent variance of weighted sums over bins, exact where a point's cell lies in several."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class PatchNoise:
    """Standard deviations of what points add to the bins of (rings, bins).

    Points in small cells add to one bin each, so their variances add up there: `small_variance` (rings, bins). Divided
    cells add to several bins together: `cells` (points, rings * coarse bins) holds weight times standard deviation; a
    coarse bin is an equal share of `bins // coarse bins` bins.
    """

    small_variance: FloatArray
    cells: csr_array
    per_row: int  # coarse bins of a ring

    @cached_property
    def _by_ring(self) -> list[csr_array]:
        """For each ring the cells that reach into it, shape (points there, coarse bins)."""
        columns = self.cells.tocsc()
        parts = []
        for ring in range(len(self.small_variance)):
            part = columns[:, ring * self.per_row : (ring + 1) * self.per_row].tocsr()
            parts.append(part[np.flatnonzero(np.diff(part.indptr))])
        return parts

    def variance_of(self, ring: int, seen: FloatArray) -> FloatArray:
        """Variance of sums over a ring's bins with weights `seen` (sums, bins), shape (sums,)."""
        of_cells = self._by_ring[ring] @ self._coarse(seen).T
        return np.asarray(seen**2 @ self.small_variance[ring] + np.einsum("ij,ij->j", of_cells, of_cells))

    def total_variance(self, weight: FloatArray) -> float:
        """Variance of one sum over all bins with weights (rings, bins)."""
        of_cells = self.cells @ self._coarse(weight).ravel()
        return float(np.sum(weight**2 * self.small_variance) + of_cells @ of_cells)

    def _coarse(self, weight: FloatArray) -> FloatArray:
        return np.asarray(weight.reshape(len(weight), self.per_row, -1).mean(axis=2), dtype=np.float64)


def of_cells(
    small_variance: FloatArray,
    coarse_bin: NDArray[np.int64],
    point: NDArray[np.int64],
    deviation: FloatArray,
    *,
    rings: int,
    per_row: int,
) -> PatchNoise:
    """Noise of points that add `deviation` (k,) to bins `coarse_bin` (k,); what one `point` adds to one bin is summed.

    Points without noise are left out.
    """
    noisy = deviation > 0.0
    _, row = np.unique(point[noisy], return_inverse=True)
    shape = (int(row.max()) + 1 if len(row) else 0, rings * per_row)
    return PatchNoise(small_variance, csr_array((deviation[noisy], (row, coarse_bin[noisy])), shape=shape), per_row)


def joined(parts: list[PatchNoise], factor: float) -> PatchNoise:
    """Noise of `factor` times the sum of what different points add."""
    variance = np.sum([part.small_variance for part in parts], axis=0) * factor**2
    return PatchNoise(variance, vstack([part.cells for part in parts], format="csr") * factor, parts[0].per_row)
