"""scene.py: the points of one distribution, sorted once into equal-area cells, and what is fitted of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.model.backend import model
from gonio.model.lobes.gauss import Gauss

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

FINEST_CELL_RAD = np.radians(0.9)
COARSEST_CELL_RAD = np.radians(4.0)
CROWDED = 100  # points of a cell, from which on every n-th stands for all, where they differ little
REACH = 7.0  # standard deviations beyond which a lobe is nothing


@dataclass(frozen=True)
class Nodes:
    """Measured points, or means of cells of points: unit (m, 3), value and its variance, weight [sr], and which of
    four parts each belongs to (a fixed rule, for held-out error)."""

    unit: FloatArray
    value: FloatArray
    variance: FloatArray
    weight: FloatArray
    part: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.value)

    def only(self, where: NDArray[np.bool_] | IndexArray) -> "Nodes":
        """Those of a mask, or of rows."""
        return Nodes(self.unit[where], self.value[where], self.variance[where], self.weight[where], self.part[where])


def some_of(rows: IndexArray, limit: int) -> IndexArray:
    """At most `limit` of them, the same in every run, in their order."""
    if len(rows) <= limit:
        return rows
    return np.sort(np.random.default_rng(0).choice(rows, limit, replace=False))


def _part(index: IndexArray) -> NDArray[np.uint8]:
    """0-3 of whole numbers, scattered by mixing all bits, so that no part is a track, a stripe or an arm of the scan
    (multiplying by the golden ratio would make sectors of points on a Fibonacci spiral)."""
    mixed = np.asarray(index, dtype=np.uint32)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        mixed = (mixed ^ (mixed >> np.uint32(shift))) * np.uint32(factor)
    return np.asarray((mixed ^ (mixed >> np.uint32(16))) >> np.uint32(30), dtype=np.uint8)


class Scene:
    """Points in cells of a square grid over Lambert's disc.

    pitch_rad: distance of the points where they are sparse; size: cells along a side; start (c + 1,): range of each
    occupied cell in the sorted points, of which crowded cells keep some (sorted_cells);
    home (c,): its place in the flattened grid; mean and middle: mean and median of the cells' |DSF|.
    """

    def __init__(self, unit: FloatArray, dsf: FloatArray, variance: FloatArray, solid_angle_sr: FloatArray) -> None:
        good = np.isfinite(dsf) & np.isfinite(variance) & (solid_angle_sr > 0.0)
        if not good.all():
            unit, dsf, variance, solid_angle_sr = unit[good], dsf[good], variance[good], solid_angle_sr[good]
        self.pitch_rad = _sparse_pitch(solid_angle_sr)
        self.cell_rad = float(np.clip(self.pitch_rad, FINEST_CELL_RAD, COARSEST_CELL_RAD))
        # a cell of side h on the disc has a solid angle of 2 h^2
        self.size = 2 * int(np.ceil(np.sqrt(2.0) / self.cell_rad))
        noise = np.ascontiguousarray(np.maximum(variance, 0.0))
        unit, dsf, weight = (np.ascontiguousarray(a) for a in (unit, dsf, solid_angle_sr))
        self.home, self.start, row, self.weight, total = model.sorted_cells(
            unit, dsf, noise, weight, self.size, CROWDED
        )
        self.unit = np.take(unit, row, axis=0)
        self.value = dsf[row]
        self.variance = noise[row]
        self.part = _part(row)
        sums: FloatArray = np.ascontiguousarray(total[:, :3].T)
        self.cell_weight: FloatArray = sums[0]
        self.cell_mean: FloatArray = sums[1] / self.cell_weight
        self.cell_variance: FloatArray = sums[2] / self.cell_weight**2
        self.cell_middle = total[:, 3:] / self.cell_weight[:, None]
        self.cell_unit = self.cell_middle / np.linalg.norm(self.cell_middle, axis=1)[:, None]
        self._means: dict[int, Means] = {}
        self.middle = float(np.median(np.abs(self.cell_mean))) if len(self.home) else 0.0
        self.mean = float(np.sum(self.cell_weight * np.abs(self.cell_mean)) / np.sum(self.cell_weight))

    def cells_near(self, centre: FloatArray, radius: float) -> IndexArray:
        """Occupied cells that may hold points within `radius` [rad] of a unit vector."""
        # the disc is stretched by up to sqrt 2 at the horizon; a mean lies anywhere in its cell
        reach = min(radius + 2.0 * self.cell_rad, np.pi)
        return np.flatnonzero(self.cell_unit @ centre >= np.cos(reach))

    def points_of(self, cells: IndexArray) -> IndexArray:
        """Rows of the sorted points in the cells, cell after cell."""
        counts = self.start[cells + 1] - self.start[cells]
        ends = np.cumsum(counts)
        return np.asarray(
            np.arange(ends[-1] if len(ends) else 0) + np.repeat(self.start[cells] - ends + counts, counts)
        )

    def points_near(self, cells: IndexArray, centre: FloatArray, radius: float, limit: int) -> Nodes:
        """Points of cells within `radius` [rad] of a direction; above `limit`, cells that hold many are thinned and
        what stays stands for all of its cell."""
        rows = self.points_of(cells)
        inside = self.unit[rows] @ centre >= np.cos(min(radius, np.pi))
        counts = np.bincount(np.repeat(np.arange(len(cells)), self.start[cells + 1] - self.start[cells])[inside])
        rows = rows[inside]
        weight = self.weight[rows]
        counts = counts[counts > 0]
        if len(rows) > limit:
            first = np.cumsum(counts) - counts
            every = np.repeat(np.ceil(counts * (len(counts) / limit)).astype(np.int64), counts)
            kept = (np.arange(len(rows)) - np.repeat(first, counts)) % every == 0
            share = np.add.reduceat(weight, first) / np.add.reduceat(weight * kept, first)
            rows, weight = rows[kept], (weight * np.repeat(share, counts))[kept]
        return Nodes(self.unit[rows], self.value[rows], self.variance[rows], weight, self.part[rows])

    def blocks(self, factor: int) -> IndexArray:
        """Number of the block of factor x factor cells (m,) that each occupied cell belongs to."""
        across = -(-self.size // factor)
        return np.asarray((self.home // self.size // factor) * across + self.home % self.size // factor)

    def on_cells(self, lobe: Gauss) -> FloatArray:
        """Mean of a lobe over each occupied cell (c,)."""
        sigma = lobe.sigma
        result = np.zeros(len(self.home))
        cells = self.cells_near(lobe.centre, REACH * float(sigma[1]))
        if not len(cells):
            return result
        if sigma[0] > 4.0 * self.cell_rad:
            result[cells] = lobe.value(self.cell_unit[cells])
            return result
        rows = self.points_of(cells)
        counts = self.start[cells + 1] - self.start[cells]
        total = np.add.reduceat(self.weight[rows] * lobe.value(self.unit[rows]), np.cumsum(counts) - counts)
        result[cells] = total / self.cell_weight[cells]
        return result

    def means(self, factor: int) -> "Means":
        """Means over blocks of factor x factor cells; kept for the next time."""
        if factor not in self._means:
            block = self.blocks(factor)
            weight = _sums(block, self.cell_weight)
            used = np.flatnonzero(weight)
            home = np.searchsorted(used, block)
            share = self.cell_weight / weight[block]
            middle = np.stack([_sums(home, share * self.cell_middle[:, i]) for i in range(3)], axis=1)
            length = np.linalg.norm(middle, axis=1)
            nodes = Nodes(
                middle / length[:, None],
                _sums(home, share * self.cell_mean),
                _sums(home, share**2 * self.cell_variance),
                weight[used],
                _part(used),
            )
            # the mean of unit vectors is shorter than 1 by half of the variance along both axes together
            self._means[factor] = Means(nodes, np.maximum(1.0 - length, 0.0), home, share)
        return self._means[factor]

    def finest_near(self, centre: FloatArray) -> float:
        """Distance of the points in the cells about a direction [rad]; pitch_rad where there is none."""
        cells = self.cells_near(centre, 0.0)
        if not len(cells):
            return self.pitch_rad
        counts = self.start[cells + 1] - self.start[cells]
        return float(np.sqrt(np.min(self.cell_weight[cells] / counts)))


@dataclass(frozen=True)
class Means:
    """Nodes that are means over blocks of cells; spread (b,): variance [rad^2] per axis of the directions in each."""

    nodes: Nodes
    spread: FloatArray
    home: IndexArray  # (c,) node of each cell
    share: FloatArray  # (c,) weight of the cell in it

    def of(self, values: FloatArray) -> FloatArray:
        """Means (b,) of what is known per cell (c,)."""
        return np.asarray(np.bincount(self.home, self.share * values, len(self.spread)))


def _sums(index: IndexArray, values: FloatArray) -> FloatArray:
    return np.asarray(np.bincount(index, values), dtype=np.float64)


def _sparse_pitch(solid_angle_sr: FloatArray) -> float:
    """Root of the solid angle that points hold where half of the hemisphere is [rad]; a subsample tells."""
    some = np.sort(solid_angle_sr[:: max(1, len(solid_angle_sr) // 4096)])
    if not len(some):
        return float(COARSEST_CELL_RAD)
    area = np.cumsum(some)
    return float(np.sqrt(some[np.searchsorted(area, 0.5 * area[-1])]))
