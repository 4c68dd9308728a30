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
# A track on the other side lies across a void where it is farther than so many times what this quantile of the track's
# nearer neighbours is, over a turn or two: the strokes of a zigzag are up to twice their usual distance apart.
_VOID = 2.5
_USUAL = 0.9
# A track keeps its pitch for so many pitches of its way, but for changes up to this factor: where it crosses others, or
# turns beside them, tracks are near for a moment.
_KEEPS = 2.0
_SHRUNK = 0.7
_THIN = (64, 16, 4, 1)  # of a path's points every so many are looked at,
_FEW = 1000  # at least,
_DENSE = 1.5  # as long as the pitch is no less than this many of their distances
_SHORTEST = 16  # points: a stretch of track that tells what is usual
_REST = 1e-6  # a shorter step is none
_NEIGHBOUR = 3  # a scattered point's pitch: of its neighbours in the triangulation the third nearest


def path_pitch_rad(unit: ArrayLike, path: ArrayLike) -> FloatArray:
    """Distance (n,) in rad from each point's track to the neighbouring tracks of its own path.

    `unit` (n, 3) in the order flown; `path` (n,) numbers of paths, -1 for scattered points. Each path is triangulated
    alone; a neighbour that the path reaches only by a long way round is on another turn, and the pitch is the distance
    to its track, the larger of both sides (the smaller, where the other side is a void). Turnarounds, crossings and
    other tracks that are near for a moment do not shrink it. Where the path has no neighbouring turn (ends of a
    serpentine) the pitch is that of the nearest point along the path. Paths without any
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
                pitch[own] = _median_step(_apart(points[own][1:], points[own][:-1]))
    return pitch


def reach_rad(unit: ArrayLike, path: ArrayLike, factor: float = 1.5) -> FloatArray:
    """How far (n,) in rad a point owns directions: `factor` times its pitch, or that of a neighbour in the
    triangulation of its hemisphere that reaches it, so that the border of a fine spiral meets the coarse track around
    it; and as far as the places where its Voronoi cell meets two others, if one of these reaches them."""
    points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
    own = np.minimum(factor * path_pitch_rad(points, path), np.pi)
    return np.asarray(sphere.shared_reach(points, own, np.ones(len(points), dtype=bool)))


def _between_turns(points: FloatArray, path: IntArray) -> FloatArray:
    """Pitch (n,) from the neighbouring turns; NaN for a path none of whose points has one.

    Samples lie far closer along the track than the tracks do: a few of them tell the pitch.
    """
    same = np.diff(path) == 0
    step = _apart(points[1:], points[:-1])
    length = np.concatenate(([0.0], np.cumsum(np.where(same, step, 0.0))))
    spacing = _median_step(step[same])
    for thin in _THIN:
        few = slice(None, None, thin)
        if thin > 1 and len(points[few]) < _FEW:
            continue
        ahead = _direction_of_flight(points, same, thin)
        pitch = _looked_at(points[few], ahead, length[few], path[few], thin * spacing)
        if thin == 1 or (np.isfinite(pitch).all() and np.median(pitch) >= _DENSE * thin * spacing):
            break
    return np.repeat(pitch, thin)[: len(points)]


def _looked_at(points: FloatArray, ahead: FloatArray, length: FloatArray, path: IntArray, spacing: float) -> FloatArray:
    """Pitch (n,) of these points, `spacing` apart along the track."""
    pitch = np.full(len(points), np.nan)
    if len(points) < 4:
        return pitch
    rules = (_ROUND_ABOUT, _ABEAM, _PARALLEL, _SAME_TRACK * spacing)
    whole = np.ascontiguousarray
    found = sphere.track_distances(whole(points), whole(ahead), whole(length), whole(path), rules)
    for one in np.unique(path):
        own = np.flatnonzero(path == one)
        known = own[np.isfinite(found[own, 0])]
        if len(known):
            pitch[own] = _kept(found[known], spacing)[_nearest(length[known], length[own])]
    return pitch


def _kept(found: FloatArray, spacing: float) -> FloatArray:
    """Pitch (n,) along one path from the distances of the nearer and the farther track beside each point and the way
    round to the nearer (n, 3)."""
    near, far, way = found.T
    usual = _usual(near, way, spacing)
    # Where a circle turns the usual neighbour is missing, and the nearest may lie across a void.
    near = np.where(near <= _VOID * usual, near, usual)
    value = np.where(far <= _VOID * usual, far, near)
    if len(value) > 2:  # one that differs from both its neighbours is a stray
        before, after = value[:-2], value[2:]
        low, high = np.minimum(before, after), np.maximum(before, after)
        value = np.concatenate((value[1:2], np.clip(value[1:-1], low, high), value[-2:-1]))
    around = _highest(value, round(_KEEPS * float(np.median(usual)) / spacing))
    return np.where(value < _SHRUNK * around, around, value)


def _usual(near: FloatArray, way: FloatArray, spacing: float) -> FloatArray:
    """What the distance of the nearer track (n,) rises to, over about two ways round before and after each point."""
    n = len(near)
    turn = 2.0 * float(np.median(way)) / spacing
    size = int(np.clip(turn, min(n, _SHORTEST), n)) if np.isfinite(turn) else n
    stretches = -(-n // size)
    padded = np.full(stretches * size, np.inf)
    padded[:n] = near
    ranked = np.sort(padded.reshape(stretches, size), axis=1)
    count = np.full(stretches, size)
    count[-1] = n - (stretches - 1) * size
    top = _highest(ranked[np.arange(stretches), (_USUAL * (count - 1)).astype(np.intp)], 1)
    return np.repeat(top, size)[:n]


def _highest(values: FloatArray, around: int) -> FloatArray:
    """The highest (n,) of the values among so many before and after each."""
    highest, done = values, 0
    while done < min(around, len(values) - 1):
        step = min(max(done, 1), around - done, len(values) - 1)
        before = np.concatenate((highest[:step], highest[:-step]))
        after = np.concatenate((highest[step:], highest[-step:]))
        highest, done = np.maximum(highest, np.maximum(before, after)), done + step
    return highest


def _direction_of_flight(points: FloatArray, same: NDArray[np.bool_], thin: int) -> FloatArray:
    """Unit tangents (m, 3) of the track at one of `thin` points; where it rests, of the nearest of them that moves."""
    n = len(points)
    at = np.arange(0, n, thin)
    before, after = np.maximum(at - 1, 0), np.minimum(at + 1, n - 1)
    before, after = np.where(same[before], before, at), np.where(same[after - 1], after, at)
    v = points[after] - points[before]
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


def _median_step(step: FloatArray) -> float:
    """Median of the steps that are any; pi where none is."""
    step = step[step > _REST]
    return float(np.median(step)) if len(step) else np.pi


def _apart(u: FloatArray, v: FloatArray) -> FloatArray:
    difference = u - v
    half = 0.5 * np.sqrt(np.einsum("ij,ij->i", difference, difference))
    return np.asarray(2.0 * np.arcsin(np.minimum(half, 1.0)))
