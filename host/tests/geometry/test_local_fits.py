"""test_local_fits.py: gradients, curvature and their noise against a lobe in closed form."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.local_fit import local_fit
from gonio.plan.spiral import spiral

FloatArray = NDArray[np.float64]
CENTRE = unit_from_angles_deg(50.0, 20.0)
SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def lobe(unit: FloatArray, sigma: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """f = exp((u.c - 1) / sigma^2) on the sphere: value, gradient f g / sigma^2 and covariant Hessian
    f (g g / sigma^4 - (u.c) P / sigma^2), g being c's part along the sphere and P the projection on it."""
    cosine = unit @ CENTRE
    value = np.exp((cosine - 1.0) / sigma**2)
    g = CENTRE - cosine[:, None] * unit
    gradient = value[:, None] * g / sigma**2
    hessian = [
        value * (g[:, i] * g[:, j] / sigma**4 - cosine * ((i == j) - unit[:, i] * unit[:, j]) / sigma**2)
        for i, j in SYMMETRIC
    ]
    return value, gradient, np.stack(hessian, axis=1)


def flown(along_deg: float = 0.03, pitch_deg: float = 0.1) -> FloatArray:
    track = spiral(CENTRE, 2.0, pitch_deg)
    along = np.arange(0.0, track.length_deg[-1], along_deg)
    points = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    return np.asarray(points / np.linalg.norm(points, axis=1)[:, None])


def worst(found: FloatArray, true: FloatArray, where: NDArray[np.bool_]) -> float:
    """Largest error as a share of the largest truth."""
    return float(np.abs(found - true)[where].max() / np.abs(true).max())


def test_gradient_and_curvature_of_a_lobe_on_a_spiral() -> None:
    points = flown()
    inner = np.degrees(np.arccos(np.clip(points @ CENTRE, -1.0, 1.0))) < 1.6
    value, gradient, hessian = lobe(points, np.radians(0.4))
    fit = local_fit(points, value, np.ones(len(points)), np.ones(len(points), dtype=bool), np.radians(0.3))
    assert worst(fit.value, value, inner) < 0.005
    assert worst(fit.gradient, gradient, inner) < 0.02
    assert worst(fit.hessian, hessian, inner) < 0.12
    # Tangent: nothing along the direction itself.
    assert np.abs(np.einsum("ij,ij->i", fit.gradient, points)).max() < 1e-9 * np.abs(gradient).max()


def test_a_coarse_track_is_fitted_over_its_neighbours() -> None:
    """Samples every 0.05 degrees on circles 4 degrees apart: a fit needs three circles, however many samples."""
    elevation, azimuth = np.meshgrid(np.arange(-20.0, 20.1, 4.0), np.arange(0.0, 90.0, 0.05), indexing="ij")
    points = unit_from_angles_deg(90.0 - elevation.ravel(), azimuth.ravel())
    sigma = np.radians(25.0)
    value, gradient, _ = lobe(points, sigma)
    fit = local_fit(points, value, np.ones(len(points)), np.ones(len(points), dtype=bool), np.radians(0.3))
    inner = (np.abs(elevation.ravel()) < 15.0) & (azimuth.ravel() > 10.0) & (azimuth.ravel() < 80.0)
    assert worst(fit.gradient, gradient, inner) < 0.02


@pytest.mark.parametrize("radius_deg", [0.3, 0.6])
def test_gradient_variance_is_that_of_repeats(radius_deg: float) -> None:
    points = flown()[:4000]
    rng = np.random.default_rng(7)
    sigma = rng.uniform(0.5, 2.0, len(points))
    used = np.ones(len(points), dtype=bool)
    repeats = []
    for _ in range(60):
        noise = sigma * rng.standard_normal(len(points))
        fit = local_fit(points, noise, sigma**2, used, np.radians(radius_deg))
        repeats.append(fit.gradient)
    # The two components along the sphere: their mean variance is half that of the vector.
    seen = 0.5 * np.var(np.stack(repeats), axis=0, ddof=1).sum(axis=1)
    assert np.median(seen / fit.gradient_variance) == pytest.approx(1.0, rel=0.06)
    assert np.mean(seen) == pytest.approx(np.mean(fit.gradient_variance), rel=0.06)


def test_unused_points_tell_nothing() -> None:
    points = flown()
    value, gradient, _ = lobe(points, np.radians(0.4))
    spoilt = value.copy()
    used = np.random.default_rng(8).random(len(points)) > 0.2
    spoilt[~used] = 1e6
    spoilt[: len(points) // 50] = np.nan  # counts as not used
    fit = local_fit(points, spoilt, np.ones(len(points)), used, np.radians(0.3))
    ring = np.degrees(np.arccos(np.clip(points @ CENTRE, -1.0, 1.0)))
    assert worst(fit.gradient, gradient, (ring > 0.7) & (ring < 1.6)) < 0.03


def test_too_few_points_give_none() -> None:
    points = flown()[:2000:200]
    fit = local_fit(points, np.ones(10), np.ones(10), np.ones(10, dtype=bool), np.radians(0.3))
    assert np.isnan(fit.value).all()
    assert np.isnan(fit.gradient).all()
    assert np.isnan(fit.gradient_variance).all()
    in_a_plane = unit_from_angles_deg(np.arange(0.0, 80.0, 0.1), 20.0)
    fit = local_fit(in_a_plane, np.ones(800), np.ones(800), np.ones(800, dtype=bool), np.radians(0.3))
    assert np.isnan(fit.gradient).all()
    assert local_fit(np.zeros((0, 3)), [], [], [], 0.01).gradient.shape == (0, 3)
