# _sphere: the compiled routine on irregular directions (host/native), and what gonio.geometry.fallback does like it.
import numpy as np
from numpy.typing import NDArray

def cells(
    unit: NDArray[np.float64], reach: NDArray[np.float64], cut_at_horizon: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Solid angles (n,), weights of linear interpolation (n,) and first moments (n, 3) of the cells of unit vectors
    (n, 3) whose points own nothing beyond `reach` (n,) in rad: see cells.Cells."""

def edges(unit: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (m, 2) of points that are neighbours in the triangulation of all (n, 3), and for every point (n,) the one
    that stands for it there: itself unless it is repeated."""

def track_distances(
    unit: NDArray[np.float64],
    ahead: NDArray[np.float64],
    length: NDArray[np.float64],
    path: NDArray[np.int64],
    rules: tuple[float, float, float, float, float],
) -> NDArray[np.float64]:
    """Distance (n,) in rad of each point's track to the next track, infinite where there is none. Of unit vectors
    (n, 3) in the order flown: the tangents of flight (n, 3), the way flown so far in rad (n,), the path's number (n,).
    Rules: round about, abeam, parallel, same track in rad, one-sided; see pitch.py."""

def coarsest_pitch(unit: NDArray[np.float64], pitch: NDArray[np.float64], factor: float) -> NDArray[np.float64]:
    """The largest (n,) of a point's pitch and the pitches of those neighbours in the triangulation of its hemisphere
    that are no farther than `factor` times theirs."""

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
