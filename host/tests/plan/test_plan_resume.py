"""test_plan_resume.py: what is left of a program: whole paths, the rest of one on its curve, dark signals again."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from scipy.spatial import cKDTree

from gonio.plan.compile import compile_plan
from gonio.plan.knots import evaluate, positions_deg
from gonio.plan.limits import find
from gonio.plan.program import DarkStep, OperatorStep, PathStep, Program
from gonio.plan.resume import remaining, retimed
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
PROGRAM = compile_plan(Path(__file__).resolve().parents[3] / "docs" / "examples" / "demo.toml", REFERENCE)
MEASURED = [step for step in PROGRAM.steps if isinstance(step, PathStep) and step.kind != "move"]


def measured_ids(program: Program) -> list[int]:
    return [step.path_id for step in program.steps if isinstance(step, PathStep) and step.kind != "move"]


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(MEASURED), st.floats(0.001, 0.9999))
def test_the_rest_lies_on_the_same_curve(path: PathStep, share: float) -> None:
    from_ns = int(share * path.knots["time_ns"][-1])
    rest = retimed(path.knots, from_ns)
    assert find(rest, REFERENCE) is None
    assert rest["time_ns"][0] == 0
    assert (np.diff(rest["time_ns"]) >= 1_000_000).all()
    start = evaluate(path.knots, np.array([float(from_ns)]))[0][0]
    assert np.abs(rest["position_counts"][0] - start).max() < 1e-6
    assert_array_equal(rest["position_counts"][-1], path.knots["position_counts"][-1])
    old = positions_deg(path.knots[path.knots["time_ns"] > from_ns - 200_000_000], REFERENCE, every_s=0.002)
    distance, _ = cKDTree(old).query(positions_deg(rest, REFERENCE, every_s=0.05))
    assert distance.max() < 0.04  # half the spacing of the old curve's samples: 0.03 degrees and a little
    longer_s = (rest["time_ns"][-1] - (path.knots["time_ns"][-1] - from_ns)) * 1e-9
    assert 0.0 < longer_s < 1.9  # half the ramp of 3.75 s


def test_nothing_done_is_the_whole_program() -> None:
    rest = remaining(PROGRAM, set(), None)
    assert measured_ids(rest) == measured_ids(PROGRAM)
    darks = [step for step in rest.steps if isinstance(step, DarkStep)]
    assert darks == [step for step in PROGRAM.steps if isinstance(step, DarkStep)]


@pytest.mark.parametrize("done", range(1, len(MEASURED)))
def test_after_any_path_the_rest_is_complete(done: int) -> None:
    ids = [step.path_id for step in MEASURED]
    rest = remaining(PROGRAM, set(ids[:done]), None)
    assert measured_ids(rest) == ids[done:]
    asked = [step.action for step in rest.steps if isinstance(step, OperatorStep)]
    assert asked == ["sample_mounted"]
    used = {step.path_id for step in PROGRAM.steps if isinstance(step, PathStep)}
    moves = [step for step in rest.steps if isinstance(step, PathStep) and step.kind == "move"]
    assert not used & {step.path_id for step in moves}
    flown = [step for step in rest.steps if isinstance(step, PathStep)]
    for before, after in pairwise(flown):
        gap = before.knots["position_counts"][-1] - after.knots["position_counts"][0]
        assert np.abs(gap).max() < 1e-6
    kinds = [type(step).__name__ for step in rest.steps]
    assert kinds[:5] == ["OperatorStep", "ShutterStep", "PathStep", "DarkStep", "ShutterStep"]


def test_an_interrupted_reference_keeps_the_sample_out() -> None:
    rest = remaining(PROGRAM, set(), (2, 5_000_000_000))
    asked = [step.action for step in rest.steps if isinstance(step, OperatorStep)]
    assert asked == ["sample_removed", "sample_mounted"]
    assert measured_ids(rest) == measured_ids(PROGRAM)


def test_a_partial_path_at_its_end_is_done() -> None:
    last = MEASURED[0]
    rest = remaining(PROGRAM, set(), (last.path_id, int(last.knots["time_ns"][-1])))
    assert measured_ids(rest) == measured_ids(PROGRAM)[1:]


def test_everything_done_leaves_nothing() -> None:
    assert remaining(PROGRAM, set(measured_ids(PROGRAM)), None).steps == []


def test_a_rest_can_be_interrupted_again() -> None:
    once = remaining(PROGRAM, {2}, (4, 100_000_000_000))
    twice = remaining(once, set(), (4, 50_000_000_000))
    assert measured_ids(twice) == measured_ids(once)
    path = next(step for step in twice.steps if isinstance(step, PathStep) and step.path_id == 4)
    assert find(path.knots, REFERENCE) is None
    # 100 s, then 50 s less half the first ramp: of 416.8 s, plus half a ramp again.
    assert path.duration_s == pytest.approx(416.77 - 100.0 - 50.0 + 3.75, abs=0.1)
