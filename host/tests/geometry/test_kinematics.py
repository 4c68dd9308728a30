"""test_kinematics.py: the seven poses of CONVENTIONS.md, the inverse, and chains that cannot be inverted."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.units.errors import UsageError


@dataclass(frozen=True)
class Turn:
    vector: tuple[float, float, float]
    carries: str


REFERENCE = (
    Turn((0, -1, 0), "sample"),
    Turn((0, 0, -1), "sample"),
    Turn((0, 1, 0), "detector"),
    Turn((-1, 0, 0), "detector"),
)
# Readings; incident theta and phi; outgoing theta and phi, as CONVENTIONS.md prints them.
POSES = [
    ((0, 0, 30, 0), (0, None), (30, 0)),
    ((30, 0, 0, 0), (30, 0), (30, 0)),
    ((30, 0, -60, 0), (30, 0), (30, 180)),
    ((30, 0, 180, 0), (30, 0), (150, 180)),
    ((30, 90, 0, 45), (30, 90), (52.2388, 153.4349)),
    ((60, 210, -75, 20), (60, 210), (24.8142, 335.4166)),
    ((150, 0, 20, -10), (150, 0), (165.8940, 314.5615)),
]


@pytest.mark.parametrize(("q_deg", "incident", "outgoing"), POSES)
def test_poses_of_the_conventions(
    q_deg: tuple[float, ...], incident: tuple[float, float | None], outgoing: tuple[float, float]
) -> None:
    found = [angles_deg_from_unit(v[0]) for v in Kinematics(REFERENCE).directions([q_deg])]
    for (theta, phi), (expected_theta, expected_phi) in zip(found, (incident, outgoing), strict=True):
        assert theta == pytest.approx(expected_theta, abs=5e-5)
        if expected_phi is not None:
            assert (phi - expected_phi + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=5e-5)


def test_readings_of_the_sample_axes_are_the_incident_angles() -> None:
    kinematics = Kinematics(REFERENCE)
    for theta, phi in [(0, 0), (0, 90), (30, 0), (60, 210), (89, 359.5), (150, 0), (180, 40), (180, 0)]:
        assert kinematics.sample_axes_for_incident(theta, phi) == pytest.approx((theta, phi), abs=1e-9)


@given(st.floats(0.0, 180.0), st.floats(0.0, 359.0), st.floats(-1.0, 1.0), st.floats(0.0, 360.0))
def test_arm_looks_from_the_direction_it_was_sent_to(theta_i: float, phi_i: float, cos_s: float, phi_s: float) -> None:
    kinematics = Kinematics(REFERENCE)
    outgoing = unit_from_angles_deg(np.degrees(np.arccos(cos_s)), phi_s)
    q1, q2 = kinematics.sample_axes_for_incident(theta_i, phi_i)
    arm = kinematics.arm_for_outgoing(q1, q2, outgoing[None])
    assert arm.shape == (1, 2)
    assert -180.0 < arm[0, 0] <= 180.0
    assert abs(arm[0, 1]) <= 90.0 + 1e-9
    incident, reached = kinematics.directions([[q1, q2, arm[0, 0], arm[0, 1]]])
    assert angle_between_deg(reached[0], outgoing) < 1e-6
    assert angle_between_deg(incident[0], unit_from_angles_deg(theta_i, phi_i)) < 1e-6


@given(st.lists(st.floats(-170.0, 170.0), min_size=4, max_size=4))
def test_a_skewed_instrument_is_inverted_too(q_deg: list[float]) -> None:
    """Axes that are neither square to each other nor along the frame: directions found for a pose lead back to them."""
    skewed = (
        Turn((0.2, -1.0, 0.1), "sample"),
        Turn((0.1, 0.2, -1.0), "sample"),
        Turn((0.0, 1.0, 0.2), "detector"),
        Turn((-1.0, 0.3, 0.0), "detector"),
    )
    kinematics = Kinematics(skewed)
    incident, outgoing = kinematics.directions([q_deg])
    q1, q2 = kinematics.sample_axes_for_incident(*(float(a) for a in angles_deg_from_unit(incident[0])))
    arm = kinematics.arm_for_outgoing(q1, q2, kinematics.directions([[q1, q2, q_deg[2], q_deg[3]]])[1])
    again = kinematics.directions([[q1, q2, *arm[0]]])
    assert angle_between_deg(again[0][0], incident[0]) < 1e-5
    expected = kinematics.directions([[q1, q2, q_deg[2], q_deg[3]]])[1]
    assert angle_between_deg(again[1][0], expected[0]) < 1e-5
    assert angle_between_deg(incident[0], outgoing[0]) == pytest.approx(
        float(angle_between_deg(again[0][0], again[1][0])), abs=1e-4
    )


def test_detector_in_the_lab_is_the_formula_of_the_conventions() -> None:
    rng = np.random.default_rng(1)
    q = rng.uniform(-180.0, 180.0, (200, 4))
    q3, q4 = np.radians(q[:, 2]), np.radians(q[:, 3])
    expected = np.stack((np.sin(q3) * np.cos(q4), np.sin(q4), np.cos(q3) * np.cos(q4)), axis=-1)
    np.testing.assert_allclose(Kinematics(REFERENCE).detector_in_lab(q), expected, atol=1e-15)


def test_chains_that_cannot_be_inverted_are_refused_with_a_sentence() -> None:
    with pytest.raises(UsageError, match="the detector has 1 axes"):
        Kinematics(REFERENCE[:3]).arm_for_outgoing(0.0, 0.0, [[0.0, 0.0, 1.0]])
    parallel = (*REFERENCE[:3], Turn((0, -2, 0), "detector"))
    with pytest.raises(UsageError, match="both detector axes turn about one line"):
        Kinematics(parallel).arm_for_outgoing(0.0, 0.0, [[0.0, 0.0, 1.0]])
    slanted = (Turn((0, -1, 0), "sample"), Turn((0, -1, -0.5), "sample"), *REFERENCE[2:])
    with pytest.raises(UsageError, match="cannot turn the sample that far"):
        Kinematics(slanted).sample_axes_for_incident(90.0, 270.0)
    with pytest.raises(UsageError, match="has no direction"):
        Kinematics([Turn((0, 0, 0), "sample")])
    with pytest.raises(UsageError, match="must be 'sample' or 'detector'"):
        Kinematics([Turn((0, 0, 1), "lamp")])


def test_directions_that_the_arm_cannot_look_from_are_nan() -> None:
    slanted = (*REFERENCE[:2], Turn((0, 1, 0), "detector"), Turn((0, 1, 0.5), "detector"))
    arm = Kinematics(slanted).arm_for_outgoing(0.0, 0.0, [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.isnan(arm[0]).all()
    assert np.isfinite(arm[1]).all()
