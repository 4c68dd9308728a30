"""pitch.py: how far apart the tracks of a flown path lie, and how far a point may own the directions around it."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.geometry.backend import sphere

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A neighbour is on another turn if the way to it along the path is this many times the distance, and it lies abeam by
# this sine of the angle between track and neighbour: on one closed circle no two points are. Both tracks run in about
# the same direction, or back (the cosine): those that cross are no neighbours.
_ROUND_ABOUT = 3.0
_ABEAM = 0.8
_PARALLEL = 0.7
_SAME_TRACK = 0.5  # of the samples' spacing: tracks nearer than that are one track flown twice
_ONE_SIDED = 2.0  # where the tracks at both sides differ by more the farther one lies across a void
_THIN = (64, 16, 4, 1)  # of a path's points every so many are looked at,
_FEW = 1000  # at least,
_DENSE = 1.5  # as long as the pitch is no less than this many of their distances
_REST = 1e-6  # a shorter step is none
_NEIGHBOUR = 3  # a scattered point's pitch: of its neighbours in the triangulation the third nearest


def path_pitch_rad(unit: ArrayLike, path: ArrayLike) -> FloatArray:
    """Distance (n,) in rad from each point's track to the neighbouring tracks of its own path.

    `unit` (n, 3) in the order flown; `path` (n,) numbers of paths, -1 for scattered points. Each path is triangulated
    alone; a neighbour that the path reaches only by a long way round is on another turn, and the pitch is the distance
    to its track, the larger of both sides (the smaller, where the other side is a void). Where the path has no
    neighbouring turn (ends of a serpentine) the pitch is that of the nearest point along the path. Paths without any
    turn beside them (circles flown one by one) are taken together; a path that is still alone (one circle, an arc in a
    plane) has its samples' own distance for a pitch. Scattered points: the third nearest of the neighbours in their
    triangulation, which is the spacing on a grid, and the distance of the rings on a grid of polar angles, whose points
    crowd near the poles.
    """
    points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
    number = np.asarray(path, dtype=np.int64)
    pitch = np.full(len(points), np.nan)
    turnless = []
    for one in np.unique(number):
        own = np.flatnonzero(number == one)
        if one < 0:
            pitch[own] = _scattered(points[own])
            continue
        pitch[own] = _between_turns(points[own], number[own])
        if np.isnan(pitch[own[0]]):
            turnless.append(own)
    if turnless:
        together = np.concatenate(turnless)
        pitch[together] = _between_turns(points[together], number[together])
        for own in turnless:
            if np.isnan(pitch[own[0]]):
                pitch[own] = _spacing(points[own], np.ones(len(own) - 1, dtype=bool))
    return pitch


def reach_rad(unit: ArrayLike, path: ArrayLike, factor: float = 1.5) -> FloatArray:
    """How far (n,) in rad a point owns directions: `factor` times the coarsest pitch among its own and those of its
    neighbours in the triangulation of its hemisphere that reach it, so that the border of a fine spiral meets the
    coarse track around it."""
    points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
    coarsest = sphere.coarsest_pitch(points, path_pitch_rad(points, path), float(factor))
    return np.asarray(np.minimum(factor * coarsest, np.pi))


def _between_turns(points: FloatArray, path: IntArray) -> FloatArray:
    """Pitch (n,) from the neighbouring turns; NaN for a path none of whose points has one.

    Samples lie far closer along the track than the tracks do: a few of them tell the pitch.
    """
    same = np.diff(path) == 0
    step = _apart(points[1:], points[:-1])
    length = np.concatenate(([0.0], np.cumsum(np.where(same, step, 0.0))))
    ahead = _direction_of_flight(points, same)
    spacing = _spacing(points, same)
    for thin in _THIN:
        few = slice(None, None, thin)
        if thin > 1 and len(points[few]) < _FEW:
            continue
        pitch = _looked_at(points[few], ahead[few], length[few], path[few], thin * spacing)
        if thin == 1 or (np.isfinite(pitch).all() and np.median(pitch) >= _DENSE * thin * spacing):
            break
    return np.repeat(pitch, thin)[: len(points)]


def _looked_at(points: FloatArray, ahead: FloatArray, length: FloatArray, path: IntArray, spacing: float) -> FloatArray:
    """Pitch (n,) of these points, `spacing` apart along the track."""
    pitch = np.full(len(points), np.nan)
    if len(points) < 4:
        return pitch
    rules = (_ROUND_ABOUT, _ABEAM, _PARALLEL, _SAME_TRACK * spacing, _ONE_SIDED)
    whole = np.ascontiguousarray
    found = sphere.track_distances(whole(points), whole(ahead), whole(length), whole(path), rules)
    for one in np.unique(path):
        own = np.flatnonzero(path == one)
        known = own[np.isfinite(found[own])]
        if len(known):
            value = found[known]
            if len(known) > 2:  # one that differs from both its neighbours is a stray
                before, after = value[:-2], value[2:]
                low, high = np.minimum(before, after), np.maximum(before, after)
                value = np.concatenate((value[1:2], np.clip(value[1:-1], low, high), value[-2:-1]))
            pitch[own] = value[_nearest(length[known], length[own])]
    return pitch


def _direction_of_flight(points: FloatArray, same: NDArray[np.bool_]) -> FloatArray:
    """Unit tangents (n, 3) of the track; where it rests, of the nearest point that moves."""
    step = np.diff(points, axis=0) * same[:, None]
    v = np.zeros_like(points)
    v[1:] += step
    v[:-1] += step
    size = np.linalg.norm(v, axis=1)
    moves = np.flatnonzero(size > _REST)
    if not len(moves):
        return v
    use = moves[_nearest(moves.astype(np.float64), np.arange(float(len(v))))]
    return np.asarray(v[use] / size[use, None])


def _nearest(known: FloatArray, wanted: FloatArray) -> NDArray[np.intp]:
    """Index into the ascending values `known` (k,) of the one nearest to each of `wanted` (n,)."""
    after = np.clip(np.searchsorted(known, wanted), 1, max(len(known) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(known) - 1)
    return np.where(wanted - known[before] <= known[after] - wanted, before, after)


def _scattered(points: FloatArray) -> FloatArray:
    """Distance (n,) to the third nearest neighbour in the triangulation, or to the last where there are fewer; pi where
    there is none. Repeated points have one distance."""
    pairs, stands = sphere.edges(points)
    a, b = np.concatenate((pairs, pairs[:, ::-1])).T
    apart = _apart(points[a], points[b])
    order = np.lexsort((apart, a))
    owner, start, count = np.unique(a[order], return_index=True, return_counts=True)
    pitch = np.full(len(points), np.pi)
    pitch[owner] = apart[order][start + np.minimum(count, _NEIGHBOUR) - 1]
    return np.asarray(pitch[stands])


def _spacing(points: FloatArray, same: NDArray[np.bool_]) -> float:
    """Median distance of successive points of one path that are apart; pi where there are none."""
    step = _apart(points[1:], points[:-1])[same]
    step = step[step > _REST]
    return float(np.median(step)) if len(step) else np.pi


def _apart(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(u - v, axis=1), 1.0)))
