"""pairs.py: averages over incident and outgoing patches of a sample without rotational symmetry.

Adaptive cubature in four angles: a pair is a part of an incident patch with a part of an outgoing one, evaluated at
Gauss nodes of both. It is halved along those of its axes in which the highest Legendre modes have not died away, so
that only where light peaks incident directions stand close; and, unseen, where a narrow peak that the scattering names
passes and the nodes would be too far apart for it. What is accepted as it is, level by level, are the pairs of a column
with the smallest errors, as long as these stay within half of what the column's tolerance leaves.
"""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.outgoing import Base, BoolArray
from gonio.formats.patches.rules import NODES, gauss, last_modes
from gonio.formats.window.klems import KlemsBasis

_MOST_LEVELS = 10
_POLE_SECTORS = 6  # that a patch all round is divided in
_PAIRS_AT_ONCE = 400
# How wide a part may be, in a peak's standard deviations, that lies within so many of them from its centre.
_WIDEST_WITHIN = ((4.0, 3.3), (8.0, 5.0))
_MOVES = 1.2  # of what the incident direction moves, at most, a peak does
_SHORT = 0.5  # an axis is divided too when its mode is over this share of the largest
# Error of a pair's integral over its last modes: as in outgoing.py, checked against tighter tolerances by
# tests/formats/test_double_averages.py; of fitted models, whose grids have kinks, against plain sums by
# test_patches_fitted.py.
_MODE_SHARE = 0.0003
_INDEX_BITS = 14  # of a part's number along an axis


@dataclass(frozen=True)
class _Pairs:
    """n pairs. base (n, 2): base cell of the incident and of the outgoing part; level, index (n, 4): how often each
    axis was halved, and which of its parts this is. Axes: polar angle and azimuth of the incident part, then those of
    the outgoing one."""

    base: IndexArray
    level: IndexArray
    index: IndexArray

    def __len__(self) -> int:
        return len(self.base)

    def take(self, at: IndexArray | BoolArray) -> "_Pairs":
        return _Pairs(self.base[at], self.level[at], self.index[at])

    def limits(self, base: Base) -> tuple[FloatArray, FloatArray]:
        """Middle and half width [rad] (n, 4) along each axis."""
        low = np.stack((base.polar[:, 0], base.azimuth[:, 0]), axis=1)
        width = np.stack((np.diff(base.polar)[:, 0], np.diff(base.azimuth)[:, 0]), axis=1)
        half = 0.5 * width[self.base].reshape(-1, 4) * 0.5**self.level
        return low[self.base].reshape(-1, 4) + half * (2 * self.index + 1), half

    def box(self) -> IndexArray:
        """One number (n,) per incident part."""
        key = self.base[:, 0]
        for axis in (0, 1):
            key = (((key << 4) | self.level[:, axis]) << _INDEX_BITS) | self.index[:, axis]
        return key

    def halved(self, axes: BoolArray) -> "_Pairs":
        """Each pair's halves along the axes that are marked (n, 4)."""
        own = self
        for axis in range(4):
            marked = axes[:, axis]
            at = np.repeat(np.arange(len(own)), 1 + marked)
            upper = np.append(False, at[1:] == at[:-1])
            own, axes = own.take(at), axes[at]
            own.level[:, axis] += axes[:, axis]
            own.index[:, axis] = own.index[:, axis] * (1 + axes[:, axis]) + upper
        return own


def matrix(
    component: Component, basis: KlemsBasis, tolerance: float, columns: IndexArray
) -> tuple[FloatArray, FloatArray]:
    """B (outgoing, incident) and the estimated error of each column's sum; only `columns` are computed."""
    base, patch = _base(basis)
    lit = np.flatnonzero(np.isin(patch, columns))
    pairs = np.stack(np.meshgrid(lit, np.arange(len(patch)), indexing="ij"), axis=-1).reshape(-1, 2)
    zeros = np.zeros((len(pairs), 4), dtype=np.int64)
    active = _near_peaks_divided(component, _Pairs(pairs, zeros, zeros.copy()), base)
    size = basis.size
    energy = np.zeros(size * size)
    missed = np.zeros(size)
    for level in range(_MOST_LEVELS + 1):
        integral, modes = _integrals(component, active, base)
        column, row = patch[active.base].T
        error = _MODE_SHARE * modes.sum(axis=1)
        whole = energy.reshape(size, size).sum(axis=0) + np.bincount(column, integral, minlength=size)
        allowed = tolerance * np.maximum(whole, 1e-12) - missed
        good = _accepted(column, error, allowed) | (level == _MOST_LEVELS)
        missed += np.bincount(column[good], error[good], minlength=size)
        energy += np.bincount(row[good] * size + column[good], integral[good], minlength=size * size)
        if good.all():
            break
        bad = ~good
        active = active.take(bad).halved(modes[bad] > _SHORT * modes[bad].max(axis=1, keepdims=True))
    each = basis.projected_solid_angle_sr
    return energy.reshape(size, size) / each[:, None] / each, missed / each


def _accepted(column: IndexArray, error: FloatArray, allowed: FloatArray) -> BoolArray:
    """Of every column all pairs if their errors are allowed (columns,), else those of the smallest errors that together
    make half of it."""
    order = np.lexsort((error, column))
    total = np.cumsum(error[order])
    own = column[order]
    first = np.searchsorted(own, np.arange(len(allowed)))
    before = np.append(0.0, total)[first]
    whole = np.bincount(column, error, minlength=len(allowed))
    limit = np.where(whole <= allowed, np.inf, 0.5 * allowed)
    good = np.zeros(len(error), dtype=np.bool_)
    good[order] = total - before[own] <= limit[own]
    return good


def _integrals(component: Component, pairs: _Pairs, base: Base) -> tuple[FloatArray, FloatArray]:
    """Energy (n,) of each pair, and the size (n, 4) of the last Legendre modes along its axes, as energies."""
    key = pairs.box()
    order = np.argsort(key, kind="stable")
    integral, modes = np.empty(len(pairs)), np.empty((len(pairs), 4))
    for start in range(0, len(pairs), _PAIRS_AT_ONCE):
        part = order[start : start + _PAIRS_AT_ONCE]
        integral[part], modes[part] = _piece(component, pairs.take(part), key[part], base)
    return integral, modes


def _piece(component: Component, pairs: _Pairs, key: IndexArray, base: Base) -> tuple[FloatArray, FloatArray]:
    """As _integrals, of pairs whose incident parts (key) stand together."""
    nodes, weight = gauss()
    middle, half = pairs.limits(base)
    angle = middle[:, :, None] + half[:, :, None] * nodes  # (n, 4, NODES)
    _, first, box = np.unique(key, return_index=True, return_inverse=True)
    polar = np.repeat(angle[first, 0], NODES, axis=1)
    azimuth = np.tile(angle[first, 1], (1, NODES))
    incident = component.incident(polar.ravel(), azimuth.ravel())
    polar = np.repeat(angle[:, 2], NODES, axis=1)
    azimuth = np.tile(angle[:, 3], (1, NODES))
    outgoing = component.outgoing(polar.ravel(), azimuth.ravel()).reshape(-1, 1, NODES**2, 3)
    shape = (len(pairs), NODES**2, NODES**2)
    which = np.broadcast_to((box[:, None] * NODES**2 + np.arange(NODES**2))[:, :, None], shape)
    values = component.values(incident, np.broadcast_to(outgoing, (*shape, 3)).reshape(-1, 3), which.reshape(-1))
    values = values.reshape(-1, NODES, NODES, NODES, NODES)
    values *= (np.sin(angle[:, 0]) * np.cos(angle[:, 0]))[:, :, None, None, None]
    values *= np.sin(angle[:, 2])[:, None, None, :, None]
    volume = np.prod(2.0 * half, axis=1)
    integral = volume * np.einsum("nabcd,a,b,c,d->n", values, weight, weight, weight, weight, optimize=True)
    modes = np.stack([_modes(values, axis) for axis in range(4)], axis=1)
    return integral, volume[:, None] * modes


def _modes(values: FloatArray, axis: int) -> FloatArray:
    """Mean size (n,) of the last two Legendre modes along an axis, the last but one counted less."""
    _, weight = gauss()
    share = np.array([0.2, 1.0])
    before, after = NODES**axis, NODES ** (3 - axis)
    found = np.abs(last_modes() @ values.reshape(-1, NODES, after))  # (n before, 2, after)
    others = np.ones(1)
    for _ in range(3):
        others = np.outer(others, weight).ravel()
    found = np.tensordot(share, found, (0, 1)).reshape(-1, before * after)
    return np.asarray(found @ others)


def _near_peaks_divided(component: Component, pairs: _Pairs, base: Base) -> _Pairs:
    """Halved until no part of a pair that a peak passes is wider than _WIDEST_WITHIN says."""
    settled = []
    while len(pairs):
        middle, half = pairs.limits(base)
        _, first, box = np.unique(pairs.box(), return_index=True, return_inverse=True)
        incident = component.incident(middle[first, 0], middle[first, 1])
        centre, sigma, of_box = component.peaks(incident)
        order = np.argsort(of_box, kind="stable")
        centre, sigma = centre[order], sigma[order]
        begin = np.searchsorted(of_box[order], np.arange(len(first) + 1))
        count = np.diff(begin)[box]
        pair = np.repeat(np.arange(len(pairs)), count)
        peak = begin[box][pair] + np.arange(len(pair)) - np.repeat(np.cumsum(count) - count, count)
        across = np.sin(np.minimum(middle[:, [0, 2]] + half[:, [0, 2]], np.pi / 2))
        extent = 2.0 * half * np.stack((np.ones(len(half)), across[:, 0], np.ones(len(half)), across[:, 1]), axis=1)
        chord = np.linalg.norm(component.outgoing(middle[:, 2], middle[:, 3])[pair] - centre[peak], axis=1)
        apart = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
        reach = 0.5 * np.hypot(extent[:, 2], extent[:, 3]) + 0.5 * _MOVES * np.hypot(extent[:, 0], extent[:, 1])
        most = np.full(len(pairs), np.inf)
        for widest, within in _WIDEST_WITHIN:
            near = apart < reach[pair] + within * sigma[peak]
            np.minimum.at(most, pair[near], widest * sigma[peak[near]])
        wide = extent > most[:, None]
        more = wide.any(axis=1)
        settled.append(pairs.take(~more))
        pairs = pairs.take(more).halved(wide[more])
    return _Pairs(*(np.concatenate([getattr(p, name) for p in settled]) for name in ("base", "level", "index")))


def _base(basis: KlemsBasis) -> tuple[Base, IndexArray]:
    """First cells, and the patch that each belongs to."""
    polar, azimuth, patch = [], [], []
    for number, (low, high, start, width) in enumerate(np.radians(basis.bounds_deg).tolist()):
        sectors = _POLE_SECTORS if width > 6.0 else 1
        for k in range(sectors):
            polar.append((low, high))
            azimuth.append((start + width * k / sectors, start + width * (k + 1) / sectors))
            patch.append(number)
    return Base(np.array(polar), np.array(azimuth)), np.array(patch, dtype=np.int64)
