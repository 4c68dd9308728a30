# _sphere: the compiled routine on irregular directions (host/native), and what gonio.geometry.fallback does like it.
import numpy as np
from numpy.typing import NDArray

def cells(
    unit: NDArray[np.float64], reach: NDArray[np.float64], shared: NDArray[np.bool_], cut_at_horizon: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Solid angles (n,), weights of linear interpolation (n,) and first moments (n, 3) of the cells of unit vectors
    (n, 3) whose points own nothing beyond `reach` (n,) in rad, which those marked (n,) or (0,) share with each other:
    see cells.Cells and shared_reach."""

def edges(unit: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (m, 2) of points that are neighbours in the triangulation of all (n, 3), and for every point (n,) the one
    that stands for it there: itself unless it is repeated."""

def track_distances(
    unit: NDArray[np.float64],
    ahead: NDArray[np.float64],
    length: NDArray[np.float64],
    path: NDArray[np.int64],
    rules: tuple[float, float, float, float],
) -> NDArray[np.float64]:
    """Of the tracks at both sides of each point's own (n, 3): distance of the nearer and of the farther in rad, and the
    way along the path to the nearer, infinite where it is another path's; distances are infinite where there is no
    track. For unit vectors (n, 3) in the order flown: the tangents of flight (n, 3), the way flown so far in rad (n,),
    the path's number (n,). Rules: round about, abeam, parallel, same track in rad; see pitch.py."""

def shared_reach(
    unit: NDArray[np.float64], reach: NDArray[np.float64], shared: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """The `reach` (n,) in rad of unit vectors (n, 3), on each hemisphere shared among the points marked (n,): a point
    gives its own to neighbours in the triangulation that lie within it; and what one of three points reaches of the
    place equally far from them, which is where their Voronoi cells meet, all three reach, one after the other."""

def local_fit(
    unit: NDArray[np.float64],
    values: NDArray[np.float64],
    variance: NDArray[np.float64],
    used: NDArray[np.bool_],
    radius: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Value (n,), gradient (n, 3), Hessian (n, 6) and variance of the gradient (n,): see local_fit.LocalFit."""

class Locator:
    """The triangles of unit vectors (n, 3), made once: see interpolate.Interpolation."""

    def __init__(self, unit: NDArray[np.float64], reach: NDArray[np.float64], cut_at_horizon: bool) -> None: ...
    def at(self, directions: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
        """Points (m, 3), weights (m, 3) and whether inside (m,), for unit vectors (m, 3)."""
