"""frames.py: tangent coordinates that turn as little as possible over the hemisphere, and symmetric 2 x 2 matrices.

The axes at a direction are the sample's x and y, turned with the normal along the great circle to it. They have no pole
in the hemisphere, unlike growing theta and phi, so that lobes may be interpolated across the normal. Where a sample is
turned by 180 degrees about its normal or mirrored at x = 0 or y = 0, coordinates in them only change sign.
"""

import numpy as np
from numpy.typing import NDArray

from gonio.model.hemisphere import tangent_axes

FloatArray = NDArray[np.float64]


def level_axes(centre: FloatArray) -> FloatArray:
    """Rows e1, e2, centre (..., 3, 3) about unit vectors (..., 3), z > -1: x, y, z turned by the shortest way."""
    x, y, z = centre[..., 0], centre[..., 1], centre[..., 2]
    scale = 1.0 / np.maximum(1.0 + z, 1e-9)
    e1 = np.stack((1.0 - x * x * scale, -x * y * scale, -x), axis=-1)
    e2 = np.stack((-x * y * scale, 1.0 - y * y * scale, -y), axis=-1)
    return np.stack((e1, e2, centre), axis=-2)


def tangents(axes: FloatArray, unit: FloatArray) -> FloatArray:
    """Azimuthal equidistant coordinates (..., 2) [rad] of unit vectors (..., 3) about axes (..., 3, 3), pairwise."""
    local = np.einsum("...ij,...j->...i", axes, unit)
    across = np.hypot(local[..., 0], local[..., 1])
    angle = np.arctan2(across, local[..., 2])
    stretch = np.where(across > 1e-12, angle / np.maximum(across, 1e-300), 1.0)
    return np.asarray(local[..., :2] * stretch[..., None])


def along_tangents(axes: FloatArray, tangent: FloatArray) -> FloatArray:
    """Unit vectors (..., 3) at coordinates (..., 2) about axes (..., 3, 3): the inverse of `tangents`."""
    angle = np.hypot(tangent[..., 0], tangent[..., 1])[..., None]
    local = np.concatenate((tangent * np.sinc(angle / np.pi), np.cos(angle)), axis=-1)
    return np.asarray(np.einsum("...ji,...j->...i", axes, local))


def level_covariance(centre: FloatArray, covariance: FloatArray) -> FloatArray:
    """Covariance (2, 2) about growing theta and phi (hemisphere.tangent_axes), in level axes."""
    turn = level_axes(centre)[:2] @ tangent_axes(centre)[:2].T
    return np.asarray(turn @ covariance @ turn.T)


def symmetric_function(matrix: FloatArray, function: np.ufunc) -> FloatArray:
    """A function of the eigenvalues of symmetric matrices (..., 2, 2): np.log, np.exp."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray(np.einsum("...ij,...j,...kj->...ik", vectors, function(values), vectors))
