"""test_limits.py: the host's copy of the firmware's checks against closed forms and dense sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import KnotArray, evaluate
from gonio.plan.limits import HOLD_RATE_PER_S, find, first_inside, first_outside, require_allowed
from gonio.protocol.generated.records import KNOT_DTYPE
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
PER_DEG = 10000.0 / 9.0


def rest_to_rest(end_deg: list[float], duration_s: float, start_deg: list[float] | None = None) -> KnotArray:
    """One minimum-jerk segment: largest speed 15/8, largest acceleration 10/sqrt(3) of the mean's."""
    knots = np.zeros(2, KNOT_DTYPE)
    knots["time_ns"][1] = round(duration_s * 1e9)
    knots["position_counts"][0] = np.array(start_deg or [0, 0, 0, 0]) * PER_DEG
    knots["position_counts"][1] = np.array(end_deg) * PER_DEG
    return knots


@pytest.mark.parametrize(
    ("end_deg", "duration_s", "what"),
    [
        ([0, 0, 90, 40], 10.0, None),
        ([0, 0, 0, 89], 15 / 8 * 89 / 30, None),
        ([0, 0, 0, 89], 15 / 8 * 89 / 30.01, "arm elevation would turn at 30.01 deg/s, its limit is 30"),
        ([0, 0, 0, 89.01], 20.0, "arm elevation would be 89.01 deg, its limit is 89"),
        ([-6, 0, 0, 0], 20.0, "sample azimuth would be -6.00 deg, its limit is -5"),
        ([0, 0, 4, 0], 0.5, "arm azimuth would accelerate at"),
        ([0, 0, 170, -80], 30.0, 'the arm would enter "sample holder\'s column"'),
    ],
)
def test_closed_forms(end_deg: list[float], duration_s: float, what: str | None) -> None:
    finding = find(rest_to_rest(end_deg, duration_s), REFERENCE)
    assert (finding is None) == (what is None)
    if what is not None and finding is not None:
        assert finding.what.startswith(what)


def test_an_axis_outside_may_come_back_but_not_go_farther() -> None:
    homed = [-6.0, -6.0, -201.0, -86.0]
    assert find(rest_to_rest([0, 0, -201, 0], 20.0, homed), REFERENCE) is None
    assert find(rest_to_rest([-7, 0, 0, 0], 20.0, homed), REFERENCE) is not None


def test_the_sentence_names_direction_and_limit() -> None:
    with pytest.raises(
        UsageError, match=r"^x: at the outgoing direction \(45\.0, 90\.0\) arm elevation would be 90\.00"
    ):
        require_allowed(rest_to_rest([0, 0, 0, 90], 20.0), REFERENCE, Kinematics(REFERENCE.axes), "x")


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32))
def test_what_passes_keeps_the_limits_everywhere(seed: int) -> None:
    random = np.random.default_rng(seed)
    knots = np.zeros(6, KNOT_DTYPE)
    knots["time_ns"] = np.arange(6) * 1_000_000_000
    knots["position_counts"] = np.cumsum(random.uniform(-14.0, 14.0, (6, 4)), axis=0) * PER_DEG + 20 * PER_DEG
    knots["velocity_counts_per_s"][1:-1] = random.uniform(-15.0, 15.0, (4, 4)) * PER_DEG
    finding = find(knots, REFERENCE)
    q, v, a = (x / PER_DEG for x in evaluate(knots, np.linspace(0.0, 5e9, 20001)))
    low = np.minimum([axis.min_deg for axis in REFERENCE.axes], q[0])
    high = np.maximum([axis.max_deg for axis in REFERENCE.axes], q[0])
    inside = bool((q >= low - 1e-3).all() and (q <= high + 1e-3).all())
    kept = bool(np.abs(v).max() <= 30.0 * (1 + 1e-6)) and bool(
        (np.abs(a) + HOLD_RATE_PER_S * np.abs(v)).max() <= 60.0 * (1 + 1e-6)
    )
    assert (finding is None) == (inside and kept)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), min_size=1, max_size=5), st.floats(0.1, 0.9))
def test_first_outside_agrees_with_sampling(rows: list[list[float]], limit: float) -> None:
    coefficients = np.array(rows)
    u = np.linspace(0.0, 1.0, 4001)[:, None]
    weights = np.array([1, 5, 10, 10, 5, 1]) * u ** np.arange(6) * (1 - u) ** np.arange(5, -1, -1)
    most = np.abs(coefficients @ weights.T).max(axis=1)
    found = first_outside(coefficients, -limit, limit)
    if found is None:
        assert most.max() <= limit + 1e-12
    else:
        assert most[found] > limit - 1e-5
        assert (most[:found] <= limit + 1e-12).all()


def test_first_inside_needs_one_half_space_per_piece() -> None:
    # Two half-spaces: the first half of the way is outside of one, the second of the other.
    ramp = np.linspace(1.0, -1.0, 6)
    clear = np.stack((ramp + 0.01, -ramp + 0.01), axis=1)[None]
    touched = np.stack((ramp - 0.01, -ramp - 0.01), axis=1)[None]
    assert first_inside(clear) is None
    assert first_inside(np.concatenate((clear, touched))) == 1
