"""test_interlocks.py: door, emergency stop, limit switch, STO in mid-scan, over real GPIO lines."""

import pytest

from harness.checks import assert_fault_end, assert_fault_sentence
from harness.results import Result


@pytest.mark.scenario("door_opened")
def test_open_door_ends_the_scan(result: Result) -> None:
    assert_fault_end(result, "door")


@pytest.mark.scenario("emergency_stop")
def test_emergency_stop_ends_the_scan(result: Result) -> None:
    assert_fault_end(result, "emergency stop")


@pytest.mark.scenario("limit_switch")
def test_limit_switch_ends_the_scan(result: Result) -> None:
    assert_fault_end(result, "limit switch")


@pytest.mark.scenario("sto_opened_and_closed")
def test_sto_opened_is_a_fault_until_it_is_closed(result: Result) -> None:
    assert_fault_end(result, "STO")
    assert_fault_sentence(result.command("home-while-open"), "STO")
