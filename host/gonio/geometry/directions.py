"""directions.py: polar angles and unit vectors in the sample frame, and the directions scattering is named after."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def unit_from_angles_deg(theta_deg: ArrayLike, phi_deg: ArrayLike) -> FloatArray:
    """Unit vectors (..., 3) of the polar angles theta (0-180 from +z) and phi (+x towards +y), broadcast together."""
    theta, phi = np.broadcast_arrays(np.radians(theta_deg), np.radians(phi_deg))
    sin_theta = np.sin(theta)
    return np.stack((sin_theta * np.cos(phi), sin_theta * np.sin(phi), np.cos(theta)), axis=-1)


def angles_deg_from_unit(v: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Polar angles of the vectors `v` (..., 3): theta in [0, 180], phi in [0, 360), both of shape (...).

    The length does not matter; theta is taken by arctan2 and so stays exact near the poles. At a pole phi is 0.
    """
    vector = np.asarray(v, dtype=np.float64)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    across = np.hypot(x, y)
    theta_deg = np.degrees(np.arctan2(across, z))
    phi_deg = fold_phi_deg(np.where(across > 0.0, np.degrees(np.arctan2(y, x)), 0.0))
    return theta_deg, phi_deg


def fold_phi_deg(phi_deg: ArrayLike) -> FloatArray:
    """Azimuth folded to [0, 360); a tiny negative angle, which `%` would round up to 360, becomes 0."""
    folded = np.mod(np.asarray(phi_deg, dtype=np.float64), 360.0)
    return np.where(folded >= 360.0, 0.0, folded)


def mirror(theta_deg: ArrayLike, phi_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Ideal mirror direction (theta, phi) of the incident direction (both in degrees)."""
    return np.asarray(theta_deg, dtype=np.float64) + 0.0, fold_phi_deg(np.add(phi_deg, 180.0))


def retro(theta_deg: ArrayLike, phi_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Ideal retro-reflection: the incident direction itself (both in degrees)."""
    return np.asarray(theta_deg, dtype=np.float64) + 0.0, fold_phi_deg(phi_deg)


def through(theta_deg: ArrayLike, phi_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Direction straight through the sample (both in degrees)."""
    return 180.0 - np.asarray(theta_deg, dtype=np.float64), fold_phi_deg(np.add(phi_deg, 180.0))


def angle_between_deg(u: ArrayLike, v: ArrayLike) -> FloatArray:
    """Angle between unit vectors (..., 3), broadcast together, exact for tiny angles and near 180 degrees.

    2 atan2(|u - v|, |u + v|), after W. Kahan, "How Futile are Mindless Assessments of Roundoff" (2006), section 12.
    """
    a, b = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
    angle_rad = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return np.asarray(np.degrees(angle_rad))


def tangent_frame(pole: ArrayLike) -> FloatArray:
    """Right-handed frame (3, 3), rows e1, e2, pole, about a unit vector (3,)."""
    axis = np.asarray(pole, dtype=np.float64)
    helper = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    e1 = np.cross(helper, axis)
    e1 /= np.linalg.norm(e1)
    return np.stack((e1, np.cross(axis, e1), axis))
