"""tracks.py: how far apart the tracks of a flown path lie, by numpy: what _sphere does, with the rules of pitch.py."""

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.fallback.triangulation import edges

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def track_distances(
    unit: FloatArray,
    ahead: FloatArray,
    length: FloatArray,
    path: IntArray,
    rules: tuple[float, float, float, float],
) -> FloatArray:
    """See _sphere.pyi."""
    round_about, abeam, parallel, same_track = rules
    pairs, stands = edges(unit)
    a, b = np.concatenate((pairs, pairs[:, ::-1])).T
    difference = unit[b] - unit[a]
    chord = np.maximum(np.linalg.norm(difference, axis=1), 1e-300)
    way = np.where(path[a] != path[b], np.inf, np.abs(length[a] - length[b]))
    along = np.abs(np.einsum("ij,ij->i", ahead[a], ahead[b])) > parallel
    sine = np.einsum("ij,ij->i", difference, np.cross(unit, ahead)[a]) / chord
    distance = _angle(chord) * np.abs(sine)
    beside = (way > round_about * chord) & along & (np.abs(sine) > abeam) & (distance > same_track)
    sides = np.full((2, len(unit)), np.inf)
    ways = sides.copy()
    for k, side in enumerate((beside & (sine > 0.0), beside & (sine < 0.0))):
        chosen = np.flatnonzero(side)
        chosen = chosen[np.argsort(-distance[chosen], kind="stable")]  # the nearest is written last
        sides[k, a[chosen]] = distance[chosen]
        ways[k, a[chosen]] = way[chosen]
    nearer_way = np.where(sides[0] <= sides[1], ways[0], ways[1])
    return np.column_stack((sides.min(axis=0), sides.max(axis=0), nearer_way))[stands]


def _angle(chord: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))
