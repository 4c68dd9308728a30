"""test_polar_grid.py: images by nearest point, on functions whose value is known everywhere."""

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_bsdf import distribution, sphere_points

from gonio.geometry.directions import angles_deg_from_unit
from gonio.report.compare_figures import Shown
from gonio.report.polar_grid import hemisphere_picture, window_picture


def pixel(size: int, x: float, y: float) -> tuple[int, int]:
    """Row and column of a place in degrees from the pole."""
    return int((y / 90 + 1) / 2 * size), int((x / 90 + 1) / 2 * size)


@pytest.mark.parametrize("half", ["front", "back"])
def test_x_is_right_and_y_is_up(half) -> None:  # type: ignore[no-untyped-def]
    """DSF = 2 + x + y / 2 is largest to the right, then above."""
    d = distribution((0, 0), sphere_points(5000), lambda u: 2 + u[:, 0] + u[:, 1] / 2)
    image = hemisphere_picture(d, half, 200)
    assert image is not None
    for x, y in ((60.0, 0.0), (0.0, 60.0), (-60.0, 0.0), (0.0, -60.0), (30.0, 30.0)):
        r = np.radians(np.hypot(x, y))
        expected = 2 + np.sin(r) * (x + y / 2) / np.hypot(x, y)
        assert image.of(d.dsf_per_sr)[pixel(200, x, y)] == pytest.approx(expected, abs=0.05)
    assert np.isnan(image.of(d.dsf_per_sr)[0, 0])


def test_masked_and_missing_places_show_nothing() -> None:
    d = distribution((30, 0), sphere_points(5000), lambda u: np.ones(len(u)), masked_below_deg=10)
    image = hemisphere_picture(d, "front", 200)
    assert image is not None
    at_source, elsewhere = pixel(200, 30, 0), pixel(200, -30, 0)
    assert image.masked[at_source]
    assert np.isnan(image.of(d.dsf_per_sr)[at_source])
    assert not image.masked[elsewhere]
    assert image.of(d.dsf_per_sr)[elsewhere] == 1
    keep = d.theta_deg < 40
    for name in ("theta_deg", "phi_deg", "dsf_per_sr", "flags"):
        setattr(d, name, getattr(d, name)[keep])
    image = hemisphere_picture(d, "front", 200)
    assert image is not None
    assert np.isnan(image.of(d.dsf_per_sr)[pixel(200, -80, 0)])
    assert hemisphere_picture(d, "back") is None


@pytest.mark.parametrize(("theta", "phi"), [(30.0, 180.0), (150.0, 70.0), (0.0, 0.0)])
def test_a_window_is_turned_like_the_disc_around_it(theta: float, phi: float) -> None:
    """Pixels of a window hold the same directions as the disc's pixels at that place."""
    d = distribution((0, 0), sphere_points(20000), lambda u: 2 + u[:, 0] + u[:, 1] / 2)
    window = window_picture(d, theta, phi, 20.0, 80).of(d.dsf_per_sr)
    radius = theta if theta <= 90 else 180 - theta
    x, y = radius * np.cos(np.radians(phi)), radius * np.sin(np.radians(phi))
    whole = hemisphere_picture(d, "front" if theta <= 90 else "back", 360)
    assert whole is not None
    disc = whole.of(d.dsf_per_sr)
    for right, up in ((8.0, 0.0), (0.0, 8.0), (-8.0, -4.0), (0.0, 0.0)):
        here = window[int((up / 20 + 1) * 40), int((right / 20 + 1) * 40)]
        assert here == pytest.approx(disc[pixel(360, x + right, y + up)], abs=0.04)


def test_thinning_leaves_the_picture_as_it_is() -> None:
    """Many points per pixel: what a pixel shows is still a point within it."""
    units = sphere_points(400_000)
    d = distribution_of_many(units)
    picture = hemisphere_picture(d, "front", 120)
    assert picture is not None
    axis = (np.arange(120) + 0.5) / 120 * 180 - 90
    x, y = np.meshgrid(axis, axis)
    seen = (picture.index >= 0) & (np.hypot(x, y) < 89)
    theta, phi = d.theta_deg[picture.index], np.radians(d.phi_deg[picture.index])
    off = np.hypot(theta * np.cos(phi) - x, theta * np.sin(phi) - y)[seen]
    assert seen.sum() > 10_000
    assert off.max() < 1.5  # one pixel of 1.5 degrees


def distribution_of_many(units: NDArray[np.float64]) -> Shown:
    """Points without cells, which cost seconds for so many."""
    theta, phi = angles_deg_from_unit(units)
    return Shown(theta, phi, np.ones(len(units), dtype=np.bool_), 0.0, 0.0)
