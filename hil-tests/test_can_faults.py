"""test_can_faults.py: bus-off, error passive, an interface that goes down, on a real CAN driver."""

import pytest

from harness.checks import assert_fault_end, assert_fault_sentence, assert_recovered, assert_safe, raw_log
from harness.results import Result


@pytest.mark.scenario("bus_off")
def test_bus_off_ends_the_scan_and_recovers(result: Result) -> None:
    assert_fault_end(result, "bus off")
    assert "ERROR-ACTIVE" in result.values["interface"]  # restarted by the kernel after restart-ms


@pytest.mark.scenario("error_passive")
def test_error_passive_is_a_warning_and_the_scan_goes_on(result: Result) -> None:
    assert "ERROR-PASSIVE" in result.values["interface"]
    assert result.command("raw").status == 0, result.command("raw").stderr
    assert "error passive" in result.goniod_log
    assert raw_log(result.raw()).problem is None
    assert_safe(result)
    assert_recovered(result)


@pytest.mark.scenario("interface_down")
def test_interface_down_is_told_and_homing_refused_until_it_is_up(result: Result) -> None:
    assert_fault_end(result, "CAN interface")
    assert_fault_sentence(result.command("home-while-down"), "CAN interface")
