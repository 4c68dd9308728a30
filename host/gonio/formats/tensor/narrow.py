"""narrow.py: averages over cells that are wider than a peak in them: every incident direction's peaks are followed.

Gauss points in all coordinates at once would have to be closer than the peak is wide. Here a leaf has some incident
directions, and for each of these its outgoing cell is divided again and again where that direction's own peaks lie, so
that the light of each is kept whatever its width.
"""

import numpy as np
from numpy.typing import NDArray

from gonio.formats.tensor.cells import CellIntegrator
from gonio.formats.tensor.forced import peak_places
from gonio.formats.tensor.frame import incident_on_diagonal, incident_points, turned
from gonio.formats.tensor.piecewise import PiecewiseIntegrator
from gonio.formats.tensor.square import IndexArray, cell_points, distinct, on_diagonal, packed

FloatArray = NDArray[np.float64]
_INCIDENT_POINTS = {3: 12, 4: 4}  # Gauss points per side of the incident cell
_OUTGOING_POINTS = 3
_FINEST_LEVEL = 15
_UNITS_AT_ONCE = 200_000


def narrow_means(integrator: CellIntegrator | PiecewiseIntegrator, index: IndexArray, level: int) -> FloatArray:
    """Mean BSDF (n,) of cells (n, dimensions) of one level."""
    split = integrator.dimensions - 2
    result = np.zeros(len(index))
    crossed = incident_on_diagonal(index[:, :split], level)
    rows_each = _INCIDENT_POINTS[integrator.dimensions] ** split
    for diagonal in (False, True):
        group = np.flatnonzero(crossed == diagonal)
        step = max(_UNITS_AT_ONCE // (rows_each * (1 + diagonal)), 1)
        for start in range(0, len(group), step):
            part = group[start : start + step]
            result[part] = _piece(integrator, index[part], level, diagonal)
    return result


def _piece(
    integrator: CellIntegrator | PiecewiseIntegrator, index: IndexArray, level: int, diagonal: bool
) -> FloatArray:
    split, component = integrator.dimensions - 2, integrator.component
    key = packed(index[:, :split], level)
    _, first, of = np.unique(key, return_index=True, return_inverse=True)
    points = _INCIDENT_POINTS[integrator.dimensions]
    incident, weight = incident_points(index[first, :split], level, points, diagonal=diagonal)
    count = incident.shape[1]
    rows = incident.reshape(-1, 3) * [1.0, 1.0, component.incident_z]
    place, row_of_place, wanted = peak_places(
        integrator.scattering, rows, component, integrator.front_faces, integrator.dimensions
    )
    place = place[:, split:]
    # A unit is one incident direction and a part of one leaf's outgoing cell.
    leaf = np.repeat(np.arange(len(index)), count)
    row = (of[:, None] * count + np.arange(count)).ravel()
    share = weight[of].ravel()
    cell = index[leaf][:, split:]
    result = np.zeros(len(index))
    for fine in range(level, _FINEST_LEVEL + 1):
        near = (wanted > fine) & (fine < _FINEST_LEVEL)
        marked = np.unique((row_of_place[near] << 2 * fine) | packed(_cells(place[near], fine), fine))
        looked = np.isin((row << 2 * fine) | packed(cell, fine), marked)
        done = ~looked
        means = _unit_means(integrator, rows, row[done], cell[done], fine)
        result += np.bincount(leaf[done], share[done] * means, minlength=len(index))
        if not looked.any():
            break
        halves = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
        cell = (2 * cell[looked][:, None, :] + halves).reshape(-1, 2)
        leaf, row, share = (np.repeat(part[looked], 4) for part in (leaf, row, 0.25 * share))
    return result


def _cells(place: FloatArray, level: int) -> IndexArray:
    return np.asarray(np.floor(place * (1 << level)).astype(np.int64))


def _unit_means(
    integrator: CellIntegrator | PiecewiseIntegrator, rows: FloatArray, row: IndexArray, cell: IndexArray, level: int
) -> FloatArray:
    """Mean BSDF (n,) over outgoing cells (n, 2) for one incident direction each."""
    incident = turned(rows, integrator.front_faces)
    result = np.zeros(len(row))
    crossed = on_diagonal(cell, level)
    for diagonal in (False, True):
        group = np.flatnonzero(crossed == diagonal)
        for start in range(0, len(group), _UNITS_AT_ONCE):
            part = group[start : start + _UNITS_AT_ONCE]
            own, which_cell = distinct(cell[part], level)  # of few cells, each for many incident directions
            points, weight = cell_points(own, level, _OUTGOING_POINTS, diagonal=diagonal)
            count = points.shape[1]
            outgoing = turned(points * [1.0, 1.0, integrator.component.outgoing_z], integrator.front_faces)
            outgoing, weight = outgoing[which_cell], weight[which_cell]
            present, which = np.unique(row[part], return_inverse=True)
            dsf = integrator.scattering.dsf_per_sr(
                incident[present], outgoing.reshape(-1, 3), np.repeat(which, count).astype(np.int64)
            )
            result[part] = np.sum(weight * np.reshape(dsf, weight.shape), axis=1)
    return result
