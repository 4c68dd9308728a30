"""test_lobe_gauss.py: values, derivatives and transformations of the lobe that is fitted."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gonio.model.lobes.gauss import Gauss

ANGLE = st.floats(0.0, 1.5)
AZIMUTH = st.floats(0.0, 6.28)


def direction(theta: float, phi: float) -> np.ndarray:
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def ellipse(first: float, second: float, turn: float) -> np.ndarray:
    axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return axes @ np.diag([first**2, second**2]) @ axes.T


def directions(count: int = 200) -> np.ndarray:
    rng = np.random.default_rng(5)
    unit = rng.normal(size=(count, 3))
    unit[:, 2] = np.abs(unit[:, 2])
    return unit / np.linalg.norm(unit, axis=1)[:, None]


@settings(max_examples=40, deadline=None)
@given(ANGLE, AZIMUTH, st.floats(0.05, 0.4), st.floats(0.05, 0.4), AZIMUTH, st.booleans())
def test_derivatives_are_those_of_differences(
    theta: float, phi: float, first: float, second: float, turn: float, circular: bool
) -> None:
    centre = direction(theta, phi)
    gauss = Gauss.of(centre, ellipse(first, second, turn), 3.0, circular=circular)
    unit = np.concatenate((directions(), centre[None, :]))
    value, slopes = gauss.value_and_slopes(unit)
    np.testing.assert_allclose(value, gauss.value(unit))
    assert len(slopes) == gauss.free
    for k in range(len(slopes)):
        step = np.zeros(len(slopes))
        step[k] = 1e-6
        difference = (gauss.stepped(step).value(unit) - gauss.stepped(-step).value(unit)) / 2e-6
        np.testing.assert_allclose(slopes[k], difference, atol=2e-5 * max(1.0, float(np.abs(difference).max())))


@settings(max_examples=40, deadline=None)
@given(ANGLE, AZIMUTH, AZIMUTH, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_a_lobe_is_the_same_in_its_own_frame_and_in_that_of_theta_and_phi(
    theta: float, phi: float, turn: float, along: float, across: float
) -> None:
    gauss = Gauss.of(direction(theta, phi), ellipse(0.1, 0.3, turn), 2.0).shifted(np.array([along, across]))
    np.testing.assert_allclose(gauss.frame @ gauss.frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(gauss.centre @ direction(theta, phi), np.cos(np.hypot(along, across)), atol=1e-12)
    unit = directions()
    np.testing.assert_allclose(gauss.lobe().dsf_per_sr(unit), gauss.value(unit), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(gauss.lobe().sigma_rad, [0.1, 0.3], rtol=1e-9)


def test_widening_keeps_the_power_and_can_be_undone() -> None:
    gauss = Gauss.of(direction(0.4, 1.0), ellipse(0.1, 0.2, 0.5), 7.0)
    wider = gauss.widened(0.02)
    np.testing.assert_allclose(wider.sigma**2, gauss.sigma**2 + 0.02)
    assert wider.lobe().power == pytest.approx(gauss.lobe().power)
    np.testing.assert_allclose(wider.widened(-0.02).covariance, gauss.covariance, rtol=1e-9)
    assert gauss.rounded().lobe().power == pytest.approx(gauss.lobe().power)
    np.testing.assert_allclose(gauss.rounded().sigma, np.sqrt(0.1 * 0.2))


def test_a_lobe_is_carried_to_another_centre_without_turning() -> None:
    gauss = Gauss.of(direction(0.5, 0.2), ellipse(0.1, 0.2, 0.3), 1.0)
    there = gauss.moved_to(direction(0.9, 0.6))
    np.testing.assert_allclose(there.centre, direction(0.9, 0.6), atol=1e-12)
    np.testing.assert_allclose(there.moved_to(gauss.centre).frame, gauss.frame, atol=1e-12)
