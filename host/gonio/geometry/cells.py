"""cells.py: the solid angle that belongs to each of many irregular directions: spherical Voronoi cells."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from gonio.geometry.directions import tangent_frame

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

# Directions that round to the same 2^-20 (1e-6, 0.00005 degrees) in each coordinate are one point: nearer than any
# encoder tells apart, and far enough for well-conditioned circumcentres.
_MERGE_BITS = 20
_EDGES_AT_ONCE = 1 << 17
_JOSTLE_FROM = 2000
_WALL = 1e-9  # distance of a plane from the sphere's centre, taken as none
_WALL_GAP = 5e-5  # from a point on a wall to the wall: apart from its images it is not merged with them


def solid_angles_sr(unit: ArrayLike) -> FloatArray:
    """Solid angle in sr, shape (n,), of the spherical Voronoi cell of each unit vector (n, 3); they add up to 4 pi.

    Repeated points share their cell equally. Cells may reach over theta = 90 degrees. Raises ValueError for vectors
    that are not of unit length.
    """
    points = _of_unit_length(unit)
    return _shared(points)[0] if len(points) else np.zeros(0)


def covered_cells_sr(unit: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Solid angles (n,) and first moments (n, 3), the integrals of the unit vector, of cells that end at the border of
    what the directions (n, 3) surround: their convex hull on the sphere. The z component of a moment is the cell's
    projected solid angle.

    Directions that surround the whole sphere share all of it; directions in one plane surround nothing. Raises
    ValueError for vectors that are not of unit length.
    """
    points = _of_unit_length(unit)
    nothing = np.zeros(len(points)), np.zeros((len(points), 3))
    if len(points) < 3:
        return nothing
    try:
        cone = ConvexHull(np.concatenate((points, np.zeros((1, 3)))))
    except QhullError:  # all in one plane
        return nothing
    # Facets through the centre are the cone's walls; the images of the points behind a wall make it a border of cells.
    wall = np.flatnonzero(np.abs(cone.equations[:, 3]) < _WALL)
    tree, guards = cKDTree(points), []
    for outwards, corners in zip(cone.equations[wall, :3], cone.simplices[wall], strict=True):
        edge = points[corners[corners < len(points)]]
        reach = 2.0 * np.linalg.norm(edge - edge[0], axis=1).max()
        near = points[tree.query_ball_point(edge.mean(axis=0), reach)]
        image = near + 2.0 * (_WALL_GAP - near @ outwards)[:, None] * outwards
        guards.append(image / np.linalg.norm(image, axis=1)[:, None])
    areas, moments = _shared(np.concatenate((points, *guards)))
    return areas[: len(points)], moments[: len(points)]


def _of_unit_length(unit: ArrayLike) -> FloatArray:
    points = np.asarray(unit, dtype=np.float64).reshape(-1, 3)
    if not np.allclose(np.einsum("ij,ij->i", points, points), 1.0, atol=1e-9):
        raise ValueError("solid angles need vectors of unit length")
    return points


def _shared(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Areas (n,) and first moments (n, 3) of the cells; repeated points share theirs."""
    first, group = _merge(points)
    areas, moments, owner = _distinct_cells(points[first])
    owner_of_point = owner[group]
    sharers = np.bincount(owner_of_point, minlength=len(areas))[owner_of_point]
    return areas[owner_of_point] / sharers, moments[owner_of_point] / sharers[:, None]


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
    pitch = _pitch_rad(polar, azimuth)
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


def spiral_pitch_deg(unit: ArrayLike, centre: ArrayLike) -> float:
    """Distance of the turns of a spiral (n, 3) about the unit vector `centre` (3,)."""
    points = np.asarray(unit, dtype=np.float64)
    e1, e2, pole = tangent_frame(centre)
    polar = np.arctan2(np.hypot(points @ e1, points @ e2), points @ pole)
    return float(np.degrees(_pitch_rad(polar, np.arctan2(points @ e2, points @ e1))))


def _pitch_rad(polar: FloatArray, azimuth: FloatArray) -> float:
    away = polar > 0.02 * polar.max()  # nearer to the centre the azimuth jumps about
    turns = abs(float(np.sum((np.diff(azimuth[away]) + np.pi) % (2.0 * np.pi) - np.pi))) / (2.0 * np.pi)
    return float((polar[away].max() - polar[away].min()) / max(turns, 1.0))


def _merge(points: FloatArray) -> tuple[IntArray, IntArray]:
    """First index of each distinct point, and for every point the number of its distinct point (n,)."""
    grid = np.rint((points + 1.0) * (1 << (_MERGE_BITS - 1))).astype(np.int64)
    key = (grid[:, 0] << (2 * (_MERGE_BITS + 1))) | (grid[:, 1] << (_MERGE_BITS + 1)) | grid[:, 2]
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return first, group


def _distinct_cells(points: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Cell areas (n,) and first moments (n, 3) of distinct points, and for each point the one whose cell it shares
    (itself, as a rule)."""
    itself = np.arange(len(points))
    if len(points) < 4:
        return *_lunes(points), itself
    try:
        points = _jostled(points)
        hull = ConvexHull(points)
    except QhullError:  # all in one plane
        return *_lunes(points), itself
    if len(hull.coplanar):
        itself[hull.coplanar[:, 0]] = hull.coplanar[:, 2]
    areas, moments = np.zeros(len(points)), np.zeros((len(points), 3))
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
        area, moment = _edge_parts(points[a], points[b], circumcentres[f], circumcentres[g], sense)
        areas += np.bincount(a, area, len(points)) + np.bincount(b, area, len(points))
        for axis in range(3):
            moments[:, axis] += np.bincount(a, moment[:, axis], len(points))
            moments[:, axis] -= np.bincount(b, moment[:, axis], len(points))
    return np.maximum(areas, 0.0), moments, itself  # rounding can leave -1e-17


def _jostled(points: FloatArray) -> FloatArray:
    """Many points (n, 3), moved by some 1e-8. Arms fly circles: thousands of points in one plane cost the hull five
    times as long to sort out, for borders that do not matter. The same points always move in the same way."""
    if len(points) < _JOSTLE_FROM:
        return points
    moved = points + 1e-8 * np.random.default_rng(len(points)).standard_normal(points.shape)
    return np.asarray(moved / np.linalg.norm(moved, axis=1)[:, None])


def _edge_parts(
    a: FloatArray, b: FloatArray, centre_f: FloatArray, centre_g: FloatArray, sense: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Area (m,) between point a (or b: it is the same) and the Voronoi edge that it shares with b, and the edge's part
    (m, 3) of the first moment of a's cell (b's has the opposite).

    The edge lies on the great circle that bisects ab and runs from one circumcentre to the other. With h half the angle
    ab and beta the arc along that circle from the middle of ab, the right triangle between them has the excess E,
    tan(E/2) = tan(h/2) tan(beta/2) (spherical excess of a right triangle; I. Todhunter, Spherical Trigonometry, 1886,
    art. 103), continued past beta = 90 degrees by arctan2. An error of a circumcentre cancels to first order in the sum
    of a facet's three edges. The first moment of a polygon on the sphere is half the sum of its arcs times the unit
    normals of their planes, inwards (J. H. Lambert, Photometria, 1760).
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
    once_round = np.where(across_far_side, 2.0 * np.pi, 0.0)
    moment = (-0.5 * (arc[1] - arc[0] + once_round) / length)[:, None] * chord
    return np.asarray(excess[1] - excess[0] + once_round), moment


def _lunes(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cell areas (n,) and first moments (n, 3) of distinct points on one circle of the sphere: their bisectors all meet
    in the circle's axis, so the cells are lunes; a lune of angle w has the area 2 w and the moment pi sin(w/2)."""
    if len(points) == 1:
        return np.array([4.0 * np.pi]), np.zeros((1, 3))
    axis = np.linalg.svd(points - points.mean(axis=0))[2][2]
    e1, e2, _ = tangent_frame(axis)
    azimuth = np.arctan2(points @ e2, points @ e1)
    order = np.argsort(azimuth)
    gap = np.empty(len(points))
    gap[order] = np.diff(azimuth[order], append=azimuth[order[0]] + 2.0 * np.pi)
    before = np.empty(len(points))
    before[order] = np.roll(gap[order], 1)
    middle = azimuth + 0.25 * (gap - before)
    towards = np.cos(middle)[:, None] * e1 + np.sin(middle)[:, None] * e2
    return gap + before, np.pi * np.sin(0.25 * (gap + before))[:, None] * towards
