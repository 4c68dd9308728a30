"""flat.py: the text of one tensor tree as arrays, and its values at many places at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.formats.tensor.square import IndexArray
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]
MOST_LEVELS = 24  # a cell is then under a millionth of an axis wide; deeper files are damaged or hostile
_OPEN, _CLOSE, _COMMA = b"{"[0], b"}"[0], b","[0]
_COMMAS_TO_BLANKS = bytes.maketrans(b"{},", b"   ")


@dataclass(frozen=True)
class FlatTree:
    """A tree's nodes (n,), the root first. A branch has its 2^dimensions children from `child` on (-1: no branch); any
    other node is a grid of 2^log2 values per axis from `start` on, last coordinate fastest."""

    dimensions: int
    child: IndexArray
    log2: IndexArray
    start: IndexArray
    values: FloatArray

    def at(self, place: FloatArray) -> FloatArray:
        """Values (m,) at places (m, dimensions) in [0, 1)."""
        return self.values[self.leaf_at(place)[0]]

    def leaf_at(self, place: FloatArray) -> tuple[IndexArray, IndexArray]:
        """Which value (m,) holds at places (m, dimensions) in [0, 1), and the level of its cell (m,)."""
        node = np.zeros(len(place), dtype=np.int64)
        level = np.zeros(len(place), dtype=np.int64)
        left = np.array(place, dtype=np.float64)
        moving = np.flatnonzero(self.child[node] >= 0)
        weight = 1 << np.arange(self.dimensions)
        while len(moving):
            twice = 2.0 * left[moving]
            upper = twice >= 1.0
            left[moving] = twice - upper
            node[moving] = self.child[node[moving]] + upper @ weight
            level[moving] += 1
            moving = moving[self.child[node[moving]] >= 0]
        size = 1 << self.log2[node]
        value = np.zeros(len(place), dtype=np.int64)
        for column in range(self.dimensions):
            value = value * size + np.minimum((left[:, column] * size).astype(np.int64), size - 1)
        return self.start[node] + value, level + self.log2[node]

    @property
    def resolution(self) -> int:
        """Level of the finest cells."""
        level = np.zeros(len(self.child), dtype=np.int64)
        finest = 0
        nodes = np.zeros(1, dtype=np.int64)
        while len(nodes):
            grids = nodes[self.child[nodes] < 0]
            if len(grids):
                finest = max(finest, int((level[grids] + self.log2[grids]).max()))
            branches = nodes[self.child[nodes] >= 0]
            nodes = (self.child[branches][:, None] + np.arange(1 << self.dimensions)).ravel()
            level[nodes] = np.repeat(level[branches] + 1, 1 << self.dimensions)
        return finest


def parse(text: str, dimensions: int, where: str) -> tuple[FlatTree, int]:
    """The tree of a <ScatteringData>, and how many of its values were negative (they are read as 0, as Radiance does).

    Raises UsageError, with `where`, for anything that is not one complete tree of so many dimensions.
    """
    try:
        raw = text.encode("ascii")
    except UnicodeEncodeError as error:
        raise UsageError(f"{where}: holds characters that no tensor tree has") from error
    code = np.frombuffer(raw, dtype=np.uint8)
    brace = np.flatnonzero((code == _OPEN) | (code == _CLOSE))
    opens = code[brace] == _OPEN
    depth = np.cumsum(np.where(opens, 1, -1))
    if len(brace) == 0 or not opens[0] or depth[-1] != 0 or depth.min() < 0 or np.count_nonzero(depth == 0) != 1:
        raise UsageError(f"{where}: braces do not pair up to one tree; is the file cut off?")
    if depth.max() > MOST_LEVELS:
        raise UsageError(f"{where}: deeper than {MOST_LEVELS} levels")
    # A number begins where something stands that is neither blank, comma nor brace, behind something that is.
    solid = (code > ord(" ")) & (code != _COMMA) & (code != _OPEN) & (code != _CLOSE)
    begins = solid.copy()
    begins[1:] &= ~solid[:-1]
    count = np.append(np.cumsum(begins)[brace], np.count_nonzero(begins))
    between = np.diff(count)  # numbers behind each brace
    if count[0] or between[-1]:
        raise UsageError(f"{where}: something stands before or behind the tree")
    innermost = opens & np.append(~opens[1:], False)
    if between[~innermost].any():
        raise UsageError(f"{where}: values and branches are mixed in a node")
    # Nodes by depth, within it by place: a node's children then stand together.
    at = np.flatnonzero(opens)
    order = np.argsort(depth[at], kind="stable")
    at = at[order]
    level = depth[at] - 1
    grid = innermost[at]
    child = np.full(len(at), -1, dtype=np.int64)
    branches = np.flatnonzero(~grid)
    # The first child is the next opening brace, which is the very next brace.
    node_of_brace = np.zeros(len(brace), dtype=np.int64)
    node_of_brace[at] = np.arange(len(at))
    child[branches] = node_of_brace[at[branches] + 1]
    ends = np.append(child[branches], len(at))[1:]
    if not np.array_equal(ends - child[branches], np.full(len(branches), 1 << dimensions)):
        raise UsageError(f"{where}: a branch has not {1 << dimensions} parts")
    held = np.where(grid, between[at], 1)
    log2 = np.round(np.log2(np.maximum(held, 1)) / dimensions).astype(np.int64)
    if np.any(1 << (log2 * dimensions) != held):
        raise UsageError(f"{where}: a node holds a number of values that is no power of {1 << dimensions}")
    if np.any(level + log2 > MOST_LEVELS):
        raise UsageError(f"{where}: deeper than {MOST_LEVELS} levels")
    try:
        values = np.array(raw.translate(_COMMAS_TO_BLANKS).split(), dtype=np.float64)
    except ValueError as error:
        raise UsageError(f"{where}: holds something that is no number ({str(error)[:60]})") from error
    if len(values) != int(count[-1]) or not np.all(np.isfinite(values)):
        raise UsageError(f"{where}: holds values that are not finite")
    negative = int(np.count_nonzero(values < 0.0))
    start = np.where(grid, count[at], 0)
    return FlatTree(dimensions, child, np.where(grid, log2, 0), start, np.maximum(values, 0.0)), negative
