"""test_directions.py: polar angles and unit vectors against worked values and against each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gonio.geometry import directions as d

THETA = st.floats(0.0, 180.0)
PHI = st.floats(-720.0, 720.0)


@given(THETA, PHI)
def test_angles_survive_the_way_there_and_back(theta: float, phi: float) -> None:
    unit = d.unit_from_angles_deg(theta, phi)
    assert np.linalg.norm(unit) == pytest.approx(1.0, abs=1e-15)
    back_theta, back_phi = d.angles_deg_from_unit(unit)
    assert back_theta == pytest.approx(theta, abs=1e-12)
    assert 0.0 <= back_phi < 360.0
    # Azimuth counts only as far as the direction is off the pole.
    assert d.angle_between_deg(unit, d.unit_from_angles_deg(back_theta, back_phi)) < 1e-12


def test_worked_directions() -> None:
    np.testing.assert_allclose(d.unit_from_angles_deg(90.0, 90.0), [0, 1, 0], atol=1e-16)
    np.testing.assert_allclose(d.unit_from_angles_deg([0.0, 180.0], 0.0), [[0, 0, 1], [0, 0, -1]], atol=1e-15)
    np.testing.assert_array_equal(d.angles_deg_from_unit([1.0, -1e-18, 0.0]), (90.0, 0.0))
    np.testing.assert_array_equal(d.angles_deg_from_unit([0.0, 0.0, -2.0]), (180.0, 0.0))


@given(THETA, st.floats(0.0, 359.9))
def test_ideal_directions_follow_from_reflecting_the_vector(theta: float, phi: float) -> None:
    x, y, z = d.unit_from_angles_deg(theta, phi)
    for function, expected in ((d.mirror, (-x, -y, z)), (d.retro, (x, y, z)), (d.through, (-x, -y, -z))):
        assert d.angle_between_deg(d.unit_from_angles_deg(*function(theta, phi)), np.array(expected)) < 1e-12


@pytest.mark.parametrize("angle_deg", [0.0, 1e-9, 1e-4, 30.0, 90.0, 179.9999, 180.0])
def test_angle_between_is_exact_at_both_ends(angle_deg: float) -> None:
    u, v = d.unit_from_angles_deg(90.0, 10.0), d.unit_from_angles_deg(90.0, 10.0 + angle_deg)
    assert d.angle_between_deg(u, v) == pytest.approx(angle_deg, rel=1e-5, abs=1e-13)


@given(THETA, PHI)
def test_tangent_frame_is_a_rotation_with_the_pole_last(theta: float, phi: float) -> None:
    pole = d.unit_from_angles_deg(theta, phi)
    frame = d.tangent_frame(pole)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_array_equal(frame[2], pole)
