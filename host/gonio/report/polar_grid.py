"""polar_grid.py: a distribution seen as an image: the nearest point of every pixel of a hemisphere or of a window."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.geometry.directions import unit_from_angles_deg
from gonio.report.drawing import HALVES, Half, Placed, on_disc

FloatArray = NDArray[np.float64]

_REACH_FACTOR = 2.0  # a pixel farther than this many usual distances from any point shows nothing
_MOST_REACH_DEG = 10.0
_WINDOW_REACH_DEG = 3.0  # a window may be finer flown in its middle than at its rim


@dataclass(frozen=True)
class Picture:
    """Square image, rows from below. Of a hemisphere: radius = angle from the pole, x to the right and y up as seen
    from the front."""

    index: NDArray[np.int64]  # (size, size) the point that a pixel shows, -1 where nothing is near
    masked: NDArray[np.bool_]  # (size, size) the point is masked

    def of(self, values: FloatArray) -> FloatArray:
        """Values (n,) of the distribution's points as an image (size, size), NaN where nothing is shown."""
        return np.where((self.index >= 0) & ~self.masked, values[self.index], np.nan)


def hemisphere_picture(d: Placed, half: Half, size: int = 360) -> Picture | None:
    """None when the hemisphere has no point at all."""
    here = d.theta_deg <= 90.0 if half == "front" else d.theta_deg > 90.0
    if not here.any():
        return None
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, axis)
    polar = 90.0 * np.hypot(x, y)
    inside = polar <= 90.0
    theta = polar[inside] if half == "front" else 180.0 - polar[inside]
    pixels = unit_from_angles_deg(theta, np.degrees(np.arctan2(y[inside], x[inside])))
    return _nearest(d, _thinned(d, np.flatnonzero(here), 45.0 / size), pixels, inside)


def hemisphere_pictures(d: Placed) -> dict[Half, Picture]:
    """Of the hemispheres that hold points."""
    return {half: picture for half in HALVES if (picture := hemisphere_picture(d, half)) is not None}


def window_picture(d: Placed, theta_deg: float, phi_deg: float, half_width_deg: float, size: int = 160) -> Picture:
    """The surroundings of a direction, turned as the hemisphere's disc shows them there."""
    centre = unit_from_angles_deg(theta_deg, phi_deg)
    right, up = _disc_axes(theta_deg, phi_deg)
    axis = np.radians(((np.arange(size) + 0.5) / size * 2 - 1) * half_width_deg)
    x, y = np.meshgrid(axis, axis)
    angle = np.hypot(x, y)
    along = np.divide(np.sin(angle), angle, out=np.ones_like(angle), where=angle > 0)[..., None]
    pixels = np.cos(angle)[..., None] * centre + along * (x[..., None] * right + y[..., None] * up)
    units = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    here = np.flatnonzero(units @ centre > np.cos(np.radians(min(2.0 * half_width_deg + 1.0, 90.0))))
    return _nearest(d, here, pixels.reshape(-1, 3), np.ones((size, size), dtype=np.bool_), _WINDOW_REACH_DEG)


def _thinned(d: Placed, points: NDArray[np.int64], step_deg: float) -> NDArray[np.int64]:
    """The first of the points in each square of a fine raster on the disc."""
    x, y = on_disc(d.theta_deg[points], d.phi_deg[points])
    row = np.floor((y + 91.0) / step_deg).astype(np.int64)
    column = np.floor((x + 91.0) / step_deg).astype(np.int64)
    _, first = np.unique(row * (int(182.0 / step_deg) + 2) + column, return_index=True)
    return points[first]


def _disc_axes(theta_deg: float, phi_deg: float) -> tuple[FloatArray, FloatArray]:
    """Unit tangents at a direction that point right and up on the hemisphere's disc."""
    phi = np.radians(phi_deg)
    outward = unit_from_angles_deg(theta_deg + (90.0 if theta_deg <= 90.0 else -90.0), phi_deg)
    round_ = np.array([-np.sin(phi), np.cos(phi), 0.0])
    right = np.cos(phi) * outward - np.sin(phi) * round_
    up = np.sin(phi) * outward + np.cos(phi) * round_
    return right, up


def _nearest(
    d: Placed,
    points: NDArray[np.int64],
    pixels: FloatArray,
    inside: NDArray[np.bool_],
    least_reach_deg: float = 1e-4,
) -> Picture:
    index = np.full(inside.shape, -1, dtype=np.int64)
    masked = np.zeros(inside.shape, dtype=np.bool_)
    if len(points):
        tree = cKDTree(unit_from_angles_deg(d.theta_deg[points], d.phi_deg[points]), balanced_tree=False)
        distance, nearest = tree.query(pixels)
        usual = float(np.quantile(distance, 0.9))
        reach = min(_REACH_FACTOR * usual, 2 * np.sin(np.radians(_MOST_REACH_DEG / 2)))
        found = points[nearest]
        near = distance <= max(reach, np.radians(least_reach_deg))
        index[inside] = np.where(near, found, -1)
        masked[inside] = near & ~d.measured[found]
    return Picture(index, masked)
