"""cells.py: the solid angle that belongs to each of many irregular directions: spherical Voronoi cells."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from gonio.geometry.backend import sphere

FloatArray = NDArray[np.float64]

_WALL = 1e-9  # distance of a plane from the sphere's centre, taken as none
_WALL_GAP = 5e-5  # from a point on a wall to the wall: apart from its images it is not merged with them


@dataclass(frozen=True)
class Cells:
    """What belongs to each of n directions.

    solid_angle_sr (n,): area of the Voronoi cell. linear_sr (n,): weights of the integral of linear interpolation on
    the Delaunay triangles inside the coverage, and of the Voronoi shares at its borders: both cover the same area, so
    2 solid_angle_sr - linear_sr cancels the leading error of either on a peak. moment (n, 3): integral of the unit
    vector over the cell; its z component is the projected solid angle.
    """

    solid_angle_sr: FloatArray
    linear_sr: FloatArray
    moment: FloatArray


def cells(
    unit: ArrayLike,
    *,
    reach_rad: ArrayLike | None = None,
    shared: ArrayLike | None = None,
    cut_at_horizon: bool = True,
) -> Cells:
    """Cells of the unit vectors (n, 3).

    No point owns area farther than `reach_rad` (a number or (n,); None: no limit). With `cut_at_horizon` the points of
    each hemisphere (z >= 0 and z < 0) share that hemisphere alone and cells end at theta = 90 degrees. Repeated points
    share their cell equally. The points marked `shared` (n,) widen each other's reach as pitch.reach_rad does. Raises
    ValueError for vectors that are not of unit length, and for a reach that is not positive.
    """
    points = _of_unit_length(unit)
    reach = np.full(len(points), np.pi)
    if reach_rad is not None:
        reach = np.minimum(np.broadcast_to(np.asarray(reach_rad, dtype=np.float64), reach.shape), np.pi)
        if not np.all(reach > 0.0):
            raise ValueError("a cell's reach must be a positive angle")
    marked = np.zeros(0, dtype=bool) if shared is None else np.ascontiguousarray(shared, dtype=bool)
    return Cells(*sphere.cells(points, np.ascontiguousarray(reach), marked, cut_at_horizon))


def solid_angles_sr(unit: ArrayLike) -> FloatArray:
    """Solid angle in sr, shape (n,), of the spherical Voronoi cell of each unit vector (n, 3); they add up to 4 pi.

    Repeated points share their cell equally. Cells may reach over theta = 90 degrees. Raises ValueError for vectors
    that are not of unit length.
    """
    return cells(unit, cut_at_horizon=False).solid_angle_sr


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
    found = cells(np.concatenate((points, *guards)), cut_at_horizon=False)
    return found.solid_angle_sr[: len(points)], found.moment[: len(points)]


def _of_unit_length(unit: ArrayLike) -> FloatArray:
    points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
    if not np.allclose(np.einsum("ij,ij->i", points, points), 1.0, atol=1e-9):
        raise ValueError("solid angles need vectors of unit length")
    return points
