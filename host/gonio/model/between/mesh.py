"""mesh.py: which measured directions an incident direction lies between, and with which weights.

Isotropic samples: a line in theta, its mirror image beyond the normal. Else Delaunay triangles of the directions and
their images on Lambert's disc; beyond them, or where they would span too much, the nearest edge.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, QhullError

from gonio.dataset.scattering import Origin
from gonio.model.hemisphere import disc_from_unit

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

LONGEST_EDGE_DEG = 91.0  # of a triangle that counts as between its corners; quarters of a turn at grazing still do
LARGEST_GAP_DEG = 31.0  # twice the smallest theta of an isotropic sample: so far the normal counts as between
_BULGE = 0.21  # of an edge's length: the height of a quarter circle over its chord
_AT_ONCE = 500_000  # pairs of a direction and a triangle
_FLAT = 1e-6  # of the disc's unit: triangles lower than this are lines


@dataclass(frozen=True)
class Stencil:
    """Nodes and weights of k incident directions: node, weight (k, 3), weights add up to 1; origin (k,); where on a
    line (k,) [rad] they are held (not on a line: 0)."""

    node: IndexArray
    weight: FloatArray
    origin: NDArray[np.uint8]
    at: FloatArray


class Line:
    """Nodes in one plane: an isotropic sample's, all at azimuth 0 or 180."""

    def __init__(self, incident: FloatArray) -> None:
        self.angle = np.arctan2(incident[:, 0], incident[:, 2])
        self.order = np.argsort(self.angle, kind="stable").astype(np.int64)
        self.edges = np.stack((self.order[:-1], self.order[1:]), axis=1)

    def locate(self, incident: FloatArray) -> Stencil:
        """Neighbours of folded incident directions (k, 3) at azimuth 0."""
        own = np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), incident[:, 2])
        knots = self.angle[self.order]
        at = np.clip(own, knots[0], knots[-1])
        below = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, max(len(knots) - 2, 0))
        above = np.minimum(below + 1, len(knots) - 1)
        gap = knots[above] - knots[below]
        share = np.where(gap > 0.0, (at - knots[below]) / np.where(gap > 0.0, gap, 1.0), 0.0)
        node = np.stack((self.order[below], self.order[above], self.order[above]), axis=1)
        weight = np.stack((1.0 - share, share, np.zeros(len(own))), axis=1)
        across_normal = (knots[below] < 0.0) & (knots[above] > 0.0) & (gap > np.radians(LARGEST_GAP_DEG))
        outside = (own > knots[-1] + 1e-9) | across_normal
        origin = np.where(outside, Origin.EXTRAPOLATED, Origin.INTERPOLATED).astype(np.uint8)
        return Stencil(node, weight, origin, at)


class Triangles:
    """Nodes anywhere in the hemisphere; one, two or all on a line will do."""

    def __init__(self, incident: FloatArray) -> None:
        self.incident = incident
        self.disc = disc_from_unit(incident)
        self.triangles = self._triangulate()
        self.edges = self._edges()
        a, b, c = (self.disc[self.triangles[:, k]] for k in range(3))
        self._inverse = np.linalg.inv(np.stack((b - a, c - a), axis=2))

    def locate(self, incident: FloatArray) -> Stencil:
        """Corners of the triangle or ends of the edge about folded incident directions (k, 3)."""
        place = disc_from_unit(incident)
        node, weight = self._nearest_edge(place)
        origin = np.where(self._beside(place, node, weight), Origin.INTERPOLATED, Origin.EXTRAPOLATED).astype(np.uint8)
        for rows in self._in_turns(len(place)):
            if len(self.triangles) == 0:
                break
            two = np.einsum("tij,ktj->kti", self._inverse, place[rows, None] - self.disc[self.triangles[:, 0]])
            three = np.concatenate((1.0 - two.sum(axis=2, keepdims=True), two), axis=2)
            least = three.min(axis=2)
            best = np.argmax(least, axis=1)
            inside = np.flatnonzero(least[np.arange(len(best)), best] >= -1e-9)
            own = np.arange(rows.start, rows.start + len(best))[inside]
            node[own] = self.triangles[best[inside]]
            weight[own] = np.maximum(three[inside, best[inside]], 0.0)
            origin[own] = Origin.INTERPOLATED
        weight /= weight.sum(axis=1, keepdims=True)
        return Stencil(node, weight, origin, np.zeros(len(place)))

    def _beside(self, place: FloatArray, node: IndexArray, weight: FloatArray) -> NDArray[np.bool_]:
        """Which places (k, 2) count as on their nearest edge: those on it, and those between it and the circle about
        the normal through its outer end, where both ends have one theta."""
        ends = self.disc[node]
        distance = np.linalg.norm(np.einsum("kc,kcd->kd", weight, ends) - place, axis=1)
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        outer = np.max(np.linalg.norm(ends, axis=2), axis=1)
        quarter = length <= np.sqrt(2.0) * outer + 1e-6
        between = quarter & (weight[:, 0] > 0.0) & (weight[:, 1] > 0.0)
        bulge = between & (np.linalg.norm(place, axis=1) <= outer + 1e-6) & (distance <= _BULGE * length)
        return np.asarray((distance < 1e-6) | bulge)

    def _triangulate(self) -> IndexArray:
        nothing = np.zeros((0, 3), dtype=np.int64)
        if len(self.disc) < 3:
            return nothing
        try:
            found = Delaunay(self.disc).simplices.astype(np.int64)
        except QhullError:  # all on one line
            return nothing
        corners = self.disc[found]
        one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        doubled = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        sides = self.incident[found] - self.incident[np.roll(found, 1, axis=1)]
        chord = np.linalg.norm(sides, axis=2).max(axis=1)
        good = (doubled > _FLAT) & (chord <= 2.0 * np.sin(np.radians(LONGEST_EDGE_DEG) / 2.0))
        return np.asarray(found[good])

    def _edges(self) -> IndexArray:
        """Sides of the triangles; nodes that no triangle reaches hang on their neighbours along a line."""
        pairs = [self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]
        lonely = np.setdiff1d(np.arange(len(self.disc)), self.triangles)
        if len(lonely):
            # The shortest tree that connects all nodes: along a line or a ring its neighbours.
            pairs.append(_tree(self.incident))
        pairs.append(np.zeros((0, 2), dtype=np.int64))
        return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)

    def _nearest_edge(self, place: FloatArray) -> tuple[IndexArray, FloatArray]:
        if len(self.edges) == 0:
            return np.zeros((len(place), 3), dtype=np.int64), np.tile([1.0, 0.0, 0.0], (len(place), 1))
        node = np.zeros((len(place), 3), dtype=np.int64)
        weight = np.zeros((len(place), 3))
        a = self.disc[self.edges[:, 0]]
        along = self.disc[self.edges[:, 1]] - a
        length2 = np.maximum(np.sum(along**2, axis=1), 1e-300)
        for rows in self._in_turns(len(place)):
            away = place[rows, None] - a
            share = np.clip(np.einsum("kei,ei->ke", away, along) / length2, 0.0, 1.0)
            distance = np.linalg.norm(away - share[..., None] * along, axis=2)
            best = np.argmin(distance, axis=1)
            own = share[np.arange(len(best)), best]
            node[rows] = self.edges[best][:, [0, 1, 1]]
            weight[rows] = np.stack((1.0 - own, own, np.zeros(len(own))), axis=1)
        return node, weight

    def _in_turns(self, number: int) -> list[slice]:
        """Rows in parts whose tables against all triangles or edges stay small."""
        if len(self.triangles) == 0 and len(self.edges) == 0:
            return []
        step = max(1, _AT_ONCE // max(len(self.triangles), len(self.edges)))
        return [slice(first, min(first + step, number)) for first in range(0, number, step)]


def _tree(incident: FloatArray) -> IndexArray:
    """Edges (n - 1, 2) of the shortest tree that connects directions (n, 3), by Prim's algorithm."""
    number = len(incident)
    joined, edges = [0], []
    left = set(range(1, number))
    while left:
        rest = np.array(sorted(left))
        chord = np.linalg.norm(incident[joined][:, None] - incident[rest][None], axis=2)
        a, b = np.unravel_index(int(np.argmin(chord)), chord.shape)
        edges.append((joined[a], int(rest[b])))
        joined.append(int(rest[b]))
        left.remove(int(rest[b]))
    return np.array(edges, dtype=np.int64).reshape(-1, 2)
