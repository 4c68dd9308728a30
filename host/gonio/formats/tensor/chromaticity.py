"""chromaticity.py: u' and v' beside a tree of Y: u' = 4 X / (X + 15 Y + 3 Z), v' = 9 Y / (X + 15 Y + 3 Z) (CIE 15)."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Scattering
from gonio.formats.tensor.choose import ChosenTree
from gonio.formats.tensor.leaves import Leaves

FloatArray = NDArray[np.float64]
_ALIKE = 0.002  # difference of u' or v' below which cells are one: half of what an eye can tell apart
_WHITE = (4.0 / 19.0, 9.0 / 19.0)  # of equal energy, where there is no light


def chromaticity(y: Leaves, x: Scattering, z: Scattering) -> tuple[Leaves, Leaves]:
    """Trees of u' and v' of a component, from its tree of Y and the scattering functions of X and Z."""
    tree = y.chosen.tree
    own = tree.integrator
    u, v, light = ([np.zeros(len(level.index)) for level in tree.levels] for _ in range(3))
    for level, rows in y.rows():
        # All three from the same points, so that their ratios are right where their values are not quite. The root is
        # asked for at the next level: no cell that is averaged may hold the centre of the square.
        at = max(level, 1)
        index = tree.levels[at].index[rows if level else np.arange(len(tree.levels[1].index))]
        means = [replace(own, scattering=s).sums(index, at).mean for s in (x, own.scattering, z)]  # type: ignore[arg-type]
        mean_x, luminous, mean_z = means if level else [np.array([mean.mean()]) for mean in means]
        total = mean_x + 15.0 * luminous + 3.0 * mean_z
        dark = total <= 0.0
        safe = np.where(dark, 1.0, total)
        u[level][rows] = np.where(dark, _WHITE[0], 4.0 * mean_x / safe)
        v[level][rows] = np.where(dark, _WHITE[1], 9.0 * luminous / safe)
        light[level][rows] = np.maximum(total, 0.0)
    return _merged(y.chosen, u, light), _merged(y.chosen, v, light)


def _merged(chosen: ChosenTree, values: list[FloatArray], light: list[FloatArray]) -> Leaves:
    """Cells whose leaves are alike become leaves, with the mean that the light in them gives."""
    tree = chosen.tree
    split = [part.copy() for part in chosen.split]
    leaf = [part.copy() for part in chosen.leaf]
    low, high = [v.copy() for v in values], [v.copy() for v in values]
    light = [part.copy() for part in light]
    for level in range(len(tree.levels) - 2, -1, -1):
        at = np.flatnonzero(split[level])
        if len(at) == 0:
            continue
        members = tree.members(level, at)
        low[level][at] = low[level + 1][members].min(axis=1)
        high[level][at] = high[level + 1][members].max(axis=1)
        weight = light[level + 1][members]
        total = weight.sum(axis=1)
        light[level][at] = total / members.shape[1]
        weight = np.where(total[:, None] > 0.0, weight, 1.0)
        values[level][at] = np.sum(weight * values[level + 1][members], axis=1) / weight.sum(axis=1)
        alike = leaf[level + 1][members].all(axis=1) & (high[level][at] - low[level][at] < _ALIKE)
        split[level][at[alike]] = False
        leaf[level][at[alike]] = True
        leaf[level + 1][members[alike].ravel()] = False
    return Leaves(ChosenTree(tree, tuple(split), tuple(leaf)), values)
