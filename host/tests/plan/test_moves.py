"""test_moves.py: moves between paths: within the limits, round zones, from where the axes stand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from gonio.plan.knots import positions_deg
from gonio.plan.limits import find, in_zone
from gonio.plan.moves import move, starting_at
from gonio.plan.program import PathStep, Program, ShutterStep, Step
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
PER_DEG = 10000.0 / 9.0
POSE = st.tuples(st.floats(-5, 185), st.floats(-5, 365), st.floats(-200, 200), st.floats(-77, 89))


@settings(max_examples=60, deadline=None)
@given(POSE, POSE)
def test_moves_keep_the_limits_and_end_where_asked(start: tuple[float, ...], end: tuple[float, ...]) -> None:
    knots = move(np.array(start), np.array(end), REFERENCE, "move")
    assert find(knots, REFERENCE) is None
    assert_allclose(knots["position_counts"][0], np.array(start) * PER_DEG, atol=1e-6)
    assert_allclose(knots["position_counts"][-1], np.array(end) * PER_DEG, atol=1e-6)
    assert (np.diff(knots["time_ns"]) >= 1_000_000).all()


def test_a_long_move_takes_the_time_of_its_slowest_axis() -> None:
    knots = move(np.zeros(4), np.array([0.0, 0.0, 150.0, 10.0]), REFERENCE, "move")
    # 150 degrees at 29.7/s, and half a ramp at each end of at least v / a.
    assert 150 / 29.7 + 0.5 < knots["time_ns"][-1] * 1e-9 < 150 / 29.7 + 1.2


def test_no_distance_is_a_short_path() -> None:
    knots = move(np.ones(4), np.ones(4), REFERENCE, "move")
    assert len(knots) == 2
    assert find(knots, REFERENCE) is None


def test_the_way_round_a_zone() -> None:
    start, end = np.array([0.0, 0.0, 140.0, -84.0]), np.array([0.0, 0.0, 190.0, -70.0])
    knots = move(start, end, REFERENCE, "move")
    assert find(knots, REFERENCE) is None
    assert not in_zone(positions_deg(knots, REFERENCE, every_s=0.005), REFERENCE).any()


def test_out_of_the_column_after_homing() -> None:
    # Homed on the negative switches the arm stands in the column, and outside its limits.
    knots = move(np.array([-6.0, -6.0, -201.0, -86.0]), np.array([30.0, 0.0, -60.0, 0.0]), REFERENCE, "move")
    assert find(knots, REFERENCE) is None


def test_into_a_zone_is_refused_with_its_name() -> None:
    with pytest.raises(UsageError, match=r"move x: at the outgoing direction .* would enter .sample holder's column"):
        move(np.zeros(4), np.array([0.0, 0.0, 170.0, -80.0]), REFERENCE, "move x")


def test_starting_at_leads_the_first_move_in() -> None:
    way = move(np.zeros(4), np.array([10.0, 0.0, 50.0, 20.0]), REFERENCE, "move to a")
    steps: list[Step] = [
        ShutterStep(open=False),
        PathStep(1, "move", "move to a", way),
        PathStep(2, "move", "move to b", way),
    ]
    standing = np.array([1234, -5678, 9012, -3456])
    program = starting_at(Program(steps=list(steps)), standing, REFERENCE)
    first = program.steps[1]
    assert isinstance(first, PathStep)
    assert first.path_id == 1
    assert_allclose(first.knots["position_counts"][0], standing, atol=1e-6)
    assert_allclose(first.knots["position_counts"][-1], way["position_counts"][-1], atol=1e-6)
    assert program.steps[2] is steps[2]
