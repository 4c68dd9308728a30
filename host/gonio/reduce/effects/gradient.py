"""gradient.py: slope and curvature of a measured distribution at every point, as errors of angle feel them."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.local_fit import LocalFit, local_fit
from gonio.reduce.points import Points

FloatArray = NDArray[np.float64]

# One track on either side counts: enough cells for the fit not to double its radius, which would blur a lobe that only
# a few tracks cross.
_PITCHES = 1.8
_COVERS = 1.5  # pitches from its points, as far as cells reach, a path's fit counts for the points of others
# Nothing that was measured is narrower than the aperture: half its radius keeps the curvature of the narrowest peak.
_APERTURES = 0.5
# Points this much nearer along the track than the fit is wide tell nothing more one by one: means of them are fitted
# (local_fit averages in cells of 0.4 radii itself, but answers at every point that it is given).
_RUNS_PER_RADIUS = 4.0
_LINEAR_UP_TO = 0.3  # times the median of a path
_NEIGHBOURS = 16
_STEEPER = 2.0  # than the steepest difference quotient between a run and its neighbours no slope is


@dataclass(frozen=True)
class Slope:
    """Fits at m places: directions (m, 3), gradients (m, 3) [1/sr per rad, tangent], their noise variance (m,) per
    component, second derivatives (m, 6), xx yy zz xy xz yz [1/sr per rad^2, tangent]; and the fit (n,) of each point.
    The last fit is all 0: of points of which nothing can be said, masked ones or too few."""

    unit: FloatArray
    gradient: FloatArray
    gradient_variance: FloatArray
    hessian: FloatArray
    of_point: NDArray[np.intp]

    def at(self, unit: FloatArray, own: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gradients (k, 3), their variances (k,) and second derivatives (k, 6) of the points `own` (a slice or
        indices), whose directions are `unit` (k, 3)."""
        fit = self.of_point[own]
        hessian = self.hessian[fit]
        # The slope at the point itself, not at the middle of the run of points that was fitted.
        gradient = self.gradient[fit] + contracted(hessian, unit - self.unit[fit])
        return gradient, self.gradient_variance[fit], hessian


def slope_of(points: Points, distribution: Distribution, aperture_rad: float) -> Slope:
    """`points` and `distribution` are the same n points, the latter with their cells; `aperture_rad` is the angular
    radius of the aperture.

    Every path is fitted on its own, at the scale of its tracks. Where a finer path covers what a coarser one crosses,
    the finer one's fit counts for both, and the coarser one's few points on a peak tell nothing about its surroundings.
    """
    of_point = np.full(len(points.path), -1, dtype=np.intp)
    fits: list[tuple[FloatArray, ...]] = []
    before = 0
    open_points = distribution.measured & (points.path >= 0)
    radius_rad = {
        int(path): max(_PITCHES * _pitch_rad(points, distribution, path), _APERTURES * aperture_rad)
        for path in np.unique(points.path[open_points])
    }
    for path, radius in sorted(radius_rad.items(), key=lambda item: item[1]):
        own = np.flatnonzero(open_points & (points.path == path))
        if not len(own):
            continue
        unit, value, variance, run = _runs(
            points.unit[own], distribution.dsf_per_sr[own], distribution.variance_per_sr2[own], radius
        )
        fit = _fit(unit, value, variance, radius)
        known = np.flatnonzero(np.isfinite(fit.gradient[:, 0]) & np.isfinite(fit.gradient_variance))
        if not len(known):
            continue
        tree, reach = cKDTree(unit[known]), radius * _COVERS / _PITCHES
        others = np.flatnonzero(open_points & (points.path != path))
        others = others[_within_cap(points.unit[others], unit[known], reach)]
        distance, nearest = tree.query(points.unit[others], distance_upper_bound=reach)
        reached = np.isfinite(distance)
        # At corners a run may have no fit of its own.
        of_run = np.full(len(unit), -1)
        of_run[known] = known
        lacking = of_run < 0
        of_run[lacking] = known[tree.query(unit[lacking])[1]]
        targets = np.concatenate((own, others[reached]))
        of_point[targets] = before + np.concatenate((of_run[run], known[nearest[reached]]))
        open_points[targets] = False
        fits.append((unit, fit.gradient, fit.gradient_variance, fit.hessian))
        before += len(unit)
    fits.append((np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(1), np.zeros((1, 6))))
    unit, gradient, variance, hessian = (np.concatenate(parts) for parts in zip(*fits, strict=True))
    return Slope(unit, gradient, variance, hessian, of_point)


def _within_cap(unit: FloatArray, around: FloatArray, reach_rad: float) -> NDArray[np.bool_]:
    """Which of `unit` (n, 3) lie in the smallest cap about the middle of `around` (k, 3) that holds everything within
    reach of it: the few that a search among them is worth."""
    middle = around.mean(axis=0)
    length = float(np.linalg.norm(middle))
    if length < 0.1:  # all round the sphere
        return np.ones(len(unit), dtype=bool)
    half_rad = float(np.arccos(np.clip((around @ middle).min() / length, -1.0, 1.0))) + reach_rad
    return np.asarray(unit @ middle >= length * np.cos(min(half_rad, np.pi)))


def _pitch_rad(points: Points, distribution: Distribution, path: int) -> float:
    """How far apart a path's tracks lie on average: the solid angle of its cells over its length."""
    own = np.flatnonzero(points.path == path)
    length = float(np.linalg.norm(np.diff(points.unit[own], axis=0), axis=1).sum())
    return float(distribution.solid_angle_sr[own].sum()) / length if length > 0.0 else 0.0


def _fit(unit: FloatArray, value: FloatArray, variance: FloatArray, radius_rad: float) -> LocalFit:
    """local_fit of y = asinh(f / s), turned back: grad f = s cosh(y) grad y, and the chain rule for the Hessian.

    A peak falls over decades within a few points, which no quadratic follows; its logarithm is one (of a Gaussian
    exactly). Below s y is linear in f: there noise may be negative, and a cosine ends at 0. With s under the median
    the last of a peak's flank, which ends on what is around it, is followed as well.
    """
    s = float(_LINEAR_UP_TO * np.median(np.abs(value)) + 4.0 * np.sqrt(np.median(variance))) or 1.0
    y = np.arcsinh(value / s)
    fit = local_fit(unit, y, variance / (s * np.cosh(y)) ** 2, np.ones(len(unit), dtype=bool), radius_rad)
    fit = _believable(fit, unit, y, radius_rad)
    rise, bend = (s * function(fit.value)[:, None] for function in (np.cosh, np.sinh))
    x, y, z = fit.gradient.T
    square = np.stack((x * x, y * y, z * z, x * y, x * z, y * z), axis=1)
    return LocalFit(
        s * np.sinh(fit.value),
        rise * fit.gradient,
        rise * fit.hessian + bend * square,
        rise[:, 0] ** 2 * fit.gradient_variance,
    )


def _believable(fit: LocalFit, unit: FloatArray, y: FloatArray, radius_rad: float) -> LocalFit:
    """The fit with slope and curvature no larger than differences between neighbours allow. At the border of a path
    there are points on one side only, and what a polynomial says of the other may be anything."""
    k = min(_NEIGHBOURS, len(unit))
    apart, near = cKDTree(unit).query(unit, k=k)
    apart, near = apart.reshape(len(unit), k), near.reshape(len(unit), k)
    with np.errstate(divide="ignore", invalid="ignore"):
        steepness = np.where(apart > radius_rad / 8.0, np.abs(y[near] - y[:, None]) / apart, 0.0).max(axis=1)
        slope_share = np.minimum(1.0, _STEEPER * steepness / np.linalg.norm(fit.gradient, axis=1))
        # A parabola that rises by h within a radius r has the difference quotient h / r and the curvature 2 h / r^2.
        bend_share = np.minimum(1.0, 2.0 * _STEEPER * steepness / (radius_rad * np.linalg.norm(fit.hessian, axis=1)))
    return replace(fit, gradient=fit.gradient * slope_share[:, None], hessian=fit.hessian * bend_share[:, None])


def contracted(hessian: FloatArray, v: FloatArray) -> FloatArray:
    """Symmetric matrices (n, 6), xx yy zz xy xz yz, times vectors (n, 3)."""
    xx, yy, zz, xy, xz, yz = hessian.T
    x, y, z = v.T
    return np.stack((xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z), axis=1)


def _runs(
    unit: FloatArray, value: FloatArray, variance: FloatArray, radius_rad: float
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.intp]]:
    """Means of successive points (n,) of one path: directions, values, variances (m,), and the run (n,) of each."""
    step = np.linalg.norm(np.diff(unit, axis=0, prepend=unit[:1]), axis=1)
    place = np.floor(np.cumsum(step) * (_RUNS_PER_RADIUS / radius_rad))
    new = np.diff(place, prepend=-1.0) != 0
    start = np.flatnonzero(new)
    size = np.diff(start, append=len(place))
    middle = np.add.reduceat(unit, start, axis=0)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    mean, of_mean = (np.add.reduceat(column, start) / size for column in (value, variance))
    return middle, mean, of_mean / size, np.cumsum(new) - 1
