"""hemisphere.py: the frame in which one component is modelled: both directions folded to the upper hemisphere.

A component is light that arrives at one side of the sample and leaves from one side. Its frame takes |z| of both
directions and keeps x and y, so that mirror reflection and straight transmission are the same: (-x_i, -y_i, z_i).
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What stays where it is while the incident direction moves: the sample ("fixed"), the mirror or straight-through
# direction ("opposite"), the retro direction ("same"; in transmission the direction mirrored at the sample's plane).
Follows = Literal["fixed", "opposite", "same"]


def folded(unit: FloatArray) -> FloatArray:
    """Unit vectors (..., 3) with |z|."""
    result = np.array(unit, dtype=np.float64)
    result[..., 2] = np.abs(result[..., 2])
    return result


def ideal(follows: Follows, incident: FloatArray) -> FloatArray:
    """Direction (..., 3) that a lobe of this kind would have; incident (..., 3) folded. "fixed": the normal."""
    if follows == "same":
        return np.array(incident, dtype=np.float64)
    if follows == "opposite":
        return np.asarray(incident * np.array([-1.0, -1.0, 1.0]))
    return np.broadcast_to(np.array([0.0, 0.0, 1.0]), np.shape(incident)).copy()


def disc_from_unit(unit: FloatArray) -> FloatArray:
    """Lambert's equal-area disc (..., 2) of unit vectors (..., 3) with z >= 0: radius 1 is the horizon."""
    return np.asarray(unit[..., :2] / np.sqrt(1.0 + unit[..., 2:3]))


def unit_from_disc(disc: FloatArray) -> FloatArray:
    """Inverse of `disc_from_unit`; outside the disc: the horizon in that azimuth."""
    r2 = np.sum(disc**2, axis=-1, keepdims=True)
    inside = np.minimum(r2, 1.0)
    across = disc / np.sqrt(np.maximum(r2, 1e-300)) * np.sqrt(inside * (2.0 - inside))
    return np.concatenate((across, 1.0 - inside), axis=-1)


def tangent_axes(centre: FloatArray) -> FloatArray:
    """Rows e1, e2, centre (..., 3, 3) about unit vectors (..., 3): e1 towards growing theta, e2 towards growing phi.

    At the pole e1 is +x.
    """
    x, y, z = centre[..., 0], centre[..., 1], centre[..., 2]
    across = np.hypot(x, y)
    at_pole = across < 1e-12
    cos_phi = np.where(at_pole, 1.0, x / np.where(at_pole, 1.0, across))
    sin_phi = np.where(at_pole, 0.0, y / np.where(at_pole, 1.0, across))
    e1 = np.stack((z * cos_phi, z * sin_phi, -across), axis=-1)
    e2 = np.stack((-sin_phi, cos_phi, np.zeros_like(sin_phi)), axis=-1)
    return np.stack((e1, e2, centre), axis=-2)


def tangent_from_unit(axes: FloatArray, unit: FloatArray) -> FloatArray:
    """Azimuthal equidistant coordinates (m, 2) [rad] of unit vectors (m, 3) about axes (3, 3): length = angle."""
    local = unit @ axes.T
    across = np.hypot(local[:, 0], local[:, 1])
    angle = np.arctan2(across, local[:, 2])
    return np.asarray(local[:, :2] * (angle / np.maximum(across, 1e-300))[:, None])
