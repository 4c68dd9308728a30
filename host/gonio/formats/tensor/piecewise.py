"""piecewise.py: averages of Klems matrices over cells of a tree: both are constant in parts, so overlaps do it.

With the shares s of a cell that lie in each patch (by projected solid angle, counted on a grid of points, then brought
to rows of sum 1 and to the patches' own sizes), a cell's mean is
    B = sum over patches a, b of  s_out(a)  B(a, b)  s_in(b),
and what all outgoing cells of an incident cell send out together is the sum over b of s_in(b) times the hemispherical
value of column b: the mean of the columns that the cell overlaps. Of trees with 3 dimensions s_in are exact shares of
rings, and the mean is over all columns of a ring, each turned back by its azimuth.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.patches import shares
from gonio.formats.tensor.cells import CellSums, ErrorWeight
from gonio.formats.tensor.frame import Component
from gonio.formats.tensor.square import cell_points, distinct
from gonio.formats.window.klems import KlemsBasis
from gonio.formats.window.scattering import KlemsScattering

_ROWS_AT_ONCE = 256
_POINTS_LEVELS = 11
_TURNS = 480  # bins of azimuth; edges of all patches of the standard bases lie on theirs


@dataclass(frozen=True)
class PiecewiseIntegrator:
    """As CellIntegrator, for a Klems file's band."""

    scattering: KlemsScattering
    component: Component
    front_faces: Side
    dimensions: int
    weight: ErrorWeight
    resolution: int

    def sums(self, index: IndexArray, level: int, *, inner: int = 2, outer: int = 2) -> CellSums:
        """See CellIntegrator; the error takes cos at the middle of the outgoing cell. Points are not asked for."""
        del inner, outer
        split = self.dimensions - 2
        rows, row_of = distinct(index[:, :split], level)
        places, place_of = distinct(index[:, split:], level)
        mean, square = np.empty(len(index)), np.empty(len(index))
        order = np.argsort(row_of, kind="stable")
        edges = np.searchsorted(row_of[order], np.arange(0, len(rows) + _ROWS_AT_ONCE, _ROWS_AT_ONCE))
        for number, (start, end) in enumerate(pairwise(edges.tolist())):
            at = order[start:end]
            first = number * _ROWS_AT_ONCE
            lit = self._lit(rows[first : first + _ROWS_AT_ONCE], level)
            for values, result in zip(self._sent(places, level), (mean, square), strict=True):
                result[at] = (values @ lit.T)[place_of[at], row_of[at] - first]
        cos = cell_points(places, level, 1, diagonal=False)[0][place_of, 0, 2]
        w = self.weight(mean * cos, cos) * cos
        return CellSums(mean, w, w * mean, w * square)

    def _lit(self, cells: IndexArray, level: int) -> FloatArray:
        """Shares (k, patches or rings) of incident cells."""
        if self.dimensions == 4:
            own = self._shares[level][(cells[:, 0] << level) + cells[:, 1]].toarray()
            return np.asarray(own / own.sum(axis=1, keepdims=True))  # all of a cell's light, to the last digit
        return shares.of_rings(self._basis, cells[:, 0], level)

    def _sent(self, cells: IndexArray, level: int) -> tuple[FloatArray, FloatArray]:
        """Mean and mean square (n, patches or rings) over outgoing cells, of light from each incident part."""
        place = (cells[:, 0] << level) + cells[:, 1]
        if self.dimensions == 4:
            own = self._shares[level][place]
            return np.asarray(own @ self._values), np.asarray(own @ self._values**2)
        mean, square = self._turned[level]
        return mean[place], square[place]

    @property
    def _basis(self) -> KlemsBasis:
        return self.scattering.window.basis

    @cached_property
    def _values(self) -> FloatArray:
        key = (self.scattering.band, self.component.process, self.component.side)
        return self.scattering.window.matrices[key]

    @cached_property
    def _shares(self) -> list[csr_array]:
        """Per level, share of each cell in each patch."""
        levels = max(_POINTS_LEVELS, self.resolution + 2)
        return shares.of_cells(self._basis, levels, self.resolution)

    @cached_property
    def _turned(self) -> list[tuple[FloatArray, FloatArray]]:
        """Per level, mean and mean square (4^level, rings) of light from each incident ring, turned back."""
        basis, finest = self._basis, self.resolution
        share = shares.of_turned_cells(basis, max(_POINTS_LEVELS, finest + 2), finest, _TURNS)
        profile = np.stack([_profiles(basis, self._values, n).ravel() for n in range(len(basis.rings))], axis=1)
        counted = np.pi * (share @ profile).mean(axis=0)
        hemispherical = basis.projected_solid_angle_sr @ self._values
        kept = np.array([part.mean() for part in np.split(hemispherical, basis.ring_start[1:-1])])
        profile *= np.divide(kept, counted, out=np.ones(len(kept)), where=counted > 0.0)
        found = [(np.asarray(share @ profile), np.asarray(share @ profile**2))]
        for level in range(finest - 1, -1, -1):
            side = 1 << level
            four = [a.reshape(side, 2, side, 2, -1).mean(axis=(1, 3)).reshape(side**2, -1) for a in found[0]]
            found.insert(0, (four[0], four[1]))
        return found


def _profiles(basis: KlemsBasis, values: FloatArray, ring: int) -> FloatArray:
    """Mean (rings, _TURNS), over the columns' azimuths of an incident ring, of what leaves at edges of bins of azimuth
    counted from the column's."""
    middle = (np.arange(_TURNS) + 0.5) * (360.0 / _TURNS)
    nominal = [0.5 * (r.lower_deg + r.upper_deg) for r in basis.rings]
    column = basis.patch_of(nominal[ring], middle)
    later = (np.arange(_TURNS)[:, None] + np.arange(_TURNS)) % _TURNS  # (turn, column's azimuth)
    return np.stack([values[basis.patch_of(polar, middle)[later], column].mean(axis=1) for polar in nominal])
