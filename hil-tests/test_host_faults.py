"""test_host_faults.py: the host is killed, its cable pulled, its disk full, its clock stepped."""

import pytest

from harness.checks import assert_recovered, assert_safe, complaints, raw_log
from harness.results import Result


@pytest.mark.scenario("host_killed")
def test_killed_host_leaves_a_safe_arm_and_a_readable_log(result: Result) -> None:
    assert result.command("raw").status == -9
    assert_safe(result)
    assert len(raw_log(result.raw()).sample_number) > 0
    assert_recovered(result)


@pytest.mark.scenario("link_unplugged")
def test_unplugged_link_is_an_instrument_fault(result: Result) -> None:
    command = result.command("raw")
    assert command.status == 3, command.stderr
    assert len(complaints(command)) == 1
    assert_safe(result)
    assert len(raw_log(result.raw()).sample_number) > 0
    assert_recovered(result)


@pytest.mark.scenario("disk_full")
def test_full_disk_stops_safely_and_keeps_what_was_written(result: Result) -> None:
    command = result.command("raw")
    assert command.status != 0
    assert any("no space" in line.lower() for line in complaints(command)), command.stderr
    assert_safe(result)
    raw_log(result.raw())
    assert_recovered(result)


@pytest.mark.scenario("clock_stepped")
def test_clock_step_is_flagged_and_shifts_no_time(result: Result) -> None:
    assert result.command("raw").status == 0, result.command("raw").stderr
    log = raw_log(result.raw())
    counters = [event.counters for event in log.events if event.HasField("counters")][-1]
    assert counters.clock_steps >= 1
    steps_ns = log.poses["sync_time_ns"][1:] - log.poses["sync_time_ns"][:-1]
    assert steps_ns.max() < 1_000_000_000  # an hour's step would show here
    assert steps_ns.min() > 0
