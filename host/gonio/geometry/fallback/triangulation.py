"""triangulation.py: Delaunay triangles and Voronoi cells on the sphere by numpy and scipy (Qhull).

The same functions with the same arguments (_sphere.pyi); backend.py chooses one of the two at import.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from gonio.geometry.directions import tangent_frame
from gonio.geometry.fallback.voronoi_parts import edge_frame, farthest, triangle_excess, whole, within

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Directions that round to the same 2^-19 (2e-6, 0.0001 degrees) in each coordinate are one point: nearer than any
# encoder tells apart, and far enough for well-conditioned circumcentres.
_MERGE_BITS = 19
_EDGES_AT_ONCE = 1 << 17
_JOSTLE_FROM = 2000
_HORIZON_GAP = 4e-6  # points nearer to the horizon are cut as if they were so far: apart from their mirror images
_ASIDE = 1e-8  # opposite points have no bisector in the plane's sense: one is moved by this
_ROUNDING = 1.0 + 1e-6  # a place at the end of the reach is within it
_ON_CIRCLE = 2e-11  # height over the plane of three others at which a fourth point lies on their circle


@dataclass(frozen=True)
class Facets:
    """Triangles of distinct points: corners (t, 3) and across each the opposite triangle (t, 3), both senses mixed;
    unit normals outwards of the hull, which are circumcentres (t, 3), and the cosine of the circumradius (t,)."""

    points: FloatArray
    corners: IntArray
    neighbours: IntArray
    centre: FloatArray
    cos_radius: FloatArray
    itself: IntArray  # for each point the one whose cell it shares: itself, as a rule


def cells(
    unit: FloatArray, reach: FloatArray, shared: NDArray[np.bool_], cut_at_horizon: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Solid angles (n,), weights of linear interpolation (n,) and first moments (n, 3); `reach` (n,) in rad."""
    if len(shared):
        reach = shared_reach(unit, reach, shared, cut_at_horizon)
    solid, linear, moment = np.zeros(len(unit)), np.zeros(len(unit)), np.zeros((len(unit), 3))
    for chosen, points, images in parts(unit, cut_at_horizon):
        found = _shared(np.concatenate((points, images)), np.tile(reach[chosen], 1 + bool(len(images))), len(points))
        solid[chosen], linear[chosen], moment[chosen] = found
    return solid, linear, moment


def shared_reach(
    unit: FloatArray, reach: FloatArray, shared: NDArray[np.bool_], cut_at_horizon: bool = True
) -> FloatArray:
    """See _sphere.pyi."""
    result = reach.copy()
    for chosen, points, images in parts(unit, cut_at_horizon):
        number = np.tile(chosen, 1 + bool(len(images)))
        together = np.concatenate((points, images))
        first, group = _merge(together)
        facets = _facets(together[first])
        owner = group if facets is None else facets.itself[group]
        widest, mine = np.zeros(len(first)), np.zeros(len(first), dtype=bool)
        np.maximum.at(widest, owner, reach[number])
        np.logical_or.at(mine, owner, shared[number])
        if facets is not None:
            _share(facets, mine, widest)
        result[chosen] = widest[owner[: len(chosen)]]
    return result


def _share(facets: Facets, mine: NDArray[np.bool_], reach: FloatArray) -> None:
    """Widens the reach (n,) of the points that are `mine` (n,)."""
    points, corners, own = facets.points, facets.corners, reach.copy()
    for k, other in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
        a, b = corners[:, k], corners[:, other]
        near = mine[a] & mine[b] & (_angle(np.linalg.norm(points[a] - points[b], axis=1)) <= own[a])
        np.maximum.at(reach, b[near], own[a[near]])
    places = corners[mine[corners].all(axis=1)]
    centre = facets.centre[mine[corners].all(axis=1)]
    distance = _angle(np.linalg.norm(centre - points[places[:, 0]], axis=1)) * _ROUNDING
    while True:
        reached = (reach[places].max(axis=1) >= distance) & (reach[places].min(axis=1) < distance)
        if not reached.any():
            return
        np.maximum.at(reach, places[reached], distance[reached, None])


def _angle(chord: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))


def edges(unit: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs (m, 2) of points that are neighbours in the triangulation, and for every point (n,) the one that stands for
    it there: itself unless it is repeated."""
    first, group = _merge(unit)
    stands = first[group]
    if len(first) < 2:
        return np.zeros((0, 2), dtype=np.int64), stands
    facets = _facets(unit[first])
    if facets is None:
        order = first[np.argsort(_azimuth(unit[first]))]
        return np.stack((order, np.roll(order, -1)), axis=1)[: None if len(first) > 2 else 1], stands
    facet, side = np.nonzero(facets.neighbours > np.arange(len(facets.corners))[:, None])
    pairs = np.stack([facets.corners[facet, (side + k) % 3] for k in (1, 2)], axis=1)
    return first[pairs], first[facets.itself[group]]


def parts(unit: FloatArray, cut_at_horizon: bool) -> list[tuple[NDArray[np.intp], FloatArray, FloatArray]]:
    """Which points, their directions, and the mirror images that make the horizon a border."""
    if not cut_at_horizon:
        return [(np.arange(len(unit)), unit, np.zeros((0, 3)))] if len(unit) else []
    parts = []
    for sign, side in ((1.0, unit[:, 2] >= 0.0), (-1.0, unit[:, 2] < 0.0)):
        chosen = np.flatnonzero(side)
        if len(chosen):
            points = unit[chosen].copy()
            points[:, 2] = sign * np.maximum(sign * points[:, 2], _HORIZON_GAP)
            points /= np.linalg.norm(points, axis=1)[:, None]
            parts.append((chosen, points, points * [1.0, 1.0, -1.0]))
    return parts


def _shared(points: FloatArray, reach: FloatArray, real: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The cells of the first `real` points; repeated points share theirs."""
    first, group = _merge(points)
    widest = np.zeros(len(first))
    np.maximum.at(widest, group, reach)
    solid, linear, moment, itself = _distinct_cells(points[first], widest, first < real)
    owner = itself[group]
    share = 1.0 / np.bincount(owner, minlength=len(first))[owner[:real]]
    own = owner[:real]
    return solid[own] * share, linear[own] * share, moment[own] * share[:, None]


def distinct_facets(points: FloatArray) -> tuple[IntArray, Facets | None]:
    """First index of each distinct point, and the hull of those; None where they lie in one plane."""
    first, _ = _merge(points)
    return first, _facets(points[first])


def _merge(points: FloatArray) -> tuple[IntArray, IntArray]:
    """First index of each distinct point, and for every point the number of its distinct point (n,)."""
    grid = np.rint((points + 1.0) * (1 << (_MERGE_BITS - 1))).astype(np.int64)
    key = (grid[:, 0] << (2 * (_MERGE_BITS + 1))) | (grid[:, 1] << (_MERGE_BITS + 1)) | grid[:, 2]
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return first, group


def _facets(points: FloatArray) -> Facets | None:
    """Hull of distinct points on the sphere; None where they lie in one plane."""
    if len(points) < 4:
        return None
    try:
        hull = ConvexHull(_jostled(points))
    except QhullError:
        return None
    itself = np.arange(len(points))
    if len(hull.coplanar):
        itself[hull.coplanar[:, 0]] = hull.coplanar[:, 2]
    corners, neighbours = hull.simplices.astype(np.int64), hull.neighbors.astype(np.int64)
    return Facets(points, corners, neighbours, hull.equations[:, :3], -hull.equations[:, 3], itself)


def _jostled(points: FloatArray) -> FloatArray:
    """Many points (n, 3), moved by some 1e-8. Arms fly circles: thousands of points in one plane cost the hull five
    times as long to sort out, for borders that do not matter. The same points always move in the same way."""
    if len(points) < _JOSTLE_FROM:
        return points
    moved = points + 1e-8 * np.random.default_rng(len(points)).standard_normal(points.shape)
    return np.asarray(moved / np.linalg.norm(moved, axis=1)[:, None])


def _distinct_cells(
    points: FloatArray, reach: FloatArray, real: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Areas (n,), linear weights (n,) and first moments (n, 3) of distinct points, and for each point the one whose
    cell it shares."""
    facets = _facets(points)
    if facets is None:
        areas, moments = _lunes(points, reach)
        return areas, areas.copy(), moments, np.arange(len(points))
    n, corners, neighbours, centre = len(points), facets.corners, facets.neighbours, facets.centre
    spread = np.zeros(n)
    totals = {kind: (np.zeros(n), np.zeros((n, 3))) for kind in ("whole", "within")}
    kite = np.zeros(corners.shape)  # each corner's Voronoi share of its facet, signed
    facet, side = np.nonzero(neighbours > np.arange(len(corners))[:, None])
    tie = np.zeros(len(facet), dtype=bool)
    p = points[corners]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    size = np.linalg.norm(normal, axis=1)
    turn = np.einsum("ij,ij->i", normal, centre)
    for begin in range(0, len(facet), _EDGES_AT_ONCE):
        part = slice(begin, begin + _EDGES_AT_ONCE)
        f, k = facet[part], side[part]
        g = neighbours[f, k]
        a, b = corners[f, (k + 1) % 3], corners[f, (k + 2) % 3]
        in_g = [(corners[g] == one[:, None]).argmax(axis=1) for one in (a, b)]
        opposite = corners[g, 3 - in_g[0] - in_g[1]]
        # The edge's sense in facet f; taken from facet g where that one is the better conditioned.
        reversed_in_g = (in_g[1] + 1) % 3 == in_g[0]
        better = np.abs(turn[g]) > np.abs(turn[f])
        sense = np.where(better, np.where(reversed_in_g, -1.0, 1.0) * -np.sign(turn[g]), np.sign(turn[f]))
        frame = edge_frame(points[a], points[b], centre[f], centre[g], sense)
        tie[part] = np.abs(np.einsum("ij,ij->i", normal[f], points[opposite] - points[a])) < _ON_CIRCLE * np.maximum(
            size[f], size[g]
        )
        reaches = farthest(frame)
        np.maximum.at(spread, a, reaches)
        np.maximum.at(spread, b, reaches)
        for one, seen in ((a, frame), (b, frame.reversed())):
            for kind, found in (("whole", whole(seen)), ("within", within(seen, np.minimum(reach[one], np.pi)))):
                totals[kind][0][:] += np.bincount(one, found[0], n)
                for axis in range(3):
                    totals[kind][1][:, axis] += np.bincount(one, found[1][:, axis], n)
        excess = triangle_excess(frame.half, frame.arc)
        for one, sign, places in ((f, -1.0, ((k + 1) % 3, (k + 2) % 3)), (g, 1.0, in_g)):
            which = 0 if sign < 0.0 else 1
            for place in places:
                np.add.at(kite, (one, place), sign * excess[which])
    cut = spread > reach
    areas = np.where(cut, totals["within"][0], totals["whole"][0])
    moments = np.where(cut[:, None], totals["within"][1], totals["whole"][1])
    cos_reach = np.cos(np.minimum(reach, 0.5 * np.pi))[corners].max(axis=1)
    covered = (facets.cos_radius >= cos_reach) & (facets.cos_radius > 1e-6) & real[corners].all(axis=1)
    linear = areas + _linear_less_voronoi(facets, kite, covered, (facet[tie], neighbours[facet[tie], side[tie]]))
    return np.maximum(areas, 0.0), linear, moments, facets.itself  # rounding can leave -1e-17


def _linear_less_voronoi(
    facets: Facets, kite: FloatArray, covered: NDArray[np.bool_], ties: tuple[IntArray, IntArray]
) -> FloatArray:
    """What linear interpolation gives each point (n,) beyond its Voronoi share, over the covered facets.

    A facet's corners have a third each. Facets whose corners lie on one circle could be cut either way: they are
    a fan about their middle, which has the mean of all corners' values.
    """
    corners, points, n = facets.corners, facets.points, len(facets.points)
    area = kite.sum(axis=1)
    f, g = (one[covered[ties[0]] & covered[ties[1]]] for one in ties)
    count, face = connected_components(
        coo_matrix((np.ones(len(f)), (f, g)), (len(corners), len(corners))), directed=False
    )
    shared = np.bincount(face, minlength=count)[face] > 1
    alone = covered & ~shared
    extra = np.zeros(n)
    for k in range(3):
        extra += np.bincount(corners[alone, k], area[alone] / 3.0 - kite[alone, k], n)
        extra -= np.bincount(corners[shared, k], kite[shared, k], n)
    if not shared.any():
        return extra
    one, side = np.nonzero(shared[:, None] & (face[facets.neighbours] != face[:, None]))
    a, b, of = corners[one, (side + 1) % 3], corners[one, (side + 2) % 3], face[one]
    members = np.bincount(of, minlength=count)  # a polygon has as many borders as corners
    sums = np.stack([np.bincount(of, points[a, axis] + points[b, axis], count) for axis in range(3)], axis=1)
    length = np.linalg.norm(sums, axis=1)
    middle = sums / np.where(length > 0.0, length, 1.0)[:, None]
    fan = _triangle_area(middle[of], points[a], points[b])
    # Nearly cocircular corners may leave a middle that the face does not hold whole: keep its area.
    whole_face = np.bincount(face[shared], area[shared], count)
    fan *= (whole_face / np.where(members > 0, np.bincount(of, fan, count), 1.0))[of]
    extra += np.bincount(a, fan / 3.0, n) + np.bincount(b, fan / 3.0, n)
    half_share = whole_face / (6.0 * np.maximum(members, 1))  # a corner is at the end of two borders
    return np.asarray(extra + np.bincount(a, half_share[of], n) + np.bincount(b, half_share[of], n))


def _triangle_area(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Area (m,) of spherical triangles (A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30, 125, 1983),
    unsigned. Differences keep the digits of small ones."""
    triple = np.abs(np.einsum("ij,ij->i", a, np.cross(b - a, c - a)))
    dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
    return np.asarray(2.0 * np.arctan2(triple, 1.0 + dots[0] + dots[1] + dots[2]))


def _azimuth(points: FloatArray) -> FloatArray:
    """Azimuths (n,) about the axis of the circle that holds the points (n, 3)."""
    if len(points) < 3:
        return np.arange(float(len(points)))
    axis = np.linalg.svd(points - points.mean(axis=0))[2][2]
    e1, e2, _ = tangent_frame(axis)
    return np.asarray(np.arctan2(points @ e2, points @ e1))


def _lunes(points: FloatArray, reach: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cell areas (n,) and first moments (n, 3) of distinct points on one circle of the sphere: their bisectors all meet
    in the circle's axis, so the cells are lunes, each cut at the circle of its reach."""
    n = len(points)
    reach = np.minimum(reach, np.pi)
    if n == 1:
        return 2.0 * np.pi * (1.0 - np.cos(reach)), (np.pi * np.sin(reach) ** 2)[:, None] * points
    axis = np.linalg.svd(points if n == 2 else points - points.mean(axis=0))[2][2]
    e1, e2, _ = tangent_frame(axis)
    order = np.argsort(np.arctan2(points @ e2, points @ e1))
    following = np.roll(order, -1)
    a, b = points[order], points[following].copy()
    opposite = np.einsum("ij,ij->i", a, b) < -1.0 + 1e-15
    b[opposite] += _ASIDE * np.cross(axis, b[opposite])
    # Between a point and the next the half circle that bisects them, from one end of the axis to the other; where the
    # next is more than half a turn away that half lies behind.
    poles = np.tile(axis, (n, 1))
    frame = edge_frame(a, b, -poles, poles, np.full(n, -1.0))
    areas, moments = np.zeros(n), np.zeros((n, 3))
    for one, seen in ((order, frame), (following, frame.reversed())):
        area, moment = within(seen, reach[one])
        np.add.at(areas, one, area)
        np.add.at(moments, one, moment)
    return areas, moments
