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
_BANDS_DEG = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 4.0)  # half widths about the plane of incidence, tried in turn
_SHOWN_DEG, _ENOUGH = 3.0, 0.85  # a band shows enough with this share of the bins that the widest one fills
_THIN_DEG, _MOST_PER_BIN = 0.5, 12


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


def plane_profile(d: Distribution) -> PlaneProfile:
    """Measured points near the plane of incidence, by angle, thinned to _MOST_PER_BIN per _THIN_DEG.

    The band about the plane is the narrowest that shows nearly as much of the plane as the widest one does.
    """
    units = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    phi = np.radians(d.incident_phi_deg)
    towards_mirror = np.array([-np.cos(phi), -np.sin(phi), 0.0])
    across = np.degrees(np.arcsin(np.clip(units @ np.array([np.sin(phi), -np.cos(phi), 0.0]), -1, 1)))
    angle = np.degrees(np.arctan2(units @ towards_mirror, units[:, 2]))
    distance = np.where(d.measured, np.abs(across), np.inf)

    def shown(band: float) -> int:
        return len(np.unique(np.floor(angle[distance <= band] / _SHOWN_DEG)))

    most = shown(_BANDS_DEG[-1])
    band = next(b for b in _BANDS_DEG if shown(b) >= _ENOUGH * most)
    index = np.flatnonzero(distance <= band)
    index = index[np.argsort(angle[index], kind="stable")]
    bins = np.floor(angle[index] / _THIN_DEG)
    _, first, count = np.unique(bins, return_index=True, return_counts=True)
    step = np.repeat(np.ceil(count / _MOST_PER_BIN), count)
    index = index[(np.arange(len(index)) - np.repeat(first, count)) % step == 0]
    return PlaneProfile(angle[index], d.dsf_per_sr[index], index, band)


def plane_directions(d: Distribution, angle_deg: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) of signed angles in the plane of incidence."""
    return unit_from_angles_deg(angle_deg, d.incident_phi_deg + 180.0)
