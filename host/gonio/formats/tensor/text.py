"""text.py: a tree as the text of <ScatteringData>: braces and as few characters as its values are worth.

`{v}` is a leaf, `{...}` with braces inside a branch of 2^d nodes in Radiance's order, `{v v ...}` 2^d leaves as a grid
whose last coordinate runs fastest. Numbers have no leading zero. In a file that must be small they have three digits
where the DSF varies within the leaf (rounding, at most 0.5 %, is then small beside it), else four; where matrices were
converted five, for their integrals are kept.
"""

import numpy as np
from numpy.typing import NDArray

from gonio.formats.tensor.grow import GrownTree
from gonio.formats.tensor.leaves import Leaves
from gonio.formats.tensor.piecewise import PiecewiseIntegrator

FloatArray = NDArray[np.float64]
_VARIES = 0.02  # relative rms departure within a leaf from which three digits are enough
_DIGITS = (3, 4, 5)
_TRIED = 4000  # numbers that are written to see how long they are


def numbers(values: FloatArray, digits: int) -> list[str]:
    """Numbers (n,) that are not negative, with so many digits, as short as readers take them."""
    if len(values) == 0:
        return []
    text = f"%.{digits}g\n" * len(values) % tuple(values.tolist())
    text = ("\n" + text).replace("\n0.", "\n.")
    return text.replace("e-0", "e-").replace("e+0", "e").replace("e+", "e").split("\n")[1:-1]


def number_digits(tree: GrownTree, level: int) -> NDArray[np.int64]:
    """Digits (n,) that the value of each cell of a level is worth where the file must be small."""
    varies, even, converted = _DIGITS
    if isinstance(tree.integrator, PiecewiseIntegrator):
        return np.full(len(tree.levels[level].index), converted)
    return np.where(tree.levels[level].sums.spread() > _VARIES, varies, even)


def foreseen_sizes(tree: GrownTree) -> list[FloatArray]:
    """Per level, about how many characters each cell takes as a leaf (n,), with what parts it from the next."""
    sizes = []
    for level, cells in enumerate(tree.levels):
        value = np.maximum(cells.sums.mean, 1e-99)
        digits = number_digits(tree, level)
        exponent = np.floor(np.log10(value))
        longest = np.where(exponent < 0, digits - exponent, digits + (exponent + 1 < digits))
        longest = np.minimum(longest, digits + 4.0)
        # Zeros at the end are not written: how much that saves, a few numbers show.
        some = np.arange(0, len(value), max(len(value) // _TRIED, 1))
        written = 0
        for count in _DIGITS:
            of = some[digits[some] == count]
            written += sum(map(len, numbers(cells.sums.mean[of], count)))
        sizes.append(1.0 + longest * (written / max(float(longest[some].sum()), 1.0)))
    return sizes


def rendered(leaves: Leaves, *, small: bool) -> str:
    """The text of a component's tree; not `small`: with two digits more."""
    chosen = leaves.chosen
    tree = chosen.tree
    order = [int(f"{place:0{tree.dimensions}b}"[::-1], 2) for place in range(1 << tree.dimensions)]
    below: list[str] = []
    below_leaf = np.zeros(0, dtype=np.bool_)
    for level in range(len(tree.levels) - 1, -1, -1):
        here = [""] * len(tree.levels[level].index)
        at = np.flatnonzero(chosen.leaf[level])
        digits = number_digits(tree, level)[at]
        for count in _DIGITS:
            own = at[digits == count]
            texts = numbers(leaves.bsdf_per_sr[level][own], count if small else count + 2)
            for row, text in zip(own.tolist(), texts, strict=True):
                here[row] = text
        at = np.flatnonzero(chosen.split[level])
        if len(at):
            members = tree.members(level, at)
            whole = tree.branches(level) == 1 << tree.dimensions  # not the root of T3
            grids = below_leaf[members].all(axis=1) & whole
            ordered = members[grids][:, order] if whole else members[:0]
            for row, children in zip(at[grids].tolist(), ordered.tolist(), strict=True):
                here[row] = "{" + " ".join([below[child] for child in children]) + "}"
            for row, children in zip(at[~grids].tolist(), members[~grids].tolist(), strict=True):
                parts = ["{" + below[child] + "}" if below_leaf[child] else below[child] for child in children]
                if not whole:  # the half that is not used
                    parts = [text for part in parts for text in (part, "{0}")]
                here[row] = "{" + "".join(parts) + "}"
        below, below_leaf = here, chosen.leaf[level]
    return "{" + below[0] + "}" if below_leaf[0] else below[0]
