"""shares.py: which part of a tree's cells lies in which patch, counted on a grid of points that is finer than both."""

from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array, diags_array

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.tensor.square import disc_from_square
from gonio.formats.window.klems import KlemsBasis

_BALANCINGS = 100  # rounds that bring rows and columns of the shares to their sums


@lru_cache(maxsize=2)
def of_cells(basis: KlemsBasis, levels: int, finest: int) -> list[csr_array]:
    """Shares (4^level, patches) of the cells of every level to the finest. Rows have the sum 1, columns that of the
    patches' own sizes; what the counting missed is spread over the cells at a patch's border."""
    polar, azimuth = polar_azimuth(levels)
    patch = basis.patch_of(np.degrees(polar), np.degrees(azimuth))
    share = balanced(counted(patch, levels, finest, basis.size), basis)
    found = [share]
    for level in range(finest - 1, -1, -1):
        found.insert(0, coarser(found[0], level))
    return found


@lru_cache(maxsize=2)
def of_turned_cells(basis: KlemsBasis, levels: int, finest: int, turns: int) -> csr_array:
    """Weights (4^finest, rings turns) that average over the cells of a level what is known at edges of equal bins of
    azimuth in every ring, and linear in between."""
    ring, azimuth = rings_of_points(basis, levels)
    bins = azimuth * (turns / (2.0 * np.pi))
    low = np.floor(bins).astype(np.int64)
    upper = (bins - low) * 0.25 ** (levels - finest)
    lower = 0.25 ** (levels - finest) - upper
    wide = len(basis.rings) * turns
    cell = cell_of_points(levels, finest) * wide + ring * turns
    key, of = np.unique(np.concatenate((cell + low % turns, cell + (low + 1) % turns)), return_inverse=True)
    weight = np.bincount(of, np.concatenate((lower, upper)))
    return csr_array((weight, (key // wide, key % wide)), shape=(1 << (2 * finest), wide))


def of_rings(basis: KlemsBasis, cell: IndexArray, level: int) -> FloatArray:
    """Shares (n, rings) of incident cells (n,) of a tree of 3 dimensions, by sin cos d(theta): exact."""
    limits = np.sin(np.radians([[r.lower_deg, r.upper_deg] for r in basis.rings])) ** 2
    outer, inner = (np.maximum(1.0 - 2.0 * (cell + k) * 0.5**level, 0.0) ** 2 for k in (0, 1))
    shared = np.minimum(outer[:, None], limits[:, 1]) - np.maximum(inner[:, None], limits[:, 0])
    return np.asarray(np.maximum(shared, 0.0) / np.maximum(outer - inner, 1e-300)[:, None])


def balanced(share: csr_array, basis: KlemsBasis) -> csr_array:
    """Shares (cells, patches) scaled to the sums that `of_cells` names; columns last, so that these are exact, rows
    to some 1e-3 for a few cells."""
    wanted = basis.projected_solid_angle_sr / np.pi * share.shape[0]
    for _ in range(_BALANCINGS):
        share = diags_array(1.0 / share.sum(axis=1)) @ share
        share = share @ diags_array(wanted / share.sum(axis=0))
    return csr_array(share)


def polar_azimuth(levels: int) -> tuple[FloatArray, FloatArray]:
    """Of all points (4^levels,) [rad], in the order of their cells."""
    side = (np.arange(1 << levels) + 0.5) * 0.5**levels
    xy = disc_from_square(np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2))
    return np.arcsin(np.minimum(np.hypot(xy[:, 0], xy[:, 1]), 1.0)), np.arctan2(xy[:, 1], xy[:, 0])


@lru_cache(maxsize=1)
def rings_of_points(basis: KlemsBasis, levels: int) -> tuple[IndexArray, FloatArray]:
    """Ring and azimuth, 0 to 2 pi, of all points."""
    polar, azimuth = polar_azimuth(levels)
    return basis.ring_of(np.degrees(polar)), azimuth % (2.0 * np.pi)


def cell_of_points(levels: int, level: int) -> IndexArray:
    """Cell of a level's grid that each point lies in."""
    side = np.arange(1 << levels) >> (levels - level)
    return np.asarray(((side[:, None] << level) + side).ravel())


def counted(patch: IndexArray, levels: int, level: int, patches: int) -> csr_array:
    """Share of each cell of a level that lies in each patch, (4^level, patches)."""
    key, count = np.unique(cell_of_points(levels, level) * patches + patch, return_counts=True)
    share = count * 0.25 ** (levels - level)
    return csr_array((share, (key // patches, key % patches)), shape=(1 << (2 * level), patches))


def coarser(share: csr_array, level: int) -> csr_array:
    """Shares of the cells of a level, from those of the next finer one."""
    children = 1 << (2 * level + 2)
    parent = cell_of_points(level + 1, level)
    mean = csr_array((np.full(children, 0.25), (parent, np.arange(children))), shape=(children >> 2, children))
    return csr_array(mean @ share)
