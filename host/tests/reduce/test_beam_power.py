"""test_beam_power.py: P_i from a reference spiral, its uncertainty, two scans, and closure."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from signature_scene import beam_scan, spiral, truth_of

from gonio.dataset.bsdf import PointFlag
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.reduce.integrals.beam import Beam, measure_beam
from gonio.reduce.integrals.closure import closure

FWHM_DEG = 0.9


def gaussian_beam(pitch_deg: float, off_deg: float, seed: int | None = None, noise: float = 0.0) -> Beam:
    """A beam of unit power, scanned with so many degrees between the turns; with noise in fewer samples."""
    unit = spiral((180.0, 0.0), 2.2, pitch_deg, 0.01 if seed is None else 0.1)
    sigma = FWHM_DEG / 2.3548
    off = angle_between_deg(unit, unit_from_angles_deg(180.0 - off_deg, 30.0))
    signal = np.exp(-0.5 * (off / sigma) ** 2) / (2.0 * np.pi * np.radians(sigma) ** 2)
    top = signal.max()
    if seed is not None:
        signal = signal + noise * top * np.random.default_rng(seed).standard_normal(len(unit))
    return measure_beam(unit, signal, np.full(len(unit), (noise * top) ** 2), np.ones(len(unit), dtype=bool))


@pytest.mark.parametrize("off_deg", [0.0, 0.07, 0.31])
@pytest.mark.parametrize("turns", [6.0, 10.0])
def test_power_of_a_smooth_beam_is_right_from_six_turns_on(turns: float, off_deg: float) -> None:
    beam = gaussian_beam(FWHM_DEG / turns, off_deg)
    assert beam.p_i == pytest.approx(1.0, rel=3e-4)
    assert beam.turns == pytest.approx(turns, rel=0.06)
    assert beam.fwhm_deg == pytest.approx(FWHM_DEG, rel=0.05)
    assert abs(beam.p_i - 1.0) < 2.0 * beam.power.u


def test_cells_alone_read_high_and_their_correction_does_not() -> None:
    """Euler and Maclaurin: V - 1 = pi pitch^2 / 12 times the height over the power."""
    beam = gaussian_beam(FWHM_DEG / 8.0, 0.0)
    height = 1.0 / (2.0 * np.pi * (FWHM_DEG / 2.3548) ** 2)
    expected = np.pi * (FWHM_DEG / 8.0) ** 2 / 12.0 * height
    assert beam.voronoi - 1.0 == pytest.approx(expected, rel=0.08)
    assert abs(beam.p_i - 1.0) < 0.1 * expected


@pytest.mark.parametrize("off_deg", [0.0, 0.03, 0.1, 0.25])
@pytest.mark.parametrize("pitch_deg", [0.05, 0.1])
def test_power_of_a_flat_beam_with_an_edge(pitch_deg: float, off_deg: float, tmp_path: Path) -> None:
    """A top hat of 1 degree through the aperture: its edge falls between the turns, which no weights can mend; the
    uncertainty says so."""
    beam, _ = beam_scan(truth_of(tmp_path, '{ kind = "lambertian", reflectance = 0.3 }'), pitch_deg, off_deg)
    assert beam.p_i == pytest.approx(1.0, rel=6e-4)
    assert abs(beam.p_i - 1.0) < 3.0 * beam.power.u + 5e-5  # the closed form's own quadrature
    assert beam.power.u < 2e-3
    assert beam.centroid_x_deg == pytest.approx(off_deg, abs=2e-3)


def test_noise_of_the_power_is_that_of_repeats() -> None:
    beams = [gaussian_beam(0.09, 0.05, seed, 0.02) for seed in range(40)]
    found = np.array([beam.p_i for beam in beams])
    stated = np.mean([beam.power.independent for beam in beams])
    assert stated == pytest.approx(found.std(ddof=1), rel=0.35)
    assert set(beams[0].power.effects) == {"skirt", "quadrature"}


def test_few_turns_are_noted() -> None:
    coarse, fine = gaussian_beam(FWHM_DEG / 3.0, 0.0), gaussian_beam(FWHM_DEG / 12.0, 0.0)
    assert "3.0 turns per full width at half maximum" in coarse.notes()[0]
    assert fine.notes() == []


def test_two_scans_give_their_mean_and_their_ratio() -> None:
    unit = spiral((180.0, 0.0), 2.0, 0.08)
    signal = np.exp(-0.5 * (angle_between_deg(unit, np.array([0.0, 0.0, -1.0])) / 0.4) ** 2)
    one = measure_beam(unit, signal, np.full(len(unit), 1e-8), np.ones(len(unit), dtype=bool))
    both = measure_beam(
        np.concatenate((unit, unit[::-1])),
        np.concatenate((signal, 1.02 * signal[::-1])),
        np.full(2 * len(unit), 1e-8),
        np.ones(2 * len(unit), dtype=bool),
        np.repeat([0, 1], len(unit)).astype(np.int32),
    )
    assert both.p_i == pytest.approx(1.01 * one.p_i, rel=1e-9)
    assert both.turns == pytest.approx(one.turns, rel=0.02)
    results = both.results()
    assert results.values["reference_ratio"] == pytest.approx(1.02, rel=1e-9)
    assert results.values["reference_ratio_u"] < 2e-3
    assert any("1.0200 of the first" in note for note in both.notes())
    # 2 V - P1 holds for the sum over all points too: each scan counts half.
    weight = 2.0 * both.solid_angle_sr - both.linear_sr
    assert float(weight @ np.concatenate((signal, 1.02 * signal[::-1]))) == pytest.approx(both.p_i, rel=1e-12)


def test_the_beam_closes(tmp_path: Path) -> None:
    _, scan = beam_scan(truth_of(tmp_path, '{ kind = "lambertian", reflectance = 0.3 }'), 0.06)
    found = closure(scan)
    assert found.value == pytest.approx(1.0, abs=5e-4)
    assert found.u < 5e-3


def test_closure_sees_light_that_is_missing(tmp_path: Path) -> None:
    """Half of the beam masked: the sum must tell, and not be filled up."""
    _, scan = beam_scan(truth_of(tmp_path, '{ kind = "lambertian", reflectance = 0.3 }'), 0.06)
    half = scan.phi_deg < 180.0
    flags = np.where(half, np.uint16(PointFlag.SATURATED), np.uint16(0)).astype(np.uint16)
    dsf = np.where(half, np.nan, scan.dsf_per_sr)
    found = closure(replace(scan, flags=flags, dsf_per_sr=dsf))
    assert found.value == pytest.approx(0.5, abs=0.01)
