"""test_directions.py: where a simulation looks: cells end at the horizon, spirals have no gaps, the beam's extent."""

import numpy as np
import pytest

from gonio.geometry.cells import solid_angles_sr
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.geometry.kinematics import SOURCE_LAB
from gonio.geometry.pitch import path_pitch_rad
from gonio.simulate.assembly import overlap_factor
from gonio.simulate.directions import BeamExtent, about_beam, beam_extent, beam_probe, beam_spiral, grid, rings, spiral


def test_no_cell_of_the_rings_crosses_the_horizon() -> None:
    unit = rings(5.0)
    omega = solid_angles_sr(unit)
    assert omega[unit[:, 2] > 0.0].sum() == pytest.approx(2.0 * np.pi, rel=1e-9)
    # A Lambertian distribution over these cells: the midpoint rule in theta is right to (step)^2 / 12.
    up = np.maximum(unit[:, 2], 0.0)
    assert up @ omega / np.pi == pytest.approx(1.0, abs=np.radians(5.0) ** 2 / 6.0)


def test_a_spiral_leaves_no_gap() -> None:
    centre = unit_from_angles_deg(40.0, 130.0)
    points = spiral(centre, 4.0, 0.5)
    assert points[0] == pytest.approx(centre)
    pitch = path_pitch_rad(points, np.zeros(len(points), dtype=np.int64))
    assert np.degrees(np.median(pitch)) == pytest.approx(0.5, rel=0.05)
    step = angle_between_deg(points[1:], points[:-1])
    assert step.max() < 0.5
    assert angle_between_deg(points, centre).max() >= 4.0


def test_the_grid_names_its_peaks_once() -> None:
    extent = BeamExtent(2.4, 3.7)
    oblique, peaks = grid((30.0, 90.0), 10.0, extent)
    assert [peak.name for peak in peaks] == ["mirror 30/90", "through 30/90", "retro 30/90"]
    for peak, where in zip(peaks, ((30.0, 270.0), (150.0, 270.0), (30.0, 90.0)), strict=True):
        assert oblique[peak.points][0] == pytest.approx(unit_from_angles_deg(*where))
    _, at_normal = grid((0.0, 0.0), 10.0, extent)
    assert [peak.name for peak in at_normal] == ["mirror 0/0", "through 0/0"]


def test_the_extent_of_a_top_hat() -> None:
    probe = beam_probe()
    polar_deg = angle_between_deg(probe, -SOURCE_LAB)
    extent = beam_extent(np.where(polar_deg < 1.8, 1.0, 1e-5))
    assert extent is not None
    assert extent.radius_deg == pytest.approx(2.0)
    assert extent.width_deg == pytest.approx(3.6, abs=0.25)
    assert beam_extent(np.zeros(len(probe))) is None
    assert angle_between_deg(beam_spiral(extent), -SOURCE_LAB).max() > 2.4


def test_angles_of_the_free_beam_are_the_conventions() -> None:
    unit = about_beam(np.array([0.0, 2.0, 2.0]), np.array([0.0, 0.0, 90.0]))
    assert unit[0] == pytest.approx([0.0, 0.0, -1.0])
    assert unit[1, 0] > 0.0
    assert unit[2, 1] > 0.0


def test_apertures_that_overlap_count_a_photon_once() -> None:
    # Two cells of a quarter of the aperture each: four times the variance of independent readings.
    assert overlap_factor(4.0e-5, np.array([1.0e-5, 8.0e-5, 0.0])) == pytest.approx([4.0, 1.0, 1.0])
