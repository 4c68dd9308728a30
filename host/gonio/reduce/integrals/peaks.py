"""peaks.py: direction, width and integral of a peak from the spiral flown about it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from gonio.geometry.cells import disc_solid_angles_sr
from gonio.geometry.directions import angles_deg_from_unit, tangent_frame

FloatArray = NDArray[np.float64]
_Place = TypeVar("_Place", float, NDArray[np.float64])

_LEAST_POINTS = 50
_MASKED_MOST = 0.1  # of the disc: with more masked, width and integral would be guesses
_RING = 0.85  # of the radius: outside, only ground is expected
_MISFIT_MOST = 0.1  # of the peak: with more the peak is no Gaussian, and its fit's ground makes up for the shape


@dataclass(frozen=True)
class Peak:
    """A Gaussian on a plane ground, fitted by least squares with solid angles as weights; what beam and aperture add to
    its width is still in it."""

    theta_deg: float
    phi_deg: float
    height_per_sr: float  # above the ground
    sigma_deg: float
    integral: float  # sum of (DSF - ground) Omega over the disc; of a peak that is no Gaussian: ground of the rim
    ground_per_sr: float  # at the peak
    solid_angle_sr: float  # of the disc
    masked_share: float

    def named(self, name: str) -> dict[str, float]:
        """As entries of Distribution.integrals: "peak NAME theta_deg" and so on."""
        fields = ("theta_deg", "phi_deg", "height_per_sr", "sigma_deg", "integral", "ground_per_sr", "masked_share")
        return {f"peak {name} {field}": float(getattr(self, field)) for field in fields}


def measure_peak(unit: FloatArray, dsf_per_sr: FloatArray, used: NDArray[np.bool_]) -> Peak | None:
    """The peak in a spiral's points in the order they were flown: directions (n, 3), DSF (n,), which count (n,).

    None where too few points are usable or nothing stands above the ground.
    """
    if len(unit) < _LEAST_POINTS:
        return None
    pole = unit.sum(axis=0)
    pole /= np.linalg.norm(pole)
    omega = disc_solid_angles_sr(unit, pole)
    masked_share = float(omega[~used].sum() / omega.sum())
    if used.sum() < _LEAST_POINTS or masked_share > _MASKED_MOST:
        return None
    frame = tangent_frame(pole)
    x, y = _equidistant(unit[used], frame)
    dsf, weight = dsf_per_sr[used], omega[used]
    fit = _fit(x, y, dsf, weight)
    if fit is None:
        return None
    height, x0, y0, sigma, *plane = fit
    lobe = height * np.exp(-0.5 * ((x - x0) ** 2 + (y - y0) ** 2) / sigma**2)
    ring = _ground(x, y, dsf, weight)
    misfit = np.abs(dsf - lobe - _plane(plane, x, y)) @ weight
    if misfit > _MISFIT_MOST * (np.abs(dsf - _plane(ring, x, y)) @ weight):
        plane = list(ring)
    radius = float(np.hypot(x0, y0))
    across = np.sin(radius) / radius if radius > 0.0 else 1.0
    top = across * (x0 * frame[0] + y0 * frame[1]) + np.cos(radius) * frame[2]
    theta_deg, phi_deg = angles_deg_from_unit(top)
    return Peak(
        theta_deg=float(theta_deg),
        phi_deg=float(phi_deg),
        height_per_sr=height,
        sigma_deg=float(np.degrees(sigma)),
        integral=float((dsf - _plane(plane, x, y)) @ weight),
        ground_per_sr=float(_plane(plane, x0, y0)),
        solid_angle_sr=float(omega.sum()),
        masked_share=masked_share,
    )


def _equidistant(unit: FloatArray, frame: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane coordinates in radians whose length is the angle from the frame's pole (azimuthal equidistant map)."""
    a, b = unit @ frame[0], unit @ frame[1]
    across = np.hypot(a, b)
    scale = np.where(across > 1e-12, np.arctan2(across, unit @ frame[2]) / np.maximum(across, 1e-12), 1.0)
    return a * scale, b * scale


def _plane(plane: Sequence[float] | FloatArray, x: _Place, y: _Place) -> _Place:
    """Its value at a place, or at each of many."""
    return plane[0] + plane[1] * x + plane[2] * y


def _ground(x: FloatArray, y: FloatArray, dsf: FloatArray, weight: FloatArray) -> FloatArray:
    """Plane (3,) through the outermost ring, by weighted least squares."""
    radius = np.hypot(x, y)
    ring = radius > _RING * radius.max()
    root = np.sqrt(weight[ring])
    design = np.stack((np.ones(ring.sum()), x[ring], y[ring]), axis=1)
    solution: FloatArray = np.linalg.lstsq(design * root[:, None], dsf[ring] * root, rcond=None)[0]
    return solution


def _fit(x: FloatArray, y: FloatArray, dsf: FloatArray, weight: FloatArray) -> list[float] | None:
    """Height, x0, y0, sigma and the ground's plane (3), started from the moments above the ring's plane."""
    plane = _ground(x, y, dsf, weight)
    above = np.maximum(dsf - _plane(plane, x, y), 0.0) * weight
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
        h, px, py, s, g0, gx, gy = p * scale
        lobe = h * np.exp(-0.5 * ((x - px) ** 2 + (y - py) ** 2) / s**2)
        return np.asarray(root * (lobe + g0 + gx * x + gy * y - dsf) / height)

    def slope(p: FloatArray) -> FloatArray:
        h, px, py, s, *_ = p * scale
        dx, dy = (x - px) / s, (y - py) / s
        lobe = np.exp(-0.5 * (dx**2 + dy**2))
        columns = (lobe, h * lobe * dx / s, h * lobe * dy / s, h * lobe * (dx**2 + dy**2) / s, np.ones_like(x), x, y)
        return np.asarray(np.stack(columns, axis=1) * (root / height)[:, None] * scale)

    start = np.array([height, x0, y0, sigma, *plane]) / scale
    found = least_squares(residual, start, jac=slope, method="lm")
    if not found.success or found.x[0] <= 0.0:
        return None
    values = [float(v) for v in found.x * scale]
    values[3] = abs(values[3])
    return values
