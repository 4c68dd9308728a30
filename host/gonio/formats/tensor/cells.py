"""cells.py: mean BSDF of a tree's cells, and how far the DSF inside departs from what a reader of that mean will see.

A reader of the tree takes a cell's value B for BSDF all over it, so its DSF there is B cos(theta_s). The error that a
leaf causes is the integral of weight (DSF - B cos)^2 over its outgoing solid angle and incident cell; with sums W, S1
and S2 it is S2 - 2 B S1 + B^2 W for any B, and sums of children add up to their parent's.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Scattering
from gonio.formats.tensor.frame import Component, incident_on_diagonal, incident_points, turned
from gonio.formats.tensor.square import IndexArray, cell_points, distinct, on_diagonal, packed

FloatArray = NDArray[np.float64]
# Weight of a squared DSF error, from DSF [1/sr] and cos of the outgoing direction.
ErrorWeight = Callable[[FloatArray, FloatArray], FloatArray]
_POINTS_AT_ONCE = 2_000_000


@dataclass
class CellSums:
    """Of n cells: mean BSDF [1/sr], and the sums of the error, per unit of the tree's volume; all (n,)."""

    mean: FloatArray
    w: FloatArray
    s1: FloatArray
    s2: FloatArray

    @staticmethod
    def zeros(n: int) -> "CellSums":
        return CellSums(*(np.zeros(n) for _ in range(4)))

    def put(self, at: IndexArray, other: "CellSums") -> None:
        self.mean[at], self.w[at], self.s1[at], self.s2[at] = other.mean, other.w, other.s1, other.s2

    def joined(self, other: "CellSums") -> "CellSums":
        """Those of `other` behind these."""
        pairs = ((self.mean, other.mean), (self.w, other.w), (self.s1, other.s1), (self.s2, other.s2))
        return CellSums(*(np.concatenate(pair) for pair in pairs))

    def error(self) -> FloatArray:
        """Error of each cell as a leaf."""
        return np.maximum(self.s2 - 2.0 * self.mean * self.s1 + self.mean**2 * self.w, 0.0)

    def spread(self) -> FloatArray:
        """Relative departure (rms) of the DSF inside each cell from the best multiple of cos, between 0 and 1."""
        least = self.s2 - np.divide(self.s1**2, self.w, out=np.zeros_like(self.w), where=self.w > 0.0)
        return np.sqrt(np.divide(np.maximum(least, 0.0), self.s2, out=np.zeros_like(self.s2), where=self.s2 > 0.0))


@dataclass(frozen=True)
class CellIntegrator:
    """Averages a scattering function over cells of one component's tree."""

    scattering: Scattering
    component: Component
    front_faces: Side
    dimensions: int
    weight: ErrorWeight

    def sums(self, index: IndexArray, level: int, *, inner: int = 2, outer: int = 2) -> CellSums:
        """Sums of cells (n, dimensions) of one level; `inner` and `outer` Gauss points per side of the incident and the
        outgoing cell."""
        result = CellSums.zeros(len(index))
        split = self.dimensions - 2
        crossed = 2 * incident_on_diagonal(index[:, :split], level) + on_diagonal(index[:, split:], level)
        for kind in range(4):
            group = np.flatnonzero(crossed == kind)
            if len(group) == 0:
                continue
            # Cells of one incident cell stand together, so that a piece of work has few incident rows.
            key = packed(index[group, :split], level)
            order = np.argsort(key, kind="stable")
            group = group[order]
            points = inner**split * outer**2 * (1 + (kind >> 1)) * (1 + (kind & 1))
            step = max(_POINTS_AT_ONCE // points, 1)
            for start in range(0, len(group), step):
                part = group[start : start + step]
                result.put(part, self._piece(index[part], level, inner, outer, kind))
        return result

    def _piece(self, index: IndexArray, level: int, inner: int, outer: int, kind: int) -> CellSums:
        split = self.dimensions - 2
        n = len(index)
        rows, row_of = distinct(index[:, :split], level)
        incident, weight_in = incident_points(rows, level, inner, diagonal=kind >= 2)
        places, place_of = distinct(index[:, split:], level)
        outgoing, weight_out = cell_points(places, level, outer, diagonal=bool(kind & 1))
        q_in, q_out = incident.shape[1], outgoing.shape[1]
        cos = np.ascontiguousarray(outgoing[:, :, 2])
        incident = turned(incident * [1.0, 1.0, self.component.incident_z], self.front_faces)
        outgoing = turned(outgoing * [1.0, 1.0, self.component.outgoing_z], self.front_faces)
        which = row_of[:, None, None] * q_in + np.arange(q_in)[None, :, None]
        which = np.broadcast_to(which, (n, q_in, q_out)).reshape(-1)
        # All outgoing points of a cell for each of its incident points in turn.
        out = np.broadcast_to(outgoing[place_of][:, None], (n, q_in, q_out, 3)).reshape(-1, 3)
        dsf = self.scattering.dsf_per_sr(incident.reshape(-1, 3), out, which)
        dsf = np.asarray(dsf, dtype=np.float64).reshape(n, q_in, q_out)
        cos_here = cos[place_of][:, None, :]
        w = weight_in[row_of][:, :, None] * weight_out[place_of][:, None, :]
        mean = np.einsum("nij,nij->n", w, dsf)
        w = w * self.weight(mean[:, None, None] * cos_here, cos_here)
        w_cos = w * cos_here
        return CellSums(
            mean,
            np.einsum("nij,nij->n", w_cos, np.broadcast_to(cos_here, w.shape)),
            np.einsum("nij,nij->n", w_cos, dsf),
            np.einsum("nij,nij,nij->n", w, dsf, dsf),
        )
