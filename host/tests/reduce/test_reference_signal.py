"""test_reference_signal.py: the form with distance, detector area and reference signal equals the form with P_i."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from signature_scene import spiral, truth_of

from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.directions import angle_between_deg, tangent_frame, unit_from_angles_deg
from gonio.reduce.integrals.beam import measure_beam
from gonio.reduce.integrals.reference_signal import (
    bsdf_of_reference_signal,
    dsf_of_reference_signal,
    receiver_solid_angle_sr,
    reference_signal_of,
)

FloatArray = NDArray[np.float64]

DISTANCE_MM, APERTURE_MM = 1000.0, 10.0
AREA_MM2 = np.pi * (0.5 * APERTURE_MM) ** 2


def exact(value: float) -> Uncertain:
    return Uncertain(value)


def through_aperture(field: Callable[[FloatArray], FloatArray], directions: FloatArray) -> FloatArray:
    """Flux through a round aperture about each direction (n, 3): the field per solid angle, integrated by a product of
    Gauss-Legendre nodes over the radius and midpoints over azimuth."""
    radius = np.arctan(0.5 * APERTURE_MM / DISTANCE_MM)
    node, weight = np.polynomial.legendre.leggauss(12)
    polar = 0.5 * radius * (node + 1.0)
    azimuth = (np.arange(24) + 0.5) * 2.0 * np.pi / 24
    total = np.zeros(len(directions))
    frames = np.array([tangent_frame(d) for d in directions])
    for p, w in zip(polar, 0.5 * radius * weight, strict=True):
        for a in azimuth:
            offset = np.sin(p) * (np.cos(a) * frames[:, 0] + np.sin(a) * frames[:, 1]) + np.cos(p) * frames[:, 2]
            total += w * np.sin(p) * 2.0 * np.pi / 24 * field(offset)
    return total


def test_both_forms_are_equal_for_a_beam_averaged_by_a_finite_aperture() -> None:
    """A beam narrower than twice the aperture, so that the averaging matters; a sample of known DSF. S_ref is the
    signal of a detector that takes in the whole beam: its power."""
    sigma = np.radians(0.35)

    def beam(unit: FloatArray) -> FloatArray:
        off = np.radians(angle_between_deg(unit, np.array([0.0, 0.0, -1.0])))
        return np.asarray(800.0 * np.exp(-0.5 * (off / sigma) ** 2))

    power = 800.0 * 2.0 * np.pi * sigma**2
    unit = spiral((180.0, 0.0), 2.6, 0.07, 0.05)
    signal = through_aperture(beam, unit)
    scan = measure_beam(unit, signal, np.zeros(len(unit)), np.ones(len(unit), dtype=bool))
    assert signal.max() < 0.9 * power  # the aperture takes in a part of the beam only

    towards = unit_from_angles_deg([20.0, 65.0], [10.0, 200.0])
    reading = through_aperture(lambda v: power * 0.6 / np.pi * v[:, 2], towards)
    with_p_i = reading / scan.p_i
    for theta_deg, read, dsf in zip((20.0, 65.0), reading, with_p_i, strict=True):
        by_signal = dsf_of_reference_signal(exact(read), exact(power), exact(DISTANCE_MM), exact(AREA_MM2))
        assert by_signal.value == pytest.approx(dsf, rel=3e-4)
        bsdf = bsdf_of_reference_signal(exact(read), exact(power), exact(DISTANCE_MM), exact(AREA_MM2), theta_deg)
        assert bsdf.value == pytest.approx(0.6 / np.pi, rel=3e-4)
    s_ref = reference_signal_of(scan.power, exact(DISTANCE_MM), exact(AREA_MM2))
    assert s_ref.value == pytest.approx(power, rel=3e-4)


def test_the_twins_own_beam_gives_the_same_reference_signal(tmp_path: Path) -> None:
    """The closed form has the beam per solid angle seen through the aperture: reading = that times omega."""
    truth = truth_of(tmp_path, '{ kind = "lambertian", reflectance = 0.3 }')
    unit = spiral((180.0, 0.0), 2.0, 0.06)
    omega = receiver_solid_angle_sr(exact(DISTANCE_MM), exact(AREA_MM2)).value
    reading = omega * truth.beam_per_sr(angle_between_deg(unit, np.array([0.0, 0.0, -1.0])))
    scan = measure_beam(unit, reading, np.zeros(len(unit)), np.ones(len(unit), dtype=bool))
    assert reference_signal_of(scan.power, exact(DISTANCE_MM), exact(AREA_MM2)).value == pytest.approx(1.0, rel=5e-4)


def test_distance_counts_twice_and_shared_effects_cancel() -> None:
    sample = Uncertain(3.0, 0.003, {"gain_ratio": 0.06, "lamp": 0.03})
    reference = Uncertain(50.0, 0.0, {"gain_ratio": 1.0})
    found = dsf_of_reference_signal(sample, reference, Uncertain(1000.0, 0.5), Uncertain(78.5, 0.1))
    relative = {name: part / found.value for name, part in found.budget.items()}
    assert relative["distance"] == pytest.approx(2.0 * 0.5e-3, rel=1e-9)
    assert relative["aperture"] == pytest.approx(0.1 / 78.5, rel=1e-9)
    assert relative["lamp"] == pytest.approx(0.01, rel=1e-9)
    assert relative["gain_ratio"] == pytest.approx(0.0, abs=1e-12)
    assert relative["independent"] == pytest.approx(1e-3, rel=1e-9)


def test_what_has_no_value_is_refused() -> None:
    with pytest.raises(ValueError, match="distance and detector area"):
        receiver_solid_angle_sr(exact(0.0), exact(1.0))
    with pytest.raises(ValueError, match="reference signal must be positive"):
        dsf_of_reference_signal(exact(1.0), exact(0.0), exact(1.0), exact(1.0))
    with pytest.raises(ValueError, match="theta = 90"):
        bsdf_of_reference_signal(exact(1.0), exact(1.0), exact(1.0), exact(1.0), 90.0)
