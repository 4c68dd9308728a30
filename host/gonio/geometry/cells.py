"""cells.py: the solid angle that belongs to each of many irregular directions: spherical Voronoi cells."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError

from gonio.geometry.directions import tangent_frame

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

# Directions that round to the same 2^-20 (1e-6, 0.00005 degrees) in each coordinate are one point: nearer than any
# encoder tells apart, and far enough for well-conditioned circumcentres.
_MERGE_BITS = 20
_EDGES_AT_ONCE = 1 << 17
_JOSTLE_FROM = 2000


def solid_angles_sr(unit: ArrayLike) -> FloatArray:
    """Solid angle in sr, shape (n,), of the spherical Voronoi cell of each unit vector (n, 3); they add up to 4 pi.

    Repeated points share their cell equally. Cells may reach over theta = 90 degrees. Raises ValueError for vectors
    that are not of unit length.
    """
    points = np.atleast_2d(np.asarray(unit, dtype=np.float64))
    if points.size == 0:
        return np.zeros(0)
    if not np.allclose(np.einsum("ij,ij->i", points, points), 1.0, atol=1e-9):
        raise ValueError("solid angles need vectors of unit length")
    first, group = _merge(points)
    areas, owner = _distinct_areas(points[first])
    owner_of_point = owner[group]
    return areas[owner_of_point] / np.bincount(owner_of_point, minlength=len(areas))[owner_of_point]


def hemisphere_solid_angles_sr(unit: ArrayLike) -> FloatArray:
    """As solid_angles_sr for directions that all lie on one side of the sample (theta < 90 or > 90 degrees): cells end
    at the horizon and add up to 2 pi. The mirror images below the horizon make it the border of every cell."""
    points = np.atleast_2d(np.asarray(unit, dtype=np.float64))
    return solid_angles_sr(np.concatenate((points, points * [1.0, 1.0, -1.0])))[: len(points)]


def disc_solid_angles_sr(unit: ArrayLike, centre: ArrayLike) -> FloatArray:
    """As solid_angles_sr for a spiral (n, 3), in the order it was flown, about the unit vector `centre` (3,): guard
    points one pitch outside the outermost turn keep the border samples from owning the rest of the sphere.

    Where the spiral starts at its centre its first turn is given pi pitch^2 / 12 less than its cells. Elsewhere the sum
    over the turns is the integral of f r dr, r being the middle of each cell; that much is the end term at r = 0 (Euler
    and Maclaurin), and to second order all that is wrong with the sum over a peak within the disc.
    """
    points = np.asarray(unit, dtype=np.float64)
    e1, e2, pole = tangent_frame(centre)
    polar = np.arctan2(np.hypot(points @ e1, points @ e2), points @ pole)
    azimuth = np.arctan2(points @ e2, points @ e1)
    away = polar > 0.02 * polar.max()  # nearer to the centre the azimuth jumps about
    turns = abs(float(np.sum((np.diff(azimuth[away]) + np.pi) % (2.0 * np.pi) - np.pi))) / (2.0 * np.pi)
    pitch = (polar[away].max() - polar[away].min()) / max(turns, 1.0)
    sector = ((azimuth + np.pi) / (2.0 * np.pi) * 180.0).astype(np.intp) % 180
    border = np.zeros(180)
    np.maximum.at(border, sector, polar)
    outermost = polar > border[sector] - 0.5 * pitch
    guard_polar, guard_azimuth = polar[outermost] + pitch, azimuth[outermost]
    ring = np.cos(guard_azimuth)[:, None] * e1 + np.sin(guard_azimuth)[:, None] * e2
    guards = np.sin(guard_polar)[:, None] * ring + np.cos(guard_polar)[:, None] * pole
    areas = solid_angles_sr(np.concatenate((points, guards)))[: len(points)]
    if polar[0] < pitch:
        first_turn = np.linalg.norm(points - points[0], axis=1) < pitch
        areas[first_turn] *= 1.0 - np.pi * pitch**2 / 12.0 / areas[first_turn].sum()
    return areas


def _merge(points: FloatArray) -> tuple[IntArray, IntArray]:
    """First index of each distinct point, and for every point the number of its distinct point (n,)."""
    grid = np.rint((points + 1.0) * (1 << (_MERGE_BITS - 1))).astype(np.int64)
    key = (grid[:, 0] << (2 * (_MERGE_BITS + 1))) | (grid[:, 1] << (_MERGE_BITS + 1)) | grid[:, 2]
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return first, group


def _distinct_areas(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Cell areas of distinct points, and for each point the one whose cell it shares (itself, as a rule)."""
    itself = np.arange(len(points))
    if len(points) < 4:
        return _lune_areas(points), itself
    try:
        points = _jostled(points)
        hull = ConvexHull(points)
    except QhullError:  # all in one plane
        return _lune_areas(points), itself
    if len(hull.coplanar):
        itself[hull.coplanar[:, 0]] = hull.coplanar[:, 2]
    areas = np.zeros(len(points))
    facet, side = np.nonzero(hull.neighbors > np.arange(len(hull.simplices))[:, None])
    corners = points[hull.simplices]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    circumcentres = hull.equations[:, :3]
    turn = np.einsum("ij,ij->i", normal, circumcentres)
    for begin in range(0, len(facet), _EDGES_AT_ONCE):
        f, k = facet[begin : begin + _EDGES_AT_ONCE], side[begin : begin + _EDGES_AT_ONCE]
        g = hull.neighbors[f, k]
        a, b = hull.simplices[f, (k + 1) % 3], hull.simplices[f, (k + 2) % 3]
        # The edge's sense in facet f; taken from facet g where that one is the better conditioned.
        in_g = np.abs(turn[g]) > np.abs(turn[f])
        k_g = 3 - (hull.simplices[g] == a[:, None]).argmax(axis=1) - (hull.simplices[g] == b[:, None]).argmax(axis=1)
        reversed_in_g = hull.simplices[g, (k_g + 1) % 3] == b
        sense = np.where(in_g, np.where(reversed_in_g, 1.0, -1.0) * np.sign(turn[g]), np.sign(turn[f]))
        area = _edge_areas(points[a], points[b], circumcentres[f], circumcentres[g], sense)
        areas += np.bincount(a, area, len(points)) + np.bincount(b, area, len(points))
    return np.maximum(areas, 0.0), itself  # rounding can leave -1e-17


def _jostled(points: FloatArray) -> FloatArray:
    """Many points (n, 3), moved by some 1e-8. Arms fly circles: thousands of points in one plane cost the hull five
    times as long to sort out, for borders that do not matter. The same points always move in the same way."""
    if len(points) < _JOSTLE_FROM:
        return points
    moved = points + 1e-8 * np.random.default_rng(len(points)).standard_normal(points.shape)
    return np.asarray(moved / np.linalg.norm(moved, axis=1)[:, None])


def _edge_areas(
    a: FloatArray, b: FloatArray, centre_f: FloatArray, centre_g: FloatArray, sense: FloatArray
) -> FloatArray:
    """Area, shape (m,), between point a (or b: it is the same) and the Voronoi edge that it shares with b.

    The edge lies on the great circle that bisects ab and runs from one circumcentre to the other. With h half the angle
    ab and beta the arc along that circle from the middle of ab, the right triangle between them has the excess E,
    tan(E/2) = tan(h/2) tan(beta/2) (spherical excess of a right triangle; I. Todhunter, Spherical Trigonometry, 1886,
    art. 103), continued past beta = 90 degrees by arctan2. An error of a circumcentre cancels to first order in the sum
    of a facet's three edges.
    """
    chord = b - a
    middle = a + b
    across = np.cross(chord, middle) * sense[:, None]
    length = np.linalg.norm(chord, axis=1)
    # |chord x middle| = |chord| |middle|, as both points have unit length: put both components on the same scale.
    half = 0.5 * np.arcsin(np.minimum(0.5 * length, 1.0))
    sin_h, cos_h = np.sin(half), np.cos(half)
    arc, excess = [], []
    for centre in (centre_f, centre_g):
        along = np.einsum("ij,ij->i", centre, across)
        beta = np.arctan2(along, length * np.einsum("ij,ij->i", centre, middle))
        arc.append(beta)
        excess.append(2.0 * np.arctan2(sin_h * np.sin(0.5 * beta), cos_h * np.cos(0.5 * beta)))
    # An edge runs for at most half a turn; where it passes the far side of the circle beta jumps from pi to -pi.
    across_far_side = arc[1] - arc[0] < -0.5 * np.pi
    return np.asarray(excess[1] - excess[0] + np.where(across_far_side, 2.0 * np.pi, 0.0))


def _lune_areas(points: FloatArray) -> FloatArray:
    """Cell areas of distinct points on one circle of the sphere: their bisectors all meet in the circle's axis, so the
    cells are lunes, and a lune of angle w has the area 2 w."""
    if len(points) == 1:
        return np.array([4.0 * np.pi])
    axis = np.linalg.svd(points - points.mean(axis=0))[2][2]
    e1, e2, _ = tangent_frame(axis)
    azimuth = np.arctan2(points @ e2, points @ e1)
    order = np.argsort(azimuth)
    gap = np.diff(azimuth[order], append=azimuth[order[0]] + 2.0 * np.pi)
    areas = np.empty(len(points))
    areas[order] = gap + np.roll(gap, 1)
    return areas
