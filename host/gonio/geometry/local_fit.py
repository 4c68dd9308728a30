"""local_fit.py: gradient and curvature of a scattered function of direction, from a polynomial about each point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.geometry.backend import sphere

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LocalFit:
    """The fitted polynomial at each of n points; NaN where too few points are around.

    value (n,). gradient (n, 3): tangent vector, per rad. hessian (n, 6): second covariant derivative as xx yy zz xy xz
    yz of a symmetric tangent matrix, per rad^2. gradient_variance (n,): the noise variance of one component of the
    gradient along the sphere, the mean of both.
    """

    value: FloatArray
    gradient: FloatArray
    hessian: FloatArray
    gradient_variance: FloatArray


def local_fit(unit: ArrayLike, values: ArrayLike, variance: ArrayLike, used: ArrayLike, radius_rad: float) -> LocalFit:
    """Least squares of a cubic to the `values` (n,) of the `used` (n,) bool points around each of `unit` (n, 3).

    Points are first averaged in cells of 0.4 times the radius, so that samples which crowd along a track count no more
    than others; a cell's mean is compared with the mean of the polynomial over the cell's points, so averaging does
    not smooth. Cells count by (1 - (distance / radius)^2)^2. Fewer than 16 cells, or cells that do not fix a cubic,
    give a quadratic. Where fewer than 12 cells lie within the radius, or they do not fix a quadratic, twice the radius
    is tried; then radius and cells grow by the root of 2, up to 32 times. `variance` (n,) of the values is carried to
    the gradient; points without finite value and variance are not used.
    """
    points = np.ascontiguousarray(unit, dtype=np.float64).reshape(-1, 3)
    value, noise = (np.ascontiguousarray(column, dtype=np.float64) for column in (values, variance))
    chosen = np.asarray(used, dtype=bool) & np.isfinite(value) & np.isfinite(noise)
    return LocalFit(*sphere.local_fit(points, value, noise, np.ascontiguousarray(chosen), float(radius_rad)))
