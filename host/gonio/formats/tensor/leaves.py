"""leaves.py: the leaves of a chosen tree with their final values and where these come from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Origin
from gonio.formats.tensor.choose import ChosenTree
from gonio.formats.tensor.frame import incident_points, turned
from gonio.formats.tensor.narrow import narrow_means
from gonio.formats.tensor.square import IndexArray, cell_points, distinct

FloatArray = NDArray[np.float64]
_DOUBT = 1e-3  # relative error of a mean that is suspected, from which it is formed anew from more points
_UNEVEN = 0.02  # relative rms departure of the DSF within a cell of which nothing is known
_SETTLED = 3e-3  # relative change from one number of points to the next; what is left is far smaller
_POINTS = (3, 5, 8, 13)  # Gauss points per side of a cell, one after the other
_MOST_POINTS = {3: 13, 4: 8}


@dataclass
class Leaves:
    """Leaves of one component's tree. Arrays per level, as the tree's rows; only rows of leaves are meant."""

    chosen: ChosenTree
    bsdf_per_sr: list[FloatArray]

    def rows(self) -> list[tuple[int, IndexArray]]:
        """See ChosenTree."""
        return self.chosen.rows()

    @property
    def resolution(self) -> int:
        return self.chosen.tree.resolution


def averaged(chosen: ChosenTree) -> Leaves:
    """Leaves with their exact averages: those in doubt are formed anew from more and more points until they stand."""
    tree = chosen.tree
    values = [level.sums.mean.copy() for level in tree.levels]
    for level, rows in chosen.rows():
        cells = tree.levels[level]
        if level == 0:
            continue
        doubt = cells.doubt[rows]
        doubtful = np.where(np.isnan(doubt), cells.sums.spread()[rows] > _UNEVEN, doubt > _DOUBT)
        left = rows[doubtful]
        for points in _POINTS:
            if len(left) == 0 or points > _MOST_POINTS[tree.dimensions]:
                break
            mean = tree.integrator.sums(cells.index[left], level, inner=points, outer=points).mean
            change = np.abs(mean - values[level][left])
            values[level][left] = mean
            left = left[change > _SETTLED * np.abs(mean)]
        # Where a peak is narrower than the cell, points that agree may all have missed it.
        at = rows[tree.forced.among(cells.index[rows], level)]
        at = np.union1d(at, left)
        if len(at):
            values[level][at] = narrow_means(tree.integrator, cells.index[at], level)
    return Leaves(chosen, values)


def negatives_to_zero(leaves: Leaves) -> float:
    """Puts negative values to 0; the hemispherical reflectance or transmittance that this adds, averaged over incident
    directions."""
    added = 0.0
    for level, rows in leaves.rows():
        values = leaves.bsdf_per_sr[level]
        below = rows[values[rows] < 0.0]
        added -= float(values[below].sum()) * np.pi * 2.0 ** (-level * leaves.chosen.tree.dimensions)
        values[below] = 0.0
    return added * (2.0 if leaves.chosen.tree.dimensions == 3 else 1.0)


def origins(leaves: Leaves) -> list[NDArray[np.uint8]]:
    """Origin (n,) of each leaf's value, taken at its middle; per entry of `leaves.rows()`."""
    tree = leaves.chosen.tree
    own = tree.integrator
    split = tree.dimensions - 2
    result = []
    for level, rows in leaves.rows():
        if level == 0:
            result.append(np.full(len(rows), Origin.INTERPOLATED, dtype=np.uint8))
            continue
        index = tree.levels[level].index[rows]
        cells, which = distinct(index[:, :split], level)
        incident = incident_points(cells, level, 1, diagonal=False)[0][:, 0]
        places, place = distinct(index[:, split:], level)
        outgoing = cell_points(places, level, 1, diagonal=False)[0][:, 0]
        incident = turned(incident * [1.0, 1.0, own.component.incident_z], own.front_faces)
        outgoing = turned(outgoing * [1.0, 1.0, own.component.outgoing_z], own.front_faces)
        result.append(own.scattering.origin(incident, outgoing[place], which))
    return result
