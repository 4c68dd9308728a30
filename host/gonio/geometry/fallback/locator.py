"""locator.py: in which Delaunay triangle a direction lies, by numpy: what _sphere.Locator does."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.geometry.fallback.triangulation import distinct_facets, parts

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_MOST_STEPS = 100_000
_ON_BORDER = 4e-6


@dataclass(frozen=True)
class _Part:
    """Triangles of one hemisphere, or of all points: corners counter-clockwise seen from outside (t, 3), the triangle
    across from each corner (t, 3), whether a triangle faces outwards (t,), the caller's number of each point, and one
    triangle of each point."""

    side: float  # +1, -1: the hemisphere; 0: all
    points: FloatArray
    reach: FloatArray
    of_caller: IntArray
    tree: cKDTree
    corners: IntArray
    neighbours: IntArray
    outwards: NDArray[np.bool_]
    some: IntArray


class Locator:
    """See _sphere.pyi."""

    def __init__(self, unit: FloatArray, reach: FloatArray, cut_at_horizon: bool) -> None:
        self._parts = []
        for chosen, points, images in parts(unit, cut_at_horizon):
            number = np.tile(chosen, 2) if len(images) else chosen
            side = float(np.where(unit[chosen[0], 2] < 0.0, -1.0, 1.0)) if cut_at_horizon else 0.0
            self._parts.append(_part(side, np.concatenate((points, images)), reach, number))

    def at(self, directions: FloatArray) -> tuple[IntArray, FloatArray, NDArray[np.bool_]]:
        """Points (m, 3), weights (m, 3) and whether inside (m,)."""
        m = len(directions)
        index, weight, inside = np.zeros((m, 3), dtype=np.int64), np.zeros((m, 3)), np.zeros(m, dtype=bool)
        up = directions[:, 2] >= 0.0
        for part in self._parts:
            own = np.flatnonzero(np.full(m, True) if part.side == 0.0 else up == (part.side > 0.0))
            if len(own):
                index[own], weight[own], inside[own] = _located(part, directions[own])
        return index, weight, inside


def _part(side: float, points: FloatArray, reach: FloatArray, number: IntArray) -> _Part:
    first, facets = distinct_facets(points)
    own, of_caller = points[first], number[first]
    tree = cKDTree(own)
    if facets is None:
        none = np.zeros((0, 3), dtype=np.int64)
        return _Part(side, own, reach[of_caller], of_caller, tree, none, none, np.zeros(0, dtype=bool), none[:, 0])
    corners, neighbours = facets.corners.copy(), facets.neighbours.copy()
    p = own[corners]
    clockwise = np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), facets.centre) < 0.0
    for one in (corners, neighbours):
        one[clockwise] = one[clockwise][:, [0, 2, 1]]
    outwards = facets.cos_radius > 0.0
    some = np.full(len(own), -1)
    for k in range(3):
        some[corners[outwards, k]] = np.flatnonzero(outwards)
    return _Part(side, own, reach[of_caller], of_caller, tree, corners, neighbours, outwards, some)


def _located(part: _Part, wanted: FloatArray) -> tuple[IntArray, FloatArray, NDArray[np.bool_]]:
    """A walk from a triangle of the nearest point across the edge that hides the direction most."""
    apart, nearest = part.tree.query(wanted)
    index = np.repeat(part.of_caller[nearest][:, None], 3, axis=1)
    weight = np.tile([1.0, 0.0, 0.0], (len(wanted), 1))
    inside = 2.0 * np.arcsin(np.minimum(0.5 * apart, 1.0)) <= part.reach[nearest]
    if not len(part.corners):
        return index, weight * inside[:, None], inside
    at = part.some[nearest]
    walking = np.flatnonzero(at >= 0)
    inside[at < 0] = False
    for _ in range(_MOST_STEPS):
        if not len(walking):
            break
        p, q = part.points[part.corners[at[walking]]], wanted[walking]
        # Six times the volume of origin, direction and the edge across from each corner.
        volume = np.stack(
            [np.einsum("ij,ij->i", np.cross(p[:, (k + 1) % 3], p[:, (k + 2) % 3]), q) for k in range(3)], axis=1
        )
        worst = volume.argmin(axis=1)
        # Over the border of what the points surround there is nothing; on it there is.
        lowest = volume.min(axis=1)
        edge = np.take_along_axis(
            np.linalg.norm(np.roll(p, -1, axis=1) - np.roll(p, -2, axis=1), axis=2), worst[:, None], 1
        )
        at_border = ~part.outwards[part.neighbours[at[walking], worst]]
        arrived = (lowest >= -1e-15) | (at_border & (lowest >= -_ON_BORDER * edge[:, 0]))
        done = walking[arrived]
        weight[done] = np.maximum(volume[arrived], 0.0)
        index[done] = part.of_caller[part.corners[at[done]]]
        chord = np.linalg.norm(p[arrived] - q[arrived][:, None], axis=2)
        reach = part.reach[part.corners[at[done]]]
        inside[done] = (2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)) <= reach).any(axis=1)
        walking, worst = walking[~arrived], worst[~arrived]
        at[walking] = part.neighbours[at[walking], worst]
        left = ~part.outwards[at[walking]]
        inside[walking[left]] = False
        walking = walking[~left]
    inside[walking] = False
    weight[~inside] = 0.0
    total = weight.sum(axis=1)
    return index, weight / np.where(total > 0.0, total, 1.0)[:, None], inside
