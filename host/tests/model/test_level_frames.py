"""test_level_frames.py: tangent coordinates without a pole, and the coverage of points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampled_nodes import spread, towards

from gonio.model.hemisphere import disc_from_unit
from gonio.model.lobe import Lobe
from gonio.model.nodes.coverage import BETWEEN, BEYOND, WITHIN, coverage, look_up
from gonio.model.nodes.frames import along_tangents, level_axes, level_covariance, symmetric_function, tangents

ANGLES = st.tuples(st.floats(0.0, 100.0), st.floats(0.0, 360.0))


@given(ANGLES, ANGLES)
def test_coordinates_and_back(centre: tuple[float, float], other: tuple[float, float]) -> None:
    axes, unit = level_axes(towards(*centre)), towards(*other)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    there = tangents(axes, unit)
    assert np.linalg.norm(there) == pytest.approx(np.arccos(np.clip(unit @ axes[2], -1, 1)), abs=1e-6)
    np.testing.assert_allclose(along_tangents(axes, there), unit, atol=1e-9)


@given(ANGLES, ANGLES, st.sampled_from([(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]))
def test_images_only_change_signs(
    centre: tuple[float, float], other: tuple[float, float], signs: tuple[float, float]
) -> None:
    both = np.array([*signs, 1.0])
    here = tangents(level_axes(towards(*centre)), towards(*other))
    image = tangents(level_axes(towards(*centre) * both), towards(*other) * both)
    np.testing.assert_allclose(image, here * np.array(signs), atol=1e-9)


def test_a_covariance_keeps_its_lobe() -> None:
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    lobe = Lobe(towards(50.0, 130.0), turn @ np.diag([0.01, 0.0009]) @ turn.T, 2.0)
    unit = spread(500)
    level = level_covariance(lobe.centre, lobe.covariance_rad2)
    u = tangents(level_axes(lobe.centre), unit)
    ours = 2.0 * np.exp(-0.5 * np.einsum("ni,ij,nj->n", u, np.linalg.inv(level), u))
    np.testing.assert_allclose(ours, lobe.dsf_per_sr(unit), rtol=1e-9, atol=1e-12)


def test_logarithm_and_exponential() -> None:
    matrix = np.array([[[0.04, 0.01], [0.01, 0.02]], [[1.0, 0.0], [0.0, 1.0]]])
    log = symmetric_function(matrix, np.log)
    np.testing.assert_allclose(log[1], 0.0, atol=1e-15)
    np.testing.assert_allclose(symmetric_function(log, np.exp), matrix, rtol=1e-12)


@pytest.mark.parametrize("number", [400, 40_000])
def test_coverage_knows_holes_and_what_lies_beyond(number: int) -> None:
    unit = spread(number)
    hole = np.arccos(np.clip(unit @ towards(30.0, 0.0), -1.0, 1.0)) < np.radians(15.0)
    kept = unit[~hole & (unit[:, 2] > np.cos(np.radians(60.0)))]
    grid = coverage(disc_from_unit(kept))
    asked = np.array([towards(30.0, 0.0), towards(40.0, 180.0), towards(80.0, 90.0)])
    assert list(look_up(grid, asked[:, :2])) == [BETWEEN, WITHIN, BEYOND]


def test_points_on_a_line_surround_nothing() -> None:
    unit = np.array([towards(t, 0.0) for t in range(0, 80, 5)])
    grid = coverage(disc_from_unit(unit))
    assert list(look_up(grid, np.array([towards(41.0, 0.0), towards(40.0, 60.0)])[:, :2])) == [WITHIN, BEYOND]
