"""test_flown_coverage.py: the area that cells of flown paths cover is what was flown, and 1.5 pitches around it."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.plan.compile import compile_loaded
from gonio.plan.knots import positions_deg
from gonio.plan.program import PathStep
from gonio.plan.schema import parse_plan
from gonio.plan.spiral import spiral
from gonio.reduce.coverage import cells_of_paths
from gonio.units.instrument import load_instrument

FloatArray = NDArray[np.float64]
ABOUT = unit_from_angles_deg(50.0, 20.0)


def one_path(points: FloatArray, number: int = 0) -> NDArray[np.int32]:
    return np.full(len(points), number, dtype=np.int32)


def circles(elevations: FloatArray, step_deg: float = 0.1) -> FloatArray:
    azimuth = np.arange(0.0, 360.0, step_deg)
    return np.concatenate([unit_from_angles_deg(90.0 - e, azimuth[:: -1 if k % 2 else 1])
                           for k, e in enumerate(elevations)])  # fmt: skip


def flown_spiral(pitch_deg: float, radius_deg: float) -> FloatArray:
    track = spiral(ABOUT, radius_deg, pitch_deg)
    along = np.arange(0.0, track.length_deg[-1], 0.2 * pitch_deg)
    points = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    return np.asarray(points / np.linalg.norm(points, axis=1)[:, None])


def spiral_sr(pitch_deg: float, radius_deg: float) -> float:
    """Area within 1.5 pitches of a spiral (flat): half the integral of the squared border over its last turn."""
    out, inner = radius_deg + 1.5 * pitch_deg, radius_deg + 0.5 * pitch_deg
    return float(np.radians(1.0) ** 2 * np.pi * (out**3 - inner**3) / (3.0 * pitch_deg))


def band_sr(low_deg: float, high_deg: float) -> float:
    return float(2.0 * np.pi * (np.sin(np.radians(high_deg)) - np.sin(np.radians(low_deg))))


def wave(shape: Callable[[FloatArray], FloatArray], step_deg: float, highest_deg: float) -> FloatArray:
    """A path that swings between elevations, half a period of azimuth further each time."""
    swings = 360.0 / step_deg
    t = np.linspace(0.0, swings, int(1200 * swings))
    return unit_from_angles_deg(90.0 - highest_deg * shape(t), step_deg * t)


def triangle(t: FloatArray) -> FloatArray:
    return np.asarray(np.abs(t % 2.0 - 1.0) * 2.0 - 1.0)


def test_circles_of_constant_elevation() -> None:
    points = circles(np.arange(-60.0, 60.1, 4.0))
    found = cells_of_paths(points, one_path(points))
    assert found.solid_angle_sr.sum() == pytest.approx(band_sr(-66.0, 66.0), rel=0.01)


def test_interleaved_circles() -> None:
    there, back = np.arange(-60.0, 60.1, 8.0), np.arange(56.0, -60.0, -8.0)
    points = circles(np.concatenate((there, back)))
    found = cells_of_paths(points, one_path(points))
    assert found.solid_angle_sr.sum() == pytest.approx(band_sr(-66.0, 66.0), rel=0.01)


PLAN = """
[sample]
name = "coverage"
front_faces = "exterior"
[beam]
kind = "focused"
diameter_mm = 10.0
divergence_deg = 1.0
[scan]
speed_deg_per_s = 30.0
incident = [[30, 0]]
[coarse]
pitch_deg = 6.0
sphere = "whole"
[[peak]]
about = "through"
radius_deg = 2.5
pitch_deg = 0.25
"""


def test_a_planned_scan_covers_the_whole_sphere() -> None:
    """Circles as the planner flies them, round the shade and with its turnarounds, and a spiral among them."""
    instrument = load_instrument(None)
    program = compile_loaded(parse_plan(PLAN, "p.toml"), instrument)
    parts = []
    for step in program.steps:
        if isinstance(step, PathStep) and step.kind in ("coarse", "peak"):
            q_deg = positions_deg(step.knots, instrument, every_s=0.005)
            parts.append(Kinematics(instrument.axes).directions(q_deg)[1])
    assert len(parts) == 2
    out = [(one.theta_deg, one.phi_deg) for one in program.unreachable]
    aside = unit_from_angles_deg(*np.array(out).T)
    path = np.concatenate([one_path(part, k) for k, part in enumerate(parts)] + [one_path(aside, -1)])
    found = cells_of_paths(np.concatenate([*parts, aside]), path)
    assert found.solid_angle_sr.sum() == pytest.approx(4.0 * np.pi, rel=1e-6)
    # The fine path has what lies within its border and half way to the circles.
    assert found.solid_angle_sr[path == 1].sum() < 4.0 * spiral_sr(0.25, 2.5)


def test_a_spiral_alone_ends_one_and_a_half_pitches_outside() -> None:
    for pitch_deg, radius_deg in ((0.1, 2.5), (0.25, 5.0), (0.5, 2.5)):
        points = flown_spiral(pitch_deg, radius_deg)
        covered = cells_of_paths(points, one_path(points)).solid_angle_sr.sum()
        assert covered == pytest.approx(spiral_sr(pitch_deg, radius_deg), rel=0.01)


@pytest.mark.parametrize("together", [False, True])
def test_parallel_orbits(together: bool) -> None:
    for count in (2, 5):
        elevations = 20.0 + 3.0 * np.arange(count)
        points = circles(elevations)
        path = one_path(points) if together else np.repeat(np.arange(count, dtype=np.int32), 3600)
        covered = cells_of_paths(points, path).solid_angle_sr.sum()
        assert covered == pytest.approx(band_sr(20.0 - 4.5, elevations[-1] + 4.5), rel=0.01)


@pytest.mark.parametrize("shape", [triangle, lambda t: np.sin(np.pi * (t - 0.5))])
def test_zigzag_and_sinusoid(shape: Callable[[FloatArray], FloatArray]) -> None:
    points = wave(shape, 6.0, 89.0)
    covered = cells_of_paths(points, one_path(points)).solid_angle_sr.sum()
    assert covered == pytest.approx(4.0 * np.pi, rel=0.01)
    # Beyond its turnarounds, 12 degrees of azimuth apart, a point has up to 1.5 times their distance.
    points = wave(shape, 6.0, 60.0)
    covered = cells_of_paths(points, one_path(points)).solid_angle_sr.sum()
    assert band_sr(-60.0, 60.0) < covered < band_sr(-69.1, 69.1)


def test_a_coarse_pass_with_a_spiral_in_it() -> None:
    coarse, fine = circles(np.arange(-84.0, 84.1, 6.0)), flown_spiral(0.1, 2.5)
    points = np.concatenate((coarse, fine))
    for path in (np.concatenate((one_path(coarse), one_path(fine, 1))), one_path(points)):
        covered = cells_of_paths(points, path).solid_angle_sr
        assert covered.sum() == pytest.approx(4.0 * np.pi, rel=1e-6)


def test_no_point_owns_a_real_void() -> None:
    """Two groups of circles far apart: what lies between them is nobody's; nor is a spiral's surrounding sphere."""
    points = circles(np.concatenate((np.arange(-60.0, -19.9, 4.0), np.arange(20.0, 60.1, 4.0))))
    covered = cells_of_paths(points, one_path(points)).solid_angle_sr.sum()
    assert covered == pytest.approx(2.0 * band_sr(14.0, 66.0), rel=0.01)
