"""energy.py: no incident cell of a tree may send out more light than it receives; what to do where it does."""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Bsdf, MeasuredIntegral
from gonio.formats.tensor.frame import incident_points, turned
from gonio.formats.tensor.leaves import Leaves
from gonio.formats.tensor.square import packed
from gonio.geometry.directions import angles_deg_from_unit
from gonio.units.errors import CheckFailed

FloatArray = NDArray[np.float64]
ROUNDING = 1e-3  # of digits and quadrature
_COVERAGE = 2.0  # k of the uncertainty within which an excess is let pass


def outgoing_sums(leaves: Leaves) -> FloatArray:
    """Directional-hemispherical value of each incident cell of the finest level: (2^k,) half of it unused for T3, or
    (4^k,) in the order of `packed`."""
    tree = leaves.chosen.tree
    split = tree.dimensions - 2
    result = np.zeros((1 << leaves.resolution,) * split)
    for level, rows in leaves.rows():
        index = tree.levels[level].index[rows]
        flat = packed(index[:, :split], level)
        weight = leaves.bsdf_per_sr[level][rows]
        light = np.bincount(flat, weight, minlength=1 << (level * split)).astype(np.float64)
        result += _spread(light.reshape((1 << level,) * split), leaves.resolution - level) * np.pi * 0.25**level
    return result


def rescale(parts: list[Leaves], total: FloatArray) -> float:
    """Scales leaves so that no incident cell's sum exceeds 1; a leaf over several incident cells by the least of their
    factors. The smallest factor."""
    factor = np.minimum(1.0, 1.0 / np.maximum(total, 1e-300))
    for leaves in parts:
        tree = leaves.chosen.tree
        split = tree.dimensions - 2
        for level, rows in leaves.rows():
            pooled = _least(factor, leaves.resolution - level).reshape(-1)
            leaves.bsdf_per_sr[level][rows] *= pooled[packed(tree.levels[level].index[rows][:, :split], level)]
    return float(factor.min())


def check_side(side: str, channel: str, parts: list[Leaves], bsdf: Bsdf, *, rescaled: bool) -> list[str]:
    """Energy of light that arrives at one side, over all components: sentences about an excess that is let pass or was
    scaled away. CheckFailed for an excess beyond its uncertainty unless `rescaled`."""
    total = np.sum([outgoing_sums(leaves) for leaves in parts], axis=0)
    at = int(np.argmax(total))
    largest = float(total.reshape(-1)[at])
    if largest <= 1.0 + ROUNDING:
        return []
    tree = parts[0].chosen.tree
    level, split = tree.resolution, tree.dimensions - 2
    cell = np.array(np.unravel_index(at, total.shape), dtype=np.int64)[None, :split]
    unit = incident_points(cell, level, 1, diagonal=False)[0][0]
    own = turned(unit * [1.0, 1.0, tree.integrator.component.incident_z], tree.integrator.front_faces)
    theta, phi = (float(angle[0]) for angle in angles_deg_from_unit(own))
    where = (
        f"{channel}, light from the {'exterior' if side == 'Front' else 'interior'} at ({theta:.1f}, {phi:.1f}) degrees"
    )
    cells = int(np.count_nonzero(total > 1.0 + ROUNDING))
    if rescaled:
        factor = rescale(parts, total)
        return [f"{where}: {largest:.4f} of the light left; {cells} incident cells scaled, by {factor:.4f} at least."]
    u = largest * _relative_u(bsdf.measured, channel, own[0])
    if largest - 1.0 <= _COVERAGE * u:
        return [f"{where}: {largest:.4f} of the light leaves, an excess within its uncertainty (k = 2, {2 * u:.4f})."]
    raise CheckFailed(
        f"{where}: {largest:.4f} of the light would leave (incident cell {at}, {cells} such), over 1 by more than "
        f"its uncertainty (k = 2: {2 * u:.4f}); check the data or give --rescale"
    )


def _relative_u(measured: tuple[MeasuredIntegral, ...], channel: str, incident: FloatArray) -> float:
    """Relative standard uncertainty of the sum of the measured integrals nearest to a direction (3,); 0 if none."""
    own = [m for m in measured if m.channel == channel and m.value > 0.0]
    if not own:
        return 0.0
    theta = np.radians([m.incident_theta_deg for m in own])
    phi = np.radians([m.incident_phi_deg for m in own])
    unit = np.stack((np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), axis=1)
    cosine = unit @ incident
    near = [m for m, c in zip(own, cosine, strict=True) if c >= cosine.max() - 1e-9]
    return float(np.sqrt(sum(m.u**2 for m in near)) / sum(m.value for m in near))


def _spread(grid: FloatArray, levels: int) -> FloatArray:
    """Each cell's value in all cells of a grid that is finer by `levels`."""
    for axis in range(grid.ndim):
        grid = np.repeat(grid, 1 << levels, axis=axis)
    return grid


def _least(grid: FloatArray, levels: int) -> FloatArray:
    """Least value in each cell of a grid that is coarser by `levels`."""
    for axis in range(grid.ndim):
        shape = list(grid.shape)
        shape[axis : axis + 1] = [shape[axis] >> levels, 1 << levels]
        grid = grid.reshape(shape).min(axis=axis + 1)
    return grid
