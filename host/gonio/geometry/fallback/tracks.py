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
    rules: tuple[float, float, float, float, float],
) -> FloatArray:
    """See _sphere.pyi."""
    round_about, abeam, parallel, same_track, one_sided = rules
    pairs, stands = edges(unit)
    a, b = np.concatenate((pairs, pairs[:, ::-1])).T
    difference = unit[b] - unit[a]
    chord = np.maximum(np.linalg.norm(difference, axis=1), 1e-300)
    elsewhere = (path[a] != path[b]) | (np.abs(length[a] - length[b]) > round_about * chord)
    along = np.abs(np.einsum("ij,ij->i", ahead[a], ahead[b])) > parallel
    sine = np.einsum("ij,ij->i", difference, np.cross(unit, ahead)[a]) / chord
    distance = _angle(chord) * np.abs(sine)
    beside = elsewhere & along & (np.abs(sine) > abeam) & (distance > same_track)
    sides = np.full((2, len(unit)), np.inf)
    for k, side in enumerate((beside & (sine > 0.0), beside & (sine < 0.0))):
        np.minimum.at(sides[k], a[side], distance[side])
    near, far = np.sort(sides, axis=0)
    return np.asarray(np.where(far <= one_sided * near, far, near)[stands])


def coarsest_pitch(unit: FloatArray, pitch: FloatArray, factor: float) -> FloatArray:
    """See _sphere.pyi."""
    coarsest = pitch.copy()
    for side in (unit[:, 2] >= 0.0, unit[:, 2] < 0.0):
        own = np.flatnonzero(side)
        pairs, stands = edges(unit[own])
        a, b = own[pairs].T
        apart = _angle(np.linalg.norm(unit[a] - unit[b], axis=1))
        for one, other in ((a, b), (b, a)):
            meets = apart <= factor * pitch[other]
            np.maximum.at(coarsest, one[meets], pitch[other[meets]])
        coarsest[own] = np.maximum(coarsest[own], coarsest[own[stands]])
    return coarsest


def _angle(chord: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))
