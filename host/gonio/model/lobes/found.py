"""found.py: the lobes found so far, and what a fit about some of them sees of the distribution."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.least_squares import Bounds, Fit, fit_together, ground_terms
from gonio.model.lobes.scene import Nodes, Scene, some_of

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

BROADEST_RAD = np.radians(20.0)
LIMIT = 3000  # nodes in one fit
CELLS_PER_SIGMA = 4.0  # lobes at least so broad are fitted to means over cells
WINDOW = 4.5  # standard deviations about a lobe that its fit sees
HIDDEN = 0.5  # standard deviations about a lobe's centre without a point: its top lies in a gap of the data
LEAST_SEEN = 0.5  # of the peak of such a lobe that some point sees
EDGES = 0.25  # root of the share of squared DSF that Gaussians leave, from which on they are fitted where it is high
FLOOR_SHARE = 0.03  # of the weakest peak in a fit: far below it, what is no Gaussian must not bend the lobe


@dataclass(frozen=True)
class View:
    """What a fit sees: nodes, what lobes that are not part of it give there (m,), the ground terms (q, m), the floor
    of trust [1/sr], and the variance [rad^2] of directions within a node, by which lobes look wider there."""

    nodes: Nodes
    beside: FloatArray
    ground: FloatArray
    floor: float
    spread: float

    def fit(self, lobes: list[Gauss], steps: int, *, only: NDArray[np.bool_] | None = None) -> Fit:
        """Lobes and ground fitted to all nodes, or those of a mask; Fit.lobes are as the nodes see them."""
        if only is None:
            return self._fit(self.nodes, self.beside, self.ground, lobes, steps)
        return self._fit(self.nodes.only(only), self.beside[only], self.ground[:, only], lobes, steps)

    def _fit(self, nodes: Nodes, beside: FloatArray, ground: FloatArray, lobes: list[Gauss], steps: int) -> Fit:
        seen = tuple(g.widened(self.spread) for g in lobes)
        bounds = tuple(bounds_of(g, nodes) for g in seen)
        return fit_together(seen, bounds, nodes, beside, ground, floor=self.floor, steps=steps)

    def true(self, lobe: Gauss) -> Gauss:
        """A fitted lobe without the widening by the nodes."""
        return lobe.widened(-self.spread)


def bounds_of(lobe: Gauss, nodes: Nodes) -> Bounds:
    """How far a lobe may go in a fit, by the points that see it."""
    away = np.arccos(np.clip(nodes.unit @ lobe.centre, -1.0, 1.0))
    wide = float(lobe.sigma[1])
    nearest = np.argpartition(away, min(12, len(away) - 1))[:12]
    pitch = float(np.sqrt(np.median(nodes.weight[nearest])))
    near = away <= max(2.0 * wide, 2.0 * pitch)
    top = float(nodes.value[near].max()) if near.any() else lobe.peak
    # the best Gaussian for a top hat is 1.43 times as high; in a gap what is seen is only a flank
    hidden = float(away[nearest].min()) > HIDDEN * float(lobe.sigma[0])
    most = (1.0 / LEAST_SEEN if hidden else 1.5) * max(top, 1e-12)
    return Bounds(lobe.centre, max(1.5 * wide, pitch), 0.35 * pitch, 1.3 * BROADEST_RAD, most)


class Found:
    """Lobes of a scene, each with its mean over every cell."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.lobes: list[Gauss] = []
        self.on_cells: list[FloatArray] = []
        self.least_floor = 1e-4 * scene.mean
        self._terms: tuple[FloatArray, FloatArray] | None = None

    def explained(self, *, but: tuple[int, ...] = ()) -> FloatArray:
        """Sum of the lobes (c,) in each cell."""
        return np.asarray(sum((v for k, v in enumerate(self.on_cells) if k not in but), np.zeros(len(self.scene.home))))

    def ground_basis(self) -> tuple[FloatArray, FloatArray]:
        """Terms of the smooth ground of the whole hemisphere: at scene.means(2).nodes (q, b), in the cells (q, c)."""
        if self._terms is None:
            coarse = self.scene.means(2).nodes.unit
            terms = ground_terms(np.concatenate((coarse, self.scene.cell_unit)), order=2)
            self._terms = np.ascontiguousarray(terms[:, : len(coarse)]), np.ascontiguousarray(terms[:, len(coarse) :])
        return self._terms

    def accept(self, lobes: tuple[Gauss, ...], own: list[int], new: int) -> None:
        """The first `new` lobes are added, the others replace the accepted ones `own`."""
        for k, lobe in zip(own, lobes[new:], strict=True):
            self.replace(k, lobe)
        for lobe in lobes[:new]:
            self.lobes.append(lobe)
            self.on_cells.append(self.scene.on_cells(lobe))

    def drop(self, place: int) -> None:
        """Forgets a lobe."""
        del self.lobes[place], self.on_cells[place]

    def replace(self, place: int, lobe: Gauss) -> None:
        """Another lobe in the place of one."""
        self.lobes[place], self.on_cells[place] = lobe, self.scene.on_cells(lobe)

    def neighbours(self, lobe: Gauss, *, but: int | None = None) -> list[int]:
        """Up to three accepted lobes that overlap with one and are not of quite another size, nearest first."""
        size = float(np.sqrt(np.prod(lobe.sigma)))
        near = []
        for k, other in enumerate(self.lobes):
            theirs = float(np.sqrt(np.prod(other.sigma)))
            away = float(np.arccos(np.clip(lobe.centre @ other.centre, -1.0, 1.0)))
            if k != but and away < 2.5 * float(lobe.sigma[1] + other.sigma[1]) and 1 / 3.5 < theirs / size < 3.5:
                near.append((away / theirs, k))
        return [k for _, k in sorted(near)[:3]]

    def nodes(
        self, cells: IndexArray, centre: FloatArray, radius: float, narrowest: float, but: tuple[int, ...]
    ) -> tuple[Nodes, FloatArray, float]:
        """What is seen in cells and within `radius` [rad] of a direction, what lobes other than `but` give there, and
        the nodes' spread (View.spread): means where the narrowest lobe [rad] allows, else points."""
        scene = self.scene
        for factor in (2, 1):
            if narrowest > CELLS_PER_SIGMA * factor * scene.cell_rad:
                means = scene.means(factor)
                inside = np.zeros(len(means.nodes), dtype=bool)
                inside[means.home[cells]] = True
                inside &= means.nodes.unit @ centre >= np.cos(min(radius, np.pi))
                kept = some_of(np.flatnonzero(inside), LIMIT)
                beside = means.of(self.explained(but=but))[kept]
                return means.nodes.only(kept), beside, float(means.spread[kept].mean()) if len(kept) else 0.0
        nodes = scene.points_near(cells, centre, radius, LIMIT)
        others = (g.value(nodes.unit) for k, g in enumerate(self.lobes) if k not in but)
        return nodes, np.asarray(sum(others, np.zeros(len(nodes)))), 0.0

    def view(self, lobes: list[Gauss], own: list[int]) -> View | None:
        """For a fit of lobes about the first; `own`: accepted lobes that are among them or make way. None: too few
        nodes."""
        scene = self.scene
        lead = lobes[0]
        reach = max(
            float(np.arccos(np.clip(g.centre @ lead.centre, -1.0, 1.0))) + WINDOW * float(g.sigma[1]) for g in lobes
        )
        least = 4.0 * scene.finest_near(lead.centre)
        narrowest = min(float(g.sigma[0]) for g in lobes)
        cells = scene.cells_near(lead.centre, min(max(reach, least), np.pi))
        if reach > 2.0 * WINDOW * narrowest:
            # long lobes: what lies abeam of all of them is of no use
            margin = WINDOW + (least + 2.0 * scene.cell_rad) / narrowest
            near = [g.whitened(scene.cell_unit[cells])[1] < margin**2 for g in lobes]
            cells = cells[np.any(near, axis=0)]
        nodes, beside, spread = self.nodes(cells, lead.centre, max(reach, least), narrowest, tuple(own))
        spare = len(nodes) - sum(g.free for g in lobes)
        if spare < 4:
            return None
        ground = ground_terms(nodes.unit, order=2 if spare > 24 else 1 if spare > 10 else 0)
        return View(nodes, beside, ground, max(FLOOR_SHARE * min(g.peak for g in lobes), self.least_floor), spread)

    def polish(self) -> float:
        """Every lobe again with its neighbours, the others as they are now; the largest relative change of a peak."""
        change = 0.0
        for k in sorted(range(len(self.lobes)), key=lambda k: -self.lobes[k].peak):
            own = [k, *self.neighbours(self.lobes[k], but=k)]
            before = [self.lobes[j] for j in own]
            view = self.view(before, own)
            if view is None:
                continue
            left = view.fit(before, 1).left
            if float(view.nodes.weight @ left**2) > EDGES**2 * float(view.nodes.weight @ view.nodes.value**2):
                # by relative weights the dark about a peak with edges would win over the peak
                view = replace(view, floor=max(g.peak for g in before))
            fit = view.fit(before, 10)
            for j, old, lobe in zip(own, before, fit.lobes, strict=True):
                self.replace(j, view.true(lobe))
                change = max(change, abs(lobe.log_peak - old.log_peak))
        return change
