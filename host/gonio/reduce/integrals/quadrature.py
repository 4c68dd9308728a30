"""quadrature.py: weights of the points in a sum that stands for an integral, and what their finite number costs.

With V the sum over Voronoi cells and P1 the integral of linear interpolation over the Delaunay triangles, the leading
error of P1 is twice that of V: on a spiral of pitch p, of a function f that is f0 at the spiral's start, V is pi p^2 f0
/ 12 too high and P1 twice that (Euler and Maclaurin, in r f(r) across the turns). So 2 V - P1 has neither, and |V - P1|
is the size of what was removed: an upper limit of what is left.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain
from gonio.reduce.integrals.results import weighted_sum

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# What 2 V - P1 leaves of a single peak, over the square of the relative |V - P1|: the next terms of the series give 2
# for a Gaussian; trials about the start of a spiral, and with the flat tops of beams, give up to 8.
_NEXT_TERM = 8.0


@dataclass(frozen=True)
class Weights:
    """Weights (n,) of a hemisphere's points: cells [sr], 0 at masked points, and the correction V - P1 per unit of DSF,
    which adds up to 0: of a constant neither sum is wrong."""

    cell_sr: FloatArray
    correction_sr: FloatArray
    corrected: bool  # whether there are triangles to correct with

    @property
    def corrected_sr(self) -> FloatArray:
        """Weights of 2 V - P1."""
        return self.cell_sr + self.correction_sr

    def within(self, share: FloatArray, edge: BoolArray) -> "Weights":
        """Of a part of the hemisphere: the share (n,) of each cell that counts; `edge` (n,): points along its border.

        Cells and triangles end differently at a border, so the correction of a part would see the DSF itself there and
        not its curvature. It is taken of the DSF less its mean along the edge, or left out where there is none.
        """
        cell, correction = share * self.cell_sr, share * self.correction_sr
        along = np.where(edge, self.cell_sr, 0.0)
        if not along.any():
            return Weights(cell, np.zeros(len(cell)), False)
        return Weights(cell, correction - correction.sum() * along / along.sum(), self.corrected)


def side_weights(
    distribution: Distribution, unit: FloatArray, side: BoolArray, projected_sr: FloatArray | None = None
) -> Weights:
    """Of the points (n,) of one hemisphere; `unit` (n, 3) their directions.

    With the cells' projected solid angles (n,), the integral of cos theta over each, V is the sum of the BSDF times
    those: exact for a constant BSDF however large the cells, and wherever in its cell a point lies.

    Around masked points V and P1 lack different areas. There the measured neighbour stands in: each masked point's part
    of the correction goes to the nearest measured point, so that a constant stays uncorrected, and a smooth DSF nearly.
    """
    measured = side & distribution.measured
    cell = np.where(measured, distribution.solid_angle_sr, 0.0)
    constant = np.ones(len(cell))  # the DSF of which V is exact
    if projected_sr is not None:
        # At the horizon a point's own cosine says nothing of its cell: a quarter of the cell's mean bounds it.
        mean = np.divide(projected_sr, cell, out=np.ones(len(cell)), where=cell > 0.0)
        constant = np.maximum(np.abs(unit[:, 2]), 0.25 * mean)
        cell = np.where(cell > 0.0, projected_sr / constant, 0.0)
    linear = distribution.linear_solid_angle_sr
    if len(linear) != len(cell) or not measured.any():
        return Weights(cell, np.zeros(len(cell)), False)
    correction = np.where(side, distribution.solid_angle_sr - linear, 0.0)
    masked = np.flatnonzero(side & ~measured & (correction != 0.0))
    if len(masked):
        own = np.flatnonzero(measured)
        neighbour = own[cKDTree(unit[own], balanced_tree=False).query(unit[masked])[1]]
        np.add.at(correction, neighbour, correction[masked])
        correction[masked] = 0.0
    # What is left at the outer border, where cells and triangles end differently, is no curvature either.
    total = float(cell @ constant)
    if total > 0.0:
        correction -= float(correction @ constant) * cell / total
    return Weights(cell, correction, True)


def integral(distribution: Distribution, weights: Weights) -> Uncertain:
    """2 V - P1 with all its uncertainty, `quadrature` included."""
    result = weighted_sum(distribution, weights.corrected_sr)
    return result.with_effect("quadrature", left_u(distribution, weights)) if weights.corrected else result


def left_u(distribution: Distribution, weights: Weights) -> float:
    """Standard uncertainty of 2 V - P1 from the number of points: |V - P1| less what is noise in it."""
    used = np.flatnonzero(distribution.measured & (weights.correction_sr != 0.0))
    w = weights.correction_sr[used]
    removed = float(w @ distribution.dsf_per_sr[used])
    noise2 = float(w**2 @ distribution.variance_per_sr2[used])
    return float(np.sqrt(max(removed**2 - noise2, 0.0)))


def left_of_peak_u(integral: float, removed: float, noise: float) -> float:
    """As left_u for a single peak that lies whole within the points: `removed` V - P1, `noise` its standard deviation.
    There the ratio of removed to integral is the series' own small number, and its square what comes next."""
    size = float(np.sqrt(max(removed**2 - noise**2, 0.0)))
    if integral == 0.0:
        return size
    return min(size, _NEXT_TERM * size**2 / abs(integral))
