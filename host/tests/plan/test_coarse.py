"""test_coarse.py: the coarse pass: order, pitch, coverage of the reachable sphere, limits, wrap and zones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial import cKDTree

from gonio.geometry.kinematics import Kinematics
from gonio.plan.circles import Coverage, elevations, unreachable
from gonio.plan.coarse import coarse_pass
from gonio.plan.knots import FloatArray, pack, positions_deg
from gonio.plan.limits import find, reasons_out_of_reach
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)


def flown(coverage: Coverage, speed: float = 30.0) -> tuple[FloatArray, FloatArray]:
    """Readings and outgoing unit vectors along the pass, after the firmware's checks."""
    knots = pack(coarse_pass(coverage, speed), REFERENCE)
    assert find(knots, REFERENCE) is None
    q = positions_deg(knots, REFERENCE, every_s=0.01)
    return q, Kinematics(REFERENCE.axes).directions(q)[1]


@settings(max_examples=12, deadline=None)
@given(st.floats(3.0, 15.0), st.sampled_from(["whole", "front", "back"]), st.floats(0.0, 170.0), st.integers(0, 2**32))
def test_no_reachable_direction_is_far_from_the_track(pitch: float, sphere: str, q1: float, seed: int) -> None:
    coverage = Coverage(REFERENCE, (q1, 40.0), pitch, sphere)
    _, track = flown(coverage)
    random = np.random.default_rng(seed)
    azimuth = random.uniform(-180.0, 180.0, 2000)
    elevation = np.degrees(np.arcsin(random.uniform(-1.0, 1.0, 2000)))
    q = coverage.readings(azimuth, elevation)
    reachable = np.array([reason is None for reason in reasons_out_of_reach(q, REFERENCE)])
    outgoing = Kinematics(REFERENCE.axes).directions(q)[1]
    if sphere != "whole":
        reachable &= (outgoing[:, 2] > 0.0) == (sphere == "front")
    chord, _ = cKDTree(track).query(outgoing[reachable])
    apart = np.degrees(2 * np.arcsin(chord / 2))
    # Circles rise over the holder's column on a ramp of up to 36 degrees of azimuth: its corner has one pitch.
    corner = ((np.abs(azimuth) > 100.0) & (elevation < -77.0))[reachable]
    assert apart[~corner].max() < 0.75 * pitch
    assert apart[corner].max(initial=0.0) < 1.05 * pitch


@given(st.floats(0.5, 30.0))
def test_circles_are_a_pitch_apart(pitch: float) -> None:
    rows = elevations(REFERENCE, pitch)
    assert 0.0 in rows
    assert_allclose(np.diff(rows)[1:-1], pitch, atol=1e-9)
    assert np.diff(rows).max() <= pitch + 1e-9
    assert rows[0] >= -85.0
    assert rows[-1] <= 89.0


def test_circles_are_interleaved_and_flown_without_stopping() -> None:
    coverage = Coverage(REFERENCE, (30.0, 0.0), 6.0, "whole")
    motion = coarse_pass(coverage, 30.0)
    fast = np.abs(motion.velocity_deg_per_s[:, 2]) > 1.0
    cruising = fast & (np.abs(motion.acceleration_deg_per_s2[:, 2]) < 1e-9)
    visited = [round(e) for e in motion.q_deg[cruising & (np.abs(motion.q_deg[:, 2]) < 60.0), 3]]
    order = [e for i, e in enumerate(visited) if i == 0 or visited[i - 1] != e]
    assert order == [*range(-84, 85, 12), 87, *range(78, -79, -12)]
    speed = np.hypot(motion.velocity_deg_per_s[1:-1, 2], motion.velocity_deg_per_s[1:-1, 3])
    under_way = (motion.time_s[1:-1] > 1.0) & (motion.time_s[1:-1] < motion.time_s[-1] - 1.0)
    # Slowest where the azimuth reverses at the top: half a pitch (84 to 87) in the time of a turn, 15/8 of the mean.
    assert speed[under_way].min() > 0.95 * 15 / 8 * 3.0 / 1.76
    inner = motion.q_deg[cruising][:, 2]
    assert inner.min() == pytest.approx(-180.0, abs=0.1)
    assert np.abs(motion.q_deg[:, 2]).max() < 200.0
    assert 300.0 < motion.time_s[-1] < 420.0


def test_knots_are_continuous_and_their_derivatives_true() -> None:
    motion = coarse_pass(Coverage(REFERENCE, (0.0, 0.0), 6.0, "whole"), 30.0)
    h = np.diff(motion.time_s)[:, None]
    # Hermite's corrected trapezoid: the error of a smooth curve is of order h^5.
    v, a = motion.velocity_deg_per_s, motion.acceleration_deg_per_s2
    step = 0.5 * h * (v[1:] + v[:-1]) + h**2 / 12 * (a[:-1] - a[1:])
    error = np.abs(np.diff(motion.q_deg, axis=0) - step)
    # Larger only where a lift begins or ends: its third derivative jumps there, by 340 degrees/s3 at most.
    assert np.quantile(error, 0.995) < 1e-5
    assert error.max() < 340.0 * 0.05**3 / 12.0


def test_unreachable_directions_carry_their_reason() -> None:
    lost = unreachable(Coverage(REFERENCE, (30.0, 0.0), 6.0, "whole"), (30.0, 0.0))
    reasons = {direction.reason for direction in lost}
    assert 'the arm would enter "sample holder\'s column"' in reasons
    assert "arm elevation would be -90.0 deg, its limit is -85" in reasons
    for direction in lost:
        # Straight down is (90, 270) in the sample frame; the axis about the vertical does not move it.
        down = np.cos(np.radians(direction.phi_deg - 270.0)) * np.sin(np.radians(direction.theta_deg))
        assert down > np.sin(np.radians(78.0)) - 1e-12
