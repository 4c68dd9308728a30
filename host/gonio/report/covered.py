"""covered.py: values over the part of a hemisphere that the points cover: 0:45 and reflectance up to the outermost."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg

_BAND_DEG = 2.0
_LEVELS, _AZIMUTHS = 90, 360


@dataclass(frozen=True)
class CoveredReflectance:
    """Integral of the DSF from the normal to `limit_deg`; `share` of the cosine-weighted hemisphere lies inside."""

    value: float
    limit_deg: float
    share: float


def covered_reflectance(d: Distribution) -> CoveredReflectance:
    """Reflectance over the covered part of the incident hemisphere, each direction taking its nearest point's BSDF.

    The outermost measured point limits the integral; nothing is added beyond. For sparse tables: in a sum of DSF times
    solid angle their outer cells would reach to the horizon.
    """
    polar = d.theta_deg if d.incident_theta_deg <= 90 else 180.0 - d.theta_deg
    used = d.measured & (polar < 90.0)
    if not used.any():
        return CoveredReflectance(0.0, 0.0, 0.0)
    limit_deg = float(polar[used].max())
    share = float(np.sin(np.radians(limit_deg)) ** 2)
    # Directions of equal projected solid angle: the mean BSDF times pi times the share is the integral.
    levels = np.degrees(np.arcsin(np.sqrt(share * (np.arange(_LEVELS) + 0.5) / _LEVELS)))
    azimuths = (np.arange(_AZIMUTHS) + 0.5) * 360.0 / _AZIMUTHS
    grid = unit_from_angles_deg(levels[:, None], azimuths[None, :]).reshape(-1, 3)
    nearest = cKDTree(unit_from_angles_deg(polar[used], d.phi_deg[used])).query(grid)[1]
    bsdf = d.dsf_per_sr[used] / np.cos(np.radians(polar[used]))
    return CoveredReflectance(float(np.pi * share * np.mean(bsdf[nearest])), limit_deg, share)


def zero_forty_five(d: Distribution) -> float | None:
    """pi times the mean BSDF within 2 degrees of theta_s = 45 degrees, incidence normal; None if not measured."""
    near = d.measured & (np.abs(d.theta_deg - 45.0) <= _BAND_DEG)
    if d.incident_theta_deg > 1.0 or not near.any():
        return None
    return float(np.pi * np.mean(d.dsf_per_sr[near] / np.cos(np.radians(d.theta_deg[near]))))
