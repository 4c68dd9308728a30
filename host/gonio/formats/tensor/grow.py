"""grow.py: a tensor tree grown from the top: only cells that matter are evaluated, memory grows with the leaves.

From a full base level on, level by level, those cells are split whose error per added leaf exceeds a threshold. The
threshold is foreseen from the cells at hand: an error falls by 2^(d + 2) per level while the number of cells grows by
2^d. A little more is grown than asked for; choose.py then takes the best part of it.

A narrow peak could fall between the points of a large cell: directions of forced.py are followed down from the root.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.formats.tensor.cells import CellIntegrator, CellSums
from gonio.formats.tensor.forced import Forced, no_forced
from gonio.formats.tensor.piecewise import PiecewiseIntegrator
from gonio.formats.tensor.square import IndexArray

FloatArray = NDArray[np.float64]
OVERGROWN = 1.2  # leaves grown per leaf asked for
_SWEEPS = 3
_CHILD_SHARE = 1.0 / 8.0  # of a cell's quadrature error, in its children: 1/16, and as much again for safety
_DIM = 0.05  # of its parent's mean, below which a child's relative error does not matter
_BASE = {3: 5, 4: 4}  # level down to which everything is evaluated


@dataclass
class Level:
    """Cells of one level: their numbers (n, dimensions), where the children of each begin in the next level (-1: it has
    none), their sums, and the relative error that their mean is suspected of (NaN: nothing is known)."""

    index: IndexArray
    child: IndexArray
    sums: CellSums
    doubt: FloatArray


@dataclass
class GrownTree:
    """One component's tree. Children stand in Radiance's order of branches: bit i of their number is the half along
    coordinate i. The unused half of T3 is not held: its root has 4 children."""

    integrator: CellIntegrator | PiecewiseIntegrator
    resolution: int
    forced: Forced = field(default_factory=no_forced)
    levels: list[Level] = field(default_factory=list)

    @property
    def dimensions(self) -> int:
        return self.integrator.dimensions

    def branches(self, level: int) -> int:
        """Children of a cell of this level."""
        return 4 if self.dimensions == 3 and level == 0 else 1 << self.dimensions

    def members(self, level: int, at: IndexArray) -> IndexArray:
        """Rows (n, branches) in the next level of the children of the cells `at`, which are split."""
        return np.asarray(self.levels[level].child[at][:, None] + np.arange(self.branches(level)))

    def errors(self, level: int) -> FloatArray:
        """Error (n,) of each cell of a level as a leaf."""
        return self.levels[level].sums.error() * 2.0 ** (-level * self.dimensions)

    def leaves(self) -> int:
        return int(sum(np.count_nonzero(level.child < 0) for level in self.levels))

    def split(self, level: int, at: IndexArray) -> None:
        """Gives the cells `at` of a level their children and evaluates those."""
        index = self._children_of(level, at)
        self._append(level, at, index, self.integrator.sums(index, level + 1))

    def plant(self) -> None:
        """The root, and all cells down to the base level, with sums; then what must be followed further down."""
        root = np.zeros((1, self.dimensions), dtype=np.int64)
        self.levels = [Level(root, np.full(1, -1, dtype=np.int64), CellSums.zeros(1), np.full(1, np.nan))]
        base = min(self.resolution, _BASE[self.dimensions])
        for level in range(base):
            at = np.arange(len(self.levels[level].index))
            index = self._children_of(level, at)
            sums = self.integrator.sums(index, level + 1) if level + 1 == base else CellSums.zeros(len(index))
            self._append(level, at, index, sums)
        for level in range(base, self.resolution):
            if level >= len(self.levels):
                break
            at = self.forced.among(self.levels[level].index, level)
            if len(at):
                self.split(level, at)
        self.add_up()

    def add_up(self) -> None:
        """Sums of split cells from their children; means by projected solid angle.

        By how much a cell's own mean was off says how good its children's are: the error of two Gauss points falls with
        the fourth power of a cell's width.
        """
        for level in range(len(self.levels) - 2, -1, -1):
            here, below = self.levels[level].sums, self.levels[level + 1]
            at = np.flatnonzero(self.levels[level].child >= 0)
            if len(at) == 0:
                continue
            members = self.members(level, at)
            share = self.incident_share(below.index[members], level + 1)
            mean = np.sum(share * below.sums.mean[members], axis=1) / share.sum(axis=1)
            if level >= min(self.resolution, _BASE[self.dimensions]):
                fresh = np.isnan(below.doubt[members[:, 0]])
                off = np.abs(here.mean[at] - mean)[fresh, None] * _CHILD_SHARE
                least = np.maximum(below.sums.mean[members[fresh]], _DIM * mean[fresh, None])
                below.doubt[members[fresh]] = off / np.maximum(least, 1e-300)
            here.mean[at] = mean
            for mine, theirs in ((here.w, below.sums.w), (here.s1, below.sums.s1), (here.s2, below.sums.s2)):
                mine[at] = theirs[members].sum(axis=1) / (1 << self.dimensions)

    def incident_share(self, index: IndexArray, level: int) -> FloatArray:
        """Share of the incident hemisphere's projected solid angle of cells (..., dimensions)."""
        if self.dimensions == 4:
            return np.full(index.shape[:-1], 0.25**level)
        if level == 0:
            return np.ones(index.shape[:-1])
        # The ring between two values of sin(theta_i): the difference of their squares.
        return np.asarray(4.0 * ((1 << level) - 1.0 - 2.0 * index[..., 0]) * 0.25**level)

    def _children_of(self, level: int, at: IndexArray) -> IndexArray:
        """Numbers (n * branches, dimensions) of the cells that the cells `at` fall into."""
        bits = np.arange(1 << self.dimensions)[:, None] >> np.arange(self.dimensions) & 1
        if self.branches(level) == 4:
            bits = bits[bits[:, 0] == 0]
        return np.asarray((2 * self.levels[level].index[at][:, None, :] + bits).reshape(-1, self.dimensions))

    def _append(self, level: int, at: IndexArray, index: IndexArray, sums: CellSums) -> None:
        new = Level(index, np.full(len(index), -1, dtype=np.int64), sums, np.full(len(index), np.nan))
        start = 0
        if level + 1 < len(self.levels):
            old = self.levels[level + 1]
            start = len(old.index)
            new = Level(
                np.concatenate((old.index, index)),
                np.concatenate((old.child, new.child)),
                old.sums.joined(sums),
                np.concatenate((old.doubt, new.doubt)),
            )
            self.levels[level + 1] = new
        else:
            self.levels.append(new)
        self.levels[level].child[at] = start + self.branches(level) * np.arange(len(at))


def grow(trees: list[GrownTree], leaves: int) -> None:
    """Grows planted trees together until they have some more leaves than `leaves`, where the error is largest."""
    for _ in range(_SWEEPS):
        for level in range(max(tree.resolution for tree in trees)):
            threshold = _foreseen_threshold(trees, OVERGROWN * leaves)
            for tree in trees:
                if level >= min(tree.resolution, len(tree.levels)):
                    continue
                at = np.flatnonzero((tree.levels[level].child < 0) & (tree.errors(level) > threshold))
                if len(at):
                    tree.split(level, at)
        if sum(tree.leaves() for tree in trees) >= leaves:
            break
    for tree in trees:
        tree.add_up()


def _foreseen_threshold(trees: list[GrownTree], leaves: float) -> float:
    """Error above which cells are to be split, so that there will be about so many leaves."""
    d = trees[0].dimensions
    error, depth = [], []
    for tree in trees:
        for level, cells in enumerate(tree.levels):
            own = tree.errors(level)[cells.child < 0]
            error.append(own)
            depth.append(np.full(len(own), tree.resolution - level))
    log_error = np.log2(np.maximum(np.concatenate(error), 1e-300))
    most = np.concatenate(depth)

    def count(log_threshold: float) -> float:
        splits = np.clip(np.ceil((log_error - log_threshold) / (d + 2)), 0, most)
        return float(np.sum(2.0 ** (d * splits)))

    low, high = -990.0, float(log_error.max()) + 1.0
    if count(low) <= leaves:
        return 0.0
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if count(middle) > leaves else (low, middle)
    return float(2.0**high)
