"""arc.py: interpolation between directions that all lie in one plane with the sample, as in-plane goniometers measure:
they have no triangles, but an order."""

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.interpolate import Weights

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_FLAT = 1e-4  # rad: points this near to a plane through the sample lie in it
_REACH, _GAP = 1.5, 4.0  # a neighbour this many times as far as the other one lies across a gap
_OFF_RAD = np.radians(0.1)  # directions farther from the plane are not in it


class Arc:
    """Directions (n, 3) in one plane, in the order of their angle; the hemispheres z >= 0 and z < 0 know nothing of
    each other. A point is known around it as far as 1.5 times the way to its neighbours."""

    def __init__(self, unit: FloatArray) -> None:
        self._e1, self._e2, self._axis = np.linalg.svd(unit, full_matrices=False)[2]
        self._unit = unit
        self._angle = self._angles(unit)
        self._sides = [np.flatnonzero(side) for side in (unit[:, 2] >= 0.0, unit[:, 2] < 0.0)]

    @staticmethod
    def fits(unit: FloatArray) -> bool:
        """Whether the directions lie in a plane, and not in one line."""
        if len(unit) < 3:
            return False
        singular = np.linalg.svd(unit, compute_uv=False)
        return bool(singular[2] <= _FLAT * np.sqrt(len(unit)) < singular[1])

    def at(self, directions: FloatArray) -> Weights:
        """Weights for unit vectors (m, 3), of the two neighbours; the third is 0."""
        m = len(directions)
        index, weight = np.zeros((m, 3), dtype=np.int64), np.zeros((m, 3))
        inside = np.zeros(m, dtype=np.bool_)
        angle, in_plane = self._angles(directions), np.abs(directions @ self._axis) <= np.sin(_OFF_RAD)
        for own, here in zip(self._sides, (directions[:, 2] >= 0.0, directions[:, 2] < 0.0), strict=True):
            wanted = np.flatnonzero(here & in_plane)
            if not len(own) or not len(wanted):
                continue
            middle = self._middle(own)
            place = _turned(self._angle[own] - middle)
            order = np.argsort(place, kind="stable")
            place, own_sorted = place[order], own[order]
            target = _turned(angle[wanted] - middle)
            after = np.clip(np.searchsorted(place, target), 1, max(len(own) - 1, 1))
            before, after = after - 1, np.minimum(after, len(own) - 1)
            gap = place[after] - place[before]
            share = np.clip((target - place[before]) / np.where(gap > 0.0, gap, 1.0), 0.0, 1.0)
            near = np.where(share > 0.5, after, before)
            index[wanted, :2] = own_sorted[np.stack((before, after), axis=1)]
            reached = np.abs(target - place[near]) <= _reach(place)[near]
            weight[wanted, :2] = np.where(reached[:, None], np.stack((1.0 - share, share), axis=1), 0.0)
            inside[wanted] = reached
        return Weights(index, weight, inside)

    def slopes(self, values: FloatArray, used: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (n, 3) and second derivatives (n, 6, as local_fit has them) along the arc, by differences between
        the used points; NaN where there are fewer than three on a side."""
        first, second = np.full(len(values), np.nan), np.full(len(values), np.nan)
        for side in self._sides:
            own = side[used[side]]
            place, group = np.unique(_turned(self._angle[own] - self._middle(own)), return_inverse=True)
            if len(place) < 3:
                continue
            level = np.bincount(group, values[own]) / np.bincount(group)
            slope = np.gradient(level, place)
            first[own], second[own] = slope[group], np.gradient(slope, place)[group]
        along = np.cos(self._angle)[:, None] * self._e2 - np.sin(self._angle)[:, None] * self._e1
        x, y, z = along.T
        squares = np.stack((x * x, y * y, z * z, x * y, x * z, y * z), axis=1)
        return first[:, None] * along, second[:, None] * squares

    def _angles(self, unit: FloatArray) -> FloatArray:
        return np.asarray(np.arctan2(unit @ self._e2, unit @ self._e1))

    def _middle(self, own: NDArray[np.intp]) -> float:
        """Angle of the mean direction of some points: a side spans no more than half a turn about it."""
        mean = self._unit[own].sum(axis=0) if len(own) else self._e1
        return float(np.arctan2(mean @ self._e2, mean @ self._e1))


def _reach(place: FloatArray) -> FloatArray:
    """How far (n,) points at ascending angles reach: 1.5 times the farther neighbour's distance, or the nearer one's
    where a gap lies on the other side."""
    if len(place) < 2:
        return np.zeros(len(place))
    gap = np.diff(place)
    left, right = np.concatenate((gap[:1], gap)), np.concatenate((gap, gap[-1:]))
    near, far = np.minimum(left, right), np.maximum(left, right)
    return np.asarray(_REACH * np.where(far <= _GAP * near, far, near))


def _turned(angle: FloatArray) -> FloatArray:
    """Folded to -pi to pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
