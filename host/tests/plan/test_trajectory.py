"""test_trajectory.py: time laws on spirals: on the track, at the speed asked for, within the limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.plan.arm import follow
from gonio.plan.knots import evaluate, pack, positions_deg
from gonio.plan.limits import find
from gonio.plan.spiral import spiral
from gonio.plan.trajectory import time_law
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)


@settings(max_examples=25, deadline=None)
@given(st.floats(5.0, 175.0), st.floats(100.0, 260.0), st.floats(1.0, 6.0), st.floats(0.1, 1.0), st.floats(1.0, 30.0))
def test_spirals_are_flown_on_the_track_within_the_limits(
    theta: float, phi: float, radius: float, pitch: float, speed: float
) -> None:
    centre = unit_from_angles_deg(theta, phi)
    track = spiral(centre, radius, pitch)
    try:
        curve = follow(track, (40.0, 0.0), REFERENCE, "peak")
    except UsageError as error:
        assert "limit" in str(error) or "enter" in str(error)  # noqa: PT017 - either outcome is checked
        return
    knots = pack(time_law(curve, speed, REFERENCE), REFERENCE)
    assert find(knots, REFERENCE) is None
    q = positions_deg(knots, REFERENCE, every_s=0.003)
    outgoing = Kinematics(REFERENCE.axes).directions(q)[1]
    along = np.concatenate(([0.0], np.cumsum(angle_between_deg(outgoing[1:], outgoing[:-1]))))
    assert along[-1] == pytest.approx(track.length_deg[-1], rel=2e-3)
    step = knots["time_ns"][-1] * 1e-9 / (len(q) - 1)
    assert (np.diff(along) / step).max() < speed * 1.01
    # On the Archimedean spiral: rho = pitch * turns; by the track's length.
    expected = np.stack([np.interp(along, track.length_deg, track.unit[:, i]) for i in range(3)], axis=1)
    assert angle_between_deg(outgoing, expected / np.linalg.norm(expected, axis=1, keepdims=True)).max() < 0.25 * pitch


def test_knots_lie_on_the_spiral_and_rest_at_both_ends() -> None:
    centre = unit_from_angles_deg(30.0, 180.0)
    curve = follow(spiral(centre, 5.0, 0.25), (30.0, 0.0), REFERENCE, "mirror")
    knots = pack(time_law(curve, 30.0, REFERENCE), REFERENCE)
    times = np.linspace(0.0, float(knots["time_ns"][-1]), 20001)
    scale = np.array([axis.counts_per_deg for axis in REFERENCE.axes])
    outgoing = Kinematics(REFERENCE.axes).directions(evaluate(knots, times)[0] / scale)[1]
    rho = angle_between_deg(outgoing, centre)
    assert rho[0] == pytest.approx(0.0, abs=1e-9)
    assert rho[-1] == pytest.approx(5.0, abs=1e-9)
    assert np.diff(rho).min() > -1e-6
    assert 20.0 < knots["time_ns"][-1] * 1e-9 < 45.0
    for name in ("velocity_counts_per_s", "acceleration_counts_per_s2"):
        assert_allclose(knots[name][[0, -1]], 0.0, atol=0.0)


def test_derivatives_of_the_axes_follow_from_the_track() -> None:
    curve = follow(spiral(unit_from_angles_deg(70.0, 120.0), 6.0, 0.5), (20.0, 35.0), REFERENCE, "peak")
    slope = np.gradient(curve.q_deg, curve.length_deg, axis=0, edge_order=2)
    bend = np.gradient(curve.d_q, curve.length_deg, axis=0, edge_order=2)
    assert_allclose(slope[100:-2], curve.d_q[100:-2], atol=2e-3)
    assert_allclose(bend[200:-2], curve.dd_q[200:-2], atol=2e-2)


def test_a_peak_out_of_reach_names_direction_and_limit() -> None:
    below = spiral(unit_from_angles_deg(90.0, 270.0), 2.0, 0.5)
    with pytest.raises(
        UsageError, match=r"peak x: outgoing direction .* arm elevation would be -90.0 deg, its limit is"
    ):
        follow(below, (0.0, 0.0), REFERENCE, "peak x")
