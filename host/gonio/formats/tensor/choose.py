"""choose.py: which leaves of a grown tree are worth their place: the least error for a number of leaves or bytes.

For a price per added leaf, one pass from the finest level up finds the tree whose error plus price is least: a cell
stays split where what its splits save, over all of its subtree, is more than they cost. That is the tree a priority
queue ends with that always takes the splits with the largest fall of error per added leaf, whole subtrees looked at
together (the pruning of Breiman, Friedman, Olshen and Stone, "Classification and regression trees", 1984, chapter 3).
The price is found by bisection.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.formats.tensor.grow import GrownTree
from gonio.formats.tensor.square import IndexArray

FloatArray = NDArray[np.float64]
_PRICE_STEP = 0.002  # of the price's logarithm to base 2, at which the bisection ends
_PRICE_RANGE = 80.0


@dataclass(frozen=True)
class ChosenTree:
    """Per level of a grown tree: which cells are split (n,), which are leaves (n,); those below a leaf are neither."""

    tree: GrownTree
    split: tuple[NDArray[np.bool_], ...]
    leaf: tuple[NDArray[np.bool_], ...]

    @property
    def leaves(self) -> int:
        return int(sum(np.count_nonzero(leaf) for leaf in self.leaf))

    def rows(self) -> list[tuple[int, IndexArray]]:
        """Level and rows of the leaves, level by level."""
        return [(level, np.flatnonzero(leaf)) for level, leaf in enumerate(self.leaf) if leaf.any()]


class Offered:
    """A grown tree whose leaves are for sale: errors, what stays split in any case, and the size of each leaf."""

    def __init__(self, tree: GrownTree, sizes: list[FloatArray] | None = None) -> None:
        """`sizes` per level (n,), of each cell as a leaf; None: leaves are counted."""
        self.tree = tree
        self.sizes = sizes
        self.error = [tree.errors(level) for level in range(len(tree.levels))]
        self.at = [np.flatnonzero(level.child >= 0) for level in tree.levels]
        self.members = [tree.members(level, at) for level, at in enumerate(self.at)]
        self.kept = [
            np.isin(at, tree.forced.kept_among(cells.index, level))
            for level, (at, cells) in enumerate(zip(self.at, tree.levels, strict=True))
        ]

    def at_price(self, price: float) -> list[NDArray[np.bool_]]:
        """Per level, which of the cells that can be split are, where an added leaf costs so much error."""
        keeps: list[NDArray[np.bool_]] = []
        net = np.zeros(len(self.error[-1]))
        for level in range(len(self.error) - 1, -1, -1):
            at, members = self.at[level], self.members[level]
            here = np.zeros(len(self.error[level]))
            kept = self.kept[level]
            if len(at):
                below = net - self.error[level + 1]
                saved = self.error[level][at] - price * (members.shape[1] - 1) + below[members].sum(axis=1)
                kept = (saved > 0.0) | kept
                here[at] = np.where(kept, saved, 0.0)
            net = here
            keeps.append(kept)
        return keeps[::-1]

    def chosen(self, keeps: list[NDArray[np.bool_]]) -> ChosenTree:
        """The tree whose splits are `keeps`, as far as they are reached from the root."""
        split, leaf = [], []
        reached = np.ones(1, dtype=np.bool_)
        for level, keep in enumerate(keeps):
            own = np.zeros(len(reached), dtype=np.bool_)
            own[self.at[level][keep]] = True
            own &= reached
            split.append(own)
            leaf.append(reached & ~own)
            if level + 1 < len(keeps):
                reached = np.zeros(len(self.error[level + 1]), dtype=np.bool_)
                reached[self.members[level][own[self.at[level]]].ravel()] = True
        return ChosenTree(self.tree, tuple(split), tuple(leaf))

    def size(self, chosen: ChosenTree) -> float:
        """Leaves, or their sizes, with what braces take (text.py)."""
        if self.sizes is None:
            return float(chosen.leaves)
        total = 0.0
        for level, (leaf, split) in enumerate(zip(chosen.leaf, chosen.split, strict=True)):
            total += float(self.sizes[level][leaf].sum()) + 2.0 * np.count_nonzero(split)
            at = split[self.at[level]]
            if at.any():
                alone = chosen.leaf[level + 1][self.members[level][at]]
                grid = alone.all(axis=1)
                total += float(np.count_nonzero(alone[~grid])) - np.count_nonzero(grid)
        return total


def choose(offered: list[Offered], most: float) -> list[ChosenTree]:
    """The best trees, at one price for all, whose size is at most `most`; the smallest there are if none is."""

    def at(price: float) -> list[ChosenTree]:
        return [offer.chosen(offer.at_price(price)) for offer in offered]

    def size(trees: list[ChosenTree]) -> float:
        return sum(offer.size(tree) for offer, tree in zip(offered, trees, strict=True))

    best = at(0.0)
    if size(best) <= most:
        return best
    largest = max(float(error.max(initial=0.0)) for offer in offered for error in offer.error)
    high = float(np.log2(max(largest, 1e-300))) + 2.0
    low = high - _PRICE_RANGE
    best = at(2.0**high)
    while high - low > _PRICE_STEP:
        middle = 0.5 * (low + high)
        tried = at(2.0**middle)
        if size(tried) <= most:
            high, best = middle, tried
        else:
            low = middle
    return best
