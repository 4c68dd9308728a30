"""polar_grid.py: a distribution seen on a hemisphere: images by nearest point, and the scatter plane."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]
Half = Literal["front", "back"]

_REACH_FACTOR = 2.0  # a pixel farther than this many usual distances from any point shows nothing
_MOST_REACH_DEG = 10.0


@dataclass(frozen=True)
class HemisphereImage:
    """Square image, radius = angle from the pole, x to the right and y up as seen from the front."""

    dsf_per_sr: FloatArray  # (size, size), NaN where nothing is shown
    masked: NDArray[np.bool_]  # (size, size)


@dataclass(frozen=True)
class PlaneProfile:
    """Points near the plane of incidence. `angle_deg` (n,) is signed: positive on the mirror side, over 90 behind."""

    angle_deg: FloatArray
    dsf_per_sr: FloatArray
    index: NDArray[np.int64]  # of the points in the distribution
    band_deg: float  # half width of the band about the plane


def hemisphere_image(d: Distribution, half: Half, size: int = 320) -> HemisphereImage | None:
    """Nearest point's value per pixel; None when the hemisphere has no point at all."""
    here = d.theta_deg <= 90.0 if half == "front" else d.theta_deg > 90.0
    if not here.any():
        return None
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, axis)
    polar = 90.0 * np.hypot(x, y)
    inside = polar <= 90.0
    theta = polar[inside] if half == "front" else 180.0 - polar[inside]
    pixels = unit_from_angles_deg(theta, np.degrees(np.arctan2(y[inside], x[inside])))
    points = np.flatnonzero(here)
    distance, nearest = cKDTree(unit_from_angles_deg(d.theta_deg[points], d.phi_deg[points])).query(pixels)
    usual = float(np.quantile(distance, 0.9))
    reach = min(_REACH_FACTOR * usual, 2 * np.sin(np.radians(_MOST_REACH_DEG / 2)))
    near = distance <= max(reach, 1e-6)
    index = points[nearest]
    measured = d.measured[index]
    values = np.full((size, size), np.nan)
    masked = np.zeros((size, size), dtype=np.bool_)
    values[inside] = np.where(near & measured, d.dsf_per_sr[index], np.nan)
    masked[inside] = near & ~measured
    return HemisphereImage(values, masked)


def plane_profile(d: Distribution, band_deg: float = 0.6, least: int = 40) -> PlaneProfile:
    """Measured points within a band about the plane of incidence, by angle; the band grows until it holds `least`."""
    units = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    phi = np.radians(d.incident_phi_deg)
    towards_mirror = np.array([-np.cos(phi), -np.sin(phi), 0.0])
    across = np.degrees(np.arcsin(np.clip(units @ np.array([np.sin(phi), -np.cos(phi), 0.0]), -1, 1)))
    angle = np.degrees(np.arctan2(units @ towards_mirror, units[:, 2]))
    band = band_deg
    while band < 4.0 and np.count_nonzero(d.measured & (np.abs(across) <= band)) < least:
        band *= 1.5
    index = np.flatnonzero(d.measured & (np.abs(across) <= band))
    index = index[np.argsort(angle[index])]
    return PlaneProfile(angle[index], d.dsf_per_sr[index], index, band)


def plane_directions(d: Distribution, angle_deg: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) of signed angles in the plane of incidence."""
    return unit_from_angles_deg(angle_deg, d.incident_phi_deg + 180.0)
