"""of_tree.py: a tensor tree's leaves averaged over pairs of Klems patches, its integrals kept.

A leaf is constant in BSDF, and cells of the square are equal in projected solid angle. Which part of a cell lies in
which patch is counted on a grid of points, so that the parts of a cell add up to all of it.
"""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.sparse import csr_array, diags_array

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.patches import shares, turned
from gonio.formats.tensor.flat import FlatTree
from gonio.formats.window.klems import KlemsBasis

_LEAST_POINTS = 11  # levels of the grid of points
_POINTS_IN_CELL = 2  # levels of it within a cell of the finest level
Factor = Callable[[FloatArray], FloatArray]  # of a leaf's value, by its place (n, dimensions)


def matrix(tree: FlatTree, basis: KlemsBasis, factor: Factor | None = None) -> FloatArray:
    """BSDF [1/sr] (outgoing, incident) of a tree's component. `factor` multiplies leaves by a value at their centre."""
    leaves = list(leaves_of(tree))
    if factor is not None:
        leaves = [
            (level, index, np.asarray(value * factor(np.asarray((index + 0.5) * 0.5**level))))
            for level, index, value in leaves
        ]
    if tree.dimensions == 4:
        return _of_four(leaves, basis)
    return _of_three(leaves, basis)


def leaves_of(tree: FlatTree) -> Iterator[tuple[int, IndexArray, FloatArray]]:
    """Level, cell (n, dimensions) on that level's grid, and value (n,) of all leaves."""
    dims = tree.dimensions
    nodes = np.zeros(1, dtype=np.int64)
    corner = np.zeros((1, dims), dtype=np.int64)
    steps = (np.arange(1 << dims)[:, None] >> np.arange(dims)) & 1
    depth = 0
    while len(nodes):
        grid = tree.child[nodes] < 0
        for log2 in np.unique(tree.log2[nodes[grid]]).tolist():
            at = np.flatnonzero(grid & (tree.log2[nodes] == log2))
            inner = np.stack(np.unravel_index(np.arange(1 << (dims * log2)), (1 << log2,) * dims), axis=1)
            index = ((corner[at] << log2)[:, None, :] + inner).reshape(-1, dims)
            value = tree.values[tree.start[nodes[at]][:, None] + np.arange(len(inner))]
            yield depth + log2, index, value.ravel()
        branch = np.flatnonzero(~grid)
        corner = ((corner[branch] << 1)[:, None, :] + steps).reshape(-1, dims)
        nodes = (tree.child[nodes[branch]][:, None] + np.arange(1 << dims)).ravel()
        depth += 1


def _of_four(leaves: list[tuple[int, IndexArray, FloatArray]], basis: KlemsBasis) -> FloatArray:
    levels, finest = _point_levels(leaves)
    share = shares.of_cells(basis, levels, finest)
    energy = np.zeros((basis.size, basis.size))
    for level, index, value in leaves:
        cells = 1 << (2 * level)
        incident, outgoing = ((index[:, k] << level) + index[:, k + 1] for k in (0, 2))
        held = csr_array((value, (outgoing, incident)), shape=(cells, cells))
        whole = diags_array(1.0 / share[level].sum(axis=1)) @ share[level]  # all of a leaf's light finds a patch
        energy += (whole.T @ held @ share[level]).toarray() * (np.pi / cells) ** 2
    return np.asarray(energy / basis.projected_solid_angle_sr[:, None] / basis.projected_solid_angle_sr)


def _of_three(leaves: list[tuple[int, IndexArray, FloatArray]], basis: KlemsBasis) -> FloatArray:
    """The outgoing direction's azimuth counts from the column's, as in turned.py."""
    levels, finest = _point_levels(leaves)
    rings = len(basis.rings)
    limits = np.sin(np.radians([[r.lower_deg, r.upper_deg] for r in basis.rings])) ** 2
    images = np.zeros((rings, 1 << (2 * finest)))  # energy of each incident ring's light, by outgoing cell
    for level, index, value in leaves:
        outgoing = (index[:, 1] << level) + index[:, 2]
        edges = np.maximum(1.0 - 2.0 * np.stack((index[:, 0] + 1, index[:, 0]), axis=1) * 0.5**level, 0.0) ** 2
        order = shares.cell_of_points(finest, level)
        for ring in range(rings):
            shared = np.minimum(edges[:, 1], limits[ring, 1]) - np.maximum(edges[:, 0], limits[ring, 0])
            light = value * np.maximum(shared, 0.0) / 2.0
            images[ring] += np.bincount(outgoing, light, minlength=1 << (2 * level))[order]
    place, offset = _bins_of_points(basis, levels)
    cell = shares.cell_of_points(levels, finest)
    moments = np.zeros((rings, rings * turned.BINS, 2))
    for ring in range(rings):
        of_points = images[ring][cell]
        moments[ring, :, 0] = np.bincount(place, of_points, minlength=rings * turned.BINS)
        moments[ring, :, 1] = np.bincount(place, of_points * offset, minlength=rings * turned.BINS)
    return turned.assembled(basis, (moments * (np.pi * 0.25**levels)).reshape(rings, rings, turned.BINS, 2))


def _point_levels(leaves: list[tuple[int, IndexArray, FloatArray]]) -> tuple[int, int]:
    """Levels of the grid of points, and of the finest leaves."""
    finest = max(level for level, _, _ in leaves)
    return max(_LEAST_POINTS, finest + _POINTS_IN_CELL), finest


def _bins_of_points(basis: KlemsBasis, levels: int) -> tuple[IndexArray, FloatArray]:
    """Bin of turned.py, ring by ring, and azimuth from the bin's middle [rad], of all points."""
    ring, azimuth = shares.rings_of_points(basis, levels)
    wide = 2.0 * np.pi / turned.BINS
    number = np.minimum((azimuth / wide).astype(np.int64), turned.BINS - 1)
    place = ring * turned.BINS + number
    return place, azimuth - (number + 0.5) * wide
