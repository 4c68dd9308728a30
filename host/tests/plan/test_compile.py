"""test_compile.py: whole plans to programs: order of the steps, continuity, limits, refusals, notes."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.plan.compile import compile_loaded, compile_plan
from gonio.plan.knots import positions_deg
from gonio.plan.limits import find
from gonio.plan.program import DarkStep, OperatorStep, PathStep, Program, ShutterStep
from gonio.plan.schema import parse_plan
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
DEMO = Path(__file__).resolve().parents[3] / "docs" / "examples" / "demo.toml"
PEAK = "[[peak]]\nabout = {}\nradius_deg = 2\npitch_deg = 0.5\n"


def compiled(text: str) -> Program:
    return compile_loaded(parse_plan(text, "p.toml"), REFERENCE)


def paths(program: Program) -> list[PathStep]:
    return [step for step in program.steps if isinstance(step, PathStep)]


@pytest.fixture(scope="module")
def demo() -> Program:
    return compile_plan(DEMO, REFERENCE)


def test_the_order_of_the_demo(demo: Program) -> None:
    told: list[str] = []
    for step in demo.steps:
        match step:
            case OperatorStep():
                told.append(step.action)
            case ShutterStep():
                told.append("open" if step.open else "close")
            case DarkStep():
                told.append("dark")
            case PathStep():
                told.append(step.kind)
    head, each = ["close", "move", "dark", "open"], ["move", "dark", "open", "coarse"]
    assert told == [
        "sample_removed", *head, "reference", "close", "sample_mounted",
        *each, "move", "peak", "close",
        *each, "move", "peak", "move", "peak", "close",
        *each, "move", "peak", "move", "peak", "close",
    ]  # fmt: skip


def test_paths_join_keep_the_limits_and_are_numbered(demo: Program) -> None:
    steps = paths(demo)
    assert [step.path_id for step in steps] == list(range(1, len(steps) + 1))
    for before, after in pairwise(steps):
        assert_allclose(after.knots["position_counts"][0], before.knots["position_counts"][-1], atol=1e-6)
    for step in steps:
        assert find(step.knots, REFERENCE) is None
        spacing = np.diff(step.knots["time_ns"])
        assert spacing.min() >= 1_000_000
        assert spacing.max() <= 110_000_000


def test_incident_directions_are_those_of_the_plan(demo: Program) -> None:
    for step in paths(demo):
        if step.incident_theta_deg is not None and step.incident_phi_deg is not None:
            incident, _ = Kinematics(REFERENCE.axes).directions(positions_deg(step.knots, REFERENCE))
            wanted = unit_from_angles_deg(step.incident_theta_deg, step.incident_phi_deg)
            assert angle_between_deg(incident, wanted).max() < 1e-6


def test_the_reference_goes_round_straight_through(demo: Program) -> None:
    reference = next(step for step in paths(demo) if step.kind == "reference")
    incident, outgoing = Kinematics(REFERENCE.axes).directions(positions_deg(reference.knots, REFERENCE))
    assert angle_between_deg(outgoing[0], -incident[0]) < 1e-6
    assert angle_between_deg(outgoing[-1], -incident[-1]) == pytest.approx(2.5, abs=1e-6)


def test_the_shaded_mirror_peak_is_a_note(demo: Program) -> None:
    assert len(demo.metadata["notes"]) == 1
    assert demo.metadata["notes"][0].startswith("mirror 0/0 is not measured")
    assert not any(step.name == "mirror 0/0" for step in paths(demo))
    assert demo.metadata["sample"]["polarisation"] == "unpolarised"
    assert demo.metadata["beam"] == {"kind": "focused", "diameter_mm": 10.0, "divergence_deg": 1.0}


def test_a_requested_direction_out_of_reach_is_refused() -> None:
    with pytest.raises(UsageError, match=r"p.toml: peak \(90, 270\) 0/0: outgoing direction .* its limit is -85"):
        compiled("[scan]\nincident = [[0, 0]]\n" + PEAK.format("[90, 270]"))


def test_an_incident_direction_out_of_reach_is_refused() -> None:
    narrow = parse_plan("[scan]\nincident = [[150, 0]]\n[coarse]\n", "p.toml")
    text = REFERENCE.text.replace("max_deg = 185.0", "max_deg = 100.0")
    from gonio.units.instrument import parse_instrument  # noqa: PLC0415

    with pytest.raises(UsageError, match=r"incident direction \(150, 0\) is out of reach: sample azimuth would be 150"):
        compile_loaded(narrow, parse_instrument(text, "axes.toml"))


def test_a_peak_for_some_incident_directions_only() -> None:
    text = "[scan]\nincident = [[20, 0], [40, 90]]\n" + PEAK.format("'mirror'") + "for_incident = [[40, 90]]\n"
    measured = [step for step in paths(compiled(text)) if step.kind == "peak"]
    assert [(step.name, step.incident_theta_deg) for step in measured] == [("mirror 40/90", 40.0)]
    _, outgoing = Kinematics(REFERENCE.axes).directions(positions_deg(measured[0].knots, REFERENCE))
    assert angle_between_deg(outgoing[0], unit_from_angles_deg(40.0, 270.0)) < 1e-6


def test_sinusoids_use_the_speed_that_was_asked_for() -> None:
    program = compiled("[sinusoid]\namplitude_deg = 25\npeak_speed_deg_per_s = 29.9\nduration_s = 60\n")
    flown = paths(program)[-1]
    assert find(flown.knots, REFERENCE) is None
    speed = np.abs(flown.knots["velocity_counts_per_s"]).max(axis=0) / (10000.0 / 9.0)
    assert_allclose(speed, 29.9 * (1 - 0.07 * np.arange(4)), rtol=5e-3)
    assert flown.duration_s == pytest.approx(60.0)


def test_too_fast_sinusoids_are_refused() -> None:
    with pytest.raises(UsageError, match=r"sinusoid: .* sample azimuth would turn at"):
        compiled("[sinusoid]\namplitude_deg = 40\npeak_speed_deg_per_s = 31\nduration_s = 60\n")


def test_open_loop_axes_are_refused() -> None:
    instrument = load_instrument(None)
    blind = replace(
        instrument, axes=(instrument.axes[0], replace(instrument.axes[1], encoder=False), *instrument.axes[2:])
    )
    plan = Path(__file__).resolve().parents[3] / "docs" / "examples" / "lobe.toml"
    with pytest.raises(UsageError, match="sample roll: has no encoder"):
        compile_plan(plan, blind)
