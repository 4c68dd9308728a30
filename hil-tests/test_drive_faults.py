"""test_drive_faults.py: a drive falls silent, was never there, reports trouble."""

import pytest

from harness.checks import assert_fault_end, assert_fault_sentence, assert_recovered, assert_safe, raw_log
from harness.results import Result


@pytest.mark.scenario("node_silent")
def test_silent_node_ends_the_scan(result: Result) -> None:
    assert_fault_end(result, "node 3")


@pytest.mark.scenario("node_never_there")
def test_missing_node_is_named(result: Result) -> None:
    assert_fault_sentence(result.command("raw"), "node 3")
    assert_safe(result)
    raw_log(result.raw())
    assert_recovered(result)


@pytest.mark.scenario("emergency_message")
def test_emergency_message_is_told_with_its_code(result: Result) -> None:
    assert_fault_end(result, "node 3", "0x4310")
