"""test_spiral.py: the spiral's pitch, coverage, length and derivatives."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from gonio.geometry.directions import angle_between_deg, tangent_frame, unit_from_angles_deg
from gonio.plan.spiral import spiral

ANGLES = (st.floats(0.0, 180.0), st.floats(0.0, 360.0))


@settings(max_examples=30, deadline=None)
@given(*ANGLES, st.floats(1.0, 20.0), st.floats(0.3, 2.0), st.integers(0, 2**32))
def test_no_point_of_the_cap_is_far_from_the_track(
    theta: float, phi: float, radius: float, pitch: float, seed: int
) -> None:
    centre = unit_from_angles_deg(theta, phi)
    radius = max(radius, pitch)
    track = spiral(centre, radius, pitch)
    random = np.random.default_rng(seed)
    frame = tangent_frame(centre)
    for _ in range(20):
        rho, azimuth = np.radians((radius - 0.5 * pitch) * np.sqrt(random.random())), 2 * np.pi * random.random()
        local = np.array([np.sin(rho) * np.cos(azimuth), np.sin(rho) * np.sin(azimuth), np.cos(rho)])
        nearest = angle_between_deg(local @ frame, track.unit).min()
        # Half a pitch across the track, and the steps along it.
        assert nearest < 0.5 * pitch + 0.02 * radius


@settings(max_examples=20, deadline=None)
@given(*ANGLES, st.floats(0.1, 1.0))
def test_turns_are_a_pitch_apart(theta: float, phi: float, pitch: float) -> None:
    centre = unit_from_angles_deg(theta, phi)
    radius = 6.0 * pitch
    track = spiral(centre, radius, pitch)
    rho = angle_between_deg(track.unit, centre)
    local = track.unit @ tangent_frame(centre).T
    turns = np.unwrap(np.arctan2(local[1:, 1], local[1:, 0])) / (2 * np.pi)
    rho_of_turn = np.interp(turns + 1.0, turns, rho[1:])
    inside = turns + 1.0 <= turns[-1]
    assert_allclose((rho_of_turn - rho[1:])[inside], pitch, atol=1e-6)
    assert_allclose(rho[-1], radius, atol=1e-9)


def test_length_and_derivatives() -> None:
    track = spiral(unit_from_angles_deg(40.0, 70.0), 8.0, 0.5)
    # On the plane the length of an Archimedean spiral is a / 2 (w sqrt(1 + w^2) + asinh w); the sphere takes 0.16 %.
    w = 2 * np.pi * 8.0 / 0.5
    plane = 0.5 / (2 * np.pi) / 2 * (w * np.sqrt(1 + w**2) + np.arcsinh(w))
    assert_allclose(track.length_deg[-1], plane, rtol=3e-3)
    assert_allclose(track.length_deg[-1], angle_between_deg(track.unit[1:], track.unit[:-1]).sum(), rtol=1e-3)
    assert_allclose(np.linalg.norm(np.degrees(track.d_unit), axis=1), 1.0, atol=1e-12)
    slope = np.gradient(track.unit, track.length_deg, axis=0, edge_order=2)
    bend = np.gradient(track.d_unit, track.length_deg, axis=0, edge_order=2)
    assert_allclose(slope[50:-2], track.d_unit[50:-2], atol=2e-5)
    assert_allclose(bend[50:-2], track.dd_unit[50:-2], atol=2e-4)
