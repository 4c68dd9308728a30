"""peak_fit.py: least squares of a Gaussian on a plane ground, and how its parameters follow each value."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

FloatArray = NDArray[np.float64]

_RING = 0.85  # of the radius: outside, only ground is expected


@dataclass(frozen=True)
class Fit:
    """Parameters in rad and 1/sr. `operator` (7, n): change of (height, x0, y0, sigma, plane (3)) per change of each
    value, to first order: the pseudo-inverse of the weighted Jacobian. `residual` (n,): values less model."""

    height: float
    x0: float
    y0: float
    sigma: float
    plane: FloatArray
    operator: FloatArray
    residual: FloatArray


def fit_peak(x: FloatArray, y: FloatArray, dsf: FloatArray, weight: FloatArray) -> Fit | None:
    """DSF (n,) at places x, y (n,) with solid angles as weights (n,), started from the moments above the rim's plane;
    None where nothing stands above it."""
    plane, _ = ground_of_rim(x, y, dsf, weight)
    above = np.maximum(dsf - plane[0] - plane[1] * x - plane[2] * y, 0.0) * weight
    total = float(above.sum())
    if not total > 0.0:
        return None
    x0, y0 = float(above @ x) / total, float(above @ y) / total
    sigma = float(np.sqrt(0.5 * (above @ ((x - x0) ** 2 + (y - y0) ** 2)) / total))
    if not sigma > 0.0:  # a single point stands above the ground
        return None
    height = total / (2.0 * np.pi * sigma**2)
    root = np.sqrt(weight)
    scale = np.array([height, sigma, sigma, sigma, height, height / sigma, height / sigma])

    def residual(p: FloatArray) -> FloatArray:
        return np.asarray(root * (_model(p * scale, x, y) - dsf) / height)

    def slope(p: FloatArray) -> FloatArray:
        return np.asarray(_jacobian(p * scale, x, y) * (root / height)[:, None] * scale)

    start = np.array([height, x0, y0, sigma, *plane]) / scale
    found = least_squares(residual, start, jac=slope, method="lm")
    if not found.success or found.x[0] <= 0.0:
        return None
    p = found.x * scale
    p[3] = abs(p[3])
    jacobian = _jacobian(p, x, y) * scale
    operator = np.linalg.pinv(jacobian * root[:, None]) * root * scale[:, None]
    h, px, py, s = (float(v) for v in p[:4])
    return Fit(h, px, py, s, p[4:], operator, dsf - _model(p, x, y))


def ground_of_rim(x: FloatArray, y: FloatArray, dsf: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane (3,) through the outermost ring by weighted least squares, and its change (3, n) per change of each
    value."""
    radius = np.hypot(x, y)
    ring = np.flatnonzero(radius > _RING * radius.max())
    root = np.sqrt(weight[ring])
    size = radius.max()
    design = np.stack((np.ones(len(ring)), x[ring] / size, y[ring] / size), axis=1)
    operator = np.zeros((3, len(x)))
    operator[:, ring] = np.linalg.pinv(design * root[:, None]) * root / np.array([1.0, size, size])[:, None]
    return operator @ dsf, operator


def _model(p: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    h, px, py, s, g0, gx, gy = p
    return np.asarray(h * np.exp(-0.5 * ((x - px) ** 2 + (y - py) ** 2) / s**2) + g0 + gx * x + gy * y)


def _jacobian(p: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    h, px, py, s, *_ = p
    dx, dy = (x - px) / s, (y - py) / s
    lobe = np.exp(-0.5 * (dx**2 + dy**2))
    columns = (lobe, h * lobe * dx / s, h * lobe * dy / s, h * lobe * (dx**2 + dy**2) / s, np.ones_like(x), x, y)
    return np.stack(columns, axis=1)
