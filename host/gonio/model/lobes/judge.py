"""judge.py: whether a fitted lobe is worth having."""

import numpy as np
from numpy.typing import NDArray

from gonio.model.lobes.found import BROADEST_RAD, LEAST_SEEN, Found, View
from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.least_squares import Fit, peak_errors, trust

FloatArray = NDArray[np.float64]

PEAK_ERROR = 0.2  # relative standard error of a peak: 1 in 5, significant by any rule
FEWEST_NODES = 8  # that see more than a tenth of the peak
FEWEST_CIRCULAR = 5  # of a circular lobe
LEAST_CONTRAST = 0.1  # of a narrow lobe's peak to what else is there
CONTRAST_OF_BROADEST = 0.15  # more for a lobe of BROADEST_RAD, less in proportion
GOOD_ENOUGH = 0.06  # error over trust, both squared: half a percent of the level. No lobe is worth having for less
PROVISIONAL = 1.25  # of BROADEST_RAD: a lobe may look too broad as long as its neighbour is not known
LONGEST = 7.0  # ratio of standard deviations: what is longer is a streak, of which lobes are only pieces
UNLIKE = 0.3  # mean square of what is left over that of the lobes: 0.23 of a top hat, more of pieces of a streak
TOP_SEEN = 0.8  # of the peak: points that see less must lie round about the lobe
LARGEST_GAP_RAD = 3.5  # about such a lobe without a point that sees as much: tracks on either side will do
LEAST_LEVEL = 0.01  # of the mean over a lobe, of all that is there, that its peak must reach
BENEFIT = 0.75  # held-out error, with over without, that a lobe has to come below


def _height(lobe: Gauss, unit: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * lobe.whitened(unit)[1]))


def _seen(lobe: Gauss, unit: FloatArray, height: FloatArray) -> bool:
    """Whether points tell of a lobe's top: near it, or half of it and as well from the other side. A flank on one side
    may be anything."""
    top = float(height.max(initial=0.0))
    if top >= TOP_SEEN:
        return True
    v = lobe.whitened(unit[height > 0.75 * top])[0]
    turn = np.sort(np.arctan2(v[1], v[0]))
    gaps = np.diff(turn, append=turn[:1] + 2.0 * np.pi)
    return top >= LEAST_SEEN and float(gaps.max(initial=0.0)) < LARGEST_GAP_RAD


def sound(view: View, fit: Fit, new: int) -> bool:
    """Whether all lobes of a fit are: not too broad, certain of their peak, seen by enough nodes, the top not in a gap
    of the data, not lost in the ground; and the first `new` show what is there, not some part of a streak."""
    for place, lobe in enumerate(fit.lobes):
        height = _height(lobe, view.nodes.unit)
        least = FEWEST_CIRCULAR if lobe.circular else FEWEST_NODES
        if np.count_nonzero(height > 0.1) < least or not _seen(lobe, view.nodes.unit, height):
            return False
        narrow, wide = (float(s) for s in lobe.sigma)
        if wide > PROVISIONAL * BROADEST_RAD or wide > LONGEST * narrow or not stands_out(view, fit, place):
            return False
        if place < new and not _alike(view, fit, height):
            return False
    return bool(np.all(peak_errors(fit, view.nodes, view.ground) < PEAK_ERROR))


def _alike(view: View, fit: Fit, height: FloatArray) -> bool:
    """Whether what is left where a lobe is, beside noise, is small against what all lobes of the fit give there."""
    near = height > 0.1
    unit, weight = view.nodes.unit[near], view.nodes.weight[near]
    lobes = sum((g.value(unit) for g in fit.lobes), np.zeros(len(unit)))
    return float(weight @ (fit.left[near] ** 2 - view.nodes.variance[near])) < UNLIKE * float(weight @ lobes**2)


def stands_out(view: View, fit: Fit, place: int) -> bool:
    """Whether a lobe is more than a ripple of what is there without it: the broader, the better could a grid show it,
    and the more it must stand out."""
    lobe = fit.lobes[place]
    height = _height(lobe, view.nodes.unit)
    near = height > 0.3
    if not near.any():
        return False
    rest = view.nodes.value[near] - fit.left[near] - lobe.peak * height[near]
    least = LEAST_CONTRAST + CONTRAST_OF_BROADEST * float(lobe.sigma[1]) / BROADEST_RAD
    return bool(lobe.peak >= least * float(np.mean(np.abs(rest))))


def in_vain(found: Found, place: int) -> bool:
    """Whether a lobe, as it is once all are known, is a streak, has its top where nothing is seen, or is lost in what
    is there, stronger lobes and all: what a fit to a strong peak leaves beside it."""
    scene, lobe = found.scene, found.lobes[place]
    if float(lobe.sigma[1]) > LONGEST * float(lobe.sigma[0]):
        return True
    near = scene.points_of(scene.cells_near(lobe.centre, 2.0 * float(lobe.sigma[1])))
    unit = scene.unit[near]
    if not _seen(lobe, unit, _height(lobe, unit)):
        return True
    weight = scene.cell_weight * found.on_cells[place]
    level = float(weight @ np.abs(scene.cell_mean)) / max(float(weight.sum()), 1e-300)
    return lobe.peak < LEAST_LEVEL * level


def pays(view: View, fit: Fit, new: int, before: list[Gauss]) -> bool:
    """Whether the first `new` lobes of a fit reduce the held-out error, where they count, over `before` alone.

    Points are held out by a fixed rule (Nodes.part); where few see the lobes every part is held out in turn.
    """
    nodes = view.nodes
    region = np.any([_height(g, nodes.unit) > 0.1 for g in fit.lobes[:new]], axis=0)
    weight = trust(nodes, np.abs(nodes.value), view.floor)
    errors, seen = np.zeros(2), 0.0
    for part in range(4) if np.count_nonzero(region) < 300 else range(1):
        kept = nodes.part != part
        judged = region & ~kept
        if np.count_nonzero(kept) < sum(g.free for g in fit.lobes) + len(view.ground):
            return False
        seen += float(nodes.weight[judged].sum())
        for which, lobes in enumerate(([view.true(g) for g in fit.lobes], before)):
            again = view.fit(lobes, 4 if lobes else 1, only=kept)
            model = again.ground @ view.ground[:, judged] + view.beside[judged]
            model = sum((g.value(nodes.unit[judged]) for g in again.lobes), model)
            errors[which] += float(weight[judged] @ (nodes.value[judged] - model) ** 2)
    return bool(errors[0] < BENEFIT * errors[1] and errors[1] > GOOD_ENOUGH * seen)


def as_good(view: View, fit: Fit, other: Fit) -> bool:
    """Whether a fit with fewer lobes is good enough, or hardly worse than the other, where the lobes count."""
    region = np.any([_height(g, view.nodes.unit) > 0.1 for g in other.lobes], axis=0)
    weight = trust(view.nodes, np.abs(view.nodes.value), view.floor)[region]
    error, least = (float(weight @ f.left[region] ** 2) for f in (fit, other))
    return error < max(least / BENEFIT, GOOD_ENOUGH * float(view.nodes.weight[region].sum()))


def misfit(found: Found, place: int) -> float:
    """Root mean square, over solid angle, of what is left about a lobe over the level there, noise taken off."""
    lobe = found.lobes[place]
    own = [place, *found.neighbours(lobe, but=place)]
    lobes = [found.lobes[k] for k in own]
    view = found.view(lobes, own)
    if view is None:
        return 0.0
    fit = view.fit(lobes, 1)
    height = _height(lobe, view.nodes.unit)
    near = height > 0.04
    level2 = np.maximum(np.abs(view.nodes.value[near]), height[near] * lobe.peak) ** 2 + view.floor**2
    weight = view.nodes.weight[near]
    excess = float(weight @ ((fit.left[near] ** 2 - view.nodes.variance[near]) / level2)) / float(weight.sum())
    return float(np.sqrt(max(excess, 0.0)))
