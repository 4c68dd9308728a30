"""test_report_maps.py: colours that read in grey, scales that say what they cannot show, who dominates where."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import Colormap, to_rgb
from numpy.typing import NDArray
from synthetic_bsdf import distribution, sphere_points

from gonio.report.drawing import (
    BELOW,
    CATEGORY_COLOURS,
    CATEGORY_HATCHES,
    DSF_MAP,
    LINE_COLOURS,
    RELATIVE_MAP,
    diverging_map,
    dsf_map,
)
from gonio.report.path_figure import path_figure
from gonio.report.polar_grid import hemisphere_pictures
from gonio.report.polar_map import log_scale, polar_maps, scale_words
from gonio.report.uncertainty_map import dominance, relative_u, uncertainty_map


def lightness(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """CIE L* (0 to 100) of sRGB colours (n, 3): what a grey print shows."""
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    y = linear @ np.array([0.2126, 0.7152, 0.0722])
    return np.where(y > 0.008856, 116 * np.cbrt(y) - 16, 903.3 * y)


def of_map(colours: Colormap | str, count: int = 256) -> NDArray[np.float64]:
    found = mpl.colormaps[colours] if isinstance(colours, str) else colours
    return lightness(np.asarray(found(np.linspace(0, 1, count)))[:, :3])


@pytest.mark.parametrize("name", [DSF_MAP, RELATIVE_MAP])
def test_sequential_maps_grow_lighter_all_the_way(name: str) -> None:
    steps = of_map(name, 64)
    assert np.all(np.diff(steps) > 0)
    assert steps[-1] - steps[0] > 60


def test_differences_grow_darker_to_both_sides_and_the_sides_differ() -> None:
    steps = of_map(diverging_map(), 101)
    assert np.all(np.diff(steps[:51]) > 0)
    assert np.all(np.diff(steps[50:]) < 0)
    assert steps[50] > 95
    assert steps[-1] - steps[0] > 15  # in grey the darkest is negative


def test_the_colour_under_the_scale_is_no_colour_of_the_scale() -> None:
    under = lightness(np.array([to_rgb(BELOW)]))[0]
    assert of_map(dsf_map()).min() - under > 8
    assert of_map(RELATIVE_MAP).min() - under > 8


def test_categories_are_told_apart_in_grey_by_lightness_or_hatch() -> None:
    shades = lightness(np.array([to_rgb(c) for c in CATEGORY_COLOURS]))
    for i in range(len(shades)):
        for j in range(i):
            assert abs(shades[i] - shades[j]) > 8 or CATEGORY_HATCHES[i] != CATEGORY_HATCHES[j], (i, j)
    assert lightness(np.array([to_rgb(c) for c in LINE_COLOURS])).max() < 65  # on white paper


def test_the_scale_counts_what_lies_under_it() -> None:
    """100 points of equal weight: three negative, two far below the others."""
    values = np.concatenate([[-1.0, -1e-3, 0.0, 1e-9, 1e-8], np.geomspace(0.01, 10.0, 95)])
    scale = log_scale(values, np.full(100, 0.05))
    assert scale.top == 10.0
    assert scale.negative_share == pytest.approx(0.03)
    assert scale.below_share == pytest.approx(np.mean(values < scale.low))
    assert "3 % at or below zero" in scale_words(scale)
    image = scale.clipped(np.array([[np.nan, -1.0], [scale.low, 5.0]]))
    assert np.isnan(image[0, 0])
    assert 0 < image[0, 1] < scale.low  # just under: drawn in the colour for that, not as a hole
    assert image[1].tolist() == [scale.low, 5.0]


def test_a_peak_flown_densely_does_not_move_the_scale() -> None:
    """A million points in no solid angle leave the low end where the diffuse part is."""
    values = np.concatenate([np.full(1000, 0.1), np.full(5000, 100.0)])
    weight = np.concatenate([np.full(1000, 1e-3), np.full(5000, 1e-9)])
    scale = log_scale(values, weight)
    assert scale.low == pytest.approx(0.1)
    assert scale_words(scale) == ""
    flat = log_scale(np.full(10, 2.0), np.zeros(10))
    assert flat.top == 2.0
    assert flat.low == pytest.approx(0.2)


def test_dominance_takes_axes_together_and_counts_solid_angle() -> None:
    """In front the two axes together exceed P_i, each alone does not; behind P_i is alone, and below the noise."""
    d = distribution((30, 0), sphere_points(4000), lambda u: np.ones(len(u)))
    d.variance_per_sr2[:] = 0.01**2
    up = d.theta_deg < 95
    d.effects = {
        "axis arm azimuth": np.where(up, 0.012, 0.0),
        "axis arm elevation": np.where(up, -0.012, 0.0),
        "p_i": np.where(up, 0.015, 0.005),
    }
    found = dominance(d)
    front = (1 - np.cos(np.radians(95))) / 2
    assert found.names == ("scatter angle: zero of an axis", "incident power: P_i of the reference beam")
    assert found.shares == pytest.approx((front, 1 - front), abs=1e-3)
    assert found.noise_share == pytest.approx(1 - front, abs=1e-3)
    assert set(found.category[up]) == {0}
    assert set(found.category[~up]) == {1}
    expected = np.where(up, np.sqrt(0.01**2 + 2 * 0.012**2 + 0.015**2), np.hypot(0.01, 0.005))
    np.testing.assert_allclose(relative_u(d), expected)


def test_masked_points_dominate_nothing() -> None:
    d = distribution((30, 0), sphere_points(2000), lambda u: np.ones(len(u)), masked_below_deg=20)
    d.effects = {"p_i": np.where(d.measured, 1.0, np.nan)}
    found = dominance(d)
    assert np.all(found.category[~d.measured] == -1)
    assert found.names == ("incident power: P_i of the reference beam",)
    assert found.shares == pytest.approx((1.0,))


def test_many_effects_end_in_other() -> None:
    d = distribution((30, 0), sphere_points(900), lambda u: np.ones(len(u)))
    names = ("dark", "gain_ratio", "linearity", "lamp", "p_i", "distance", "aperture", "tilt_x", "tilt_y")
    d.effects = {name: np.where(np.arange(900) % 9 == i, 1.0, 0.1) for i, name in enumerate(names)}
    found = dominance(d)
    assert found.names[-1] == "other"
    assert len(found.names) == 7
    assert sum(found.shares) == pytest.approx(1.0)
    assert found.category.max() == 6


def test_figures_of_little_data_are_drawn_too() -> None:
    """One hemisphere, no positive value, no time, no effects, no variance."""
    units = sphere_points(600)
    d = distribution((30, 0), units[units[:, 2] > 0], lambda u: np.zeros(len(u)))
    pictures = hemisphere_pictures(d)
    assert list(pictures) == ["front"]
    scale = log_scale(d.dsf_per_sr, d.solid_angle_sr)
    assert polar_maps(d, pictures, scale).startswith("data:image/png;base64,")
    assert scale.negative_share == 1.0
    assert uncertainty_map(d, pictures, None) is None
    d.time_ns[:] = 0
    assert path_figure(d) is None
    d.time_ns[:] = np.arange(len(d.time_ns)) + 1
    assert path_figure(d) is not None
