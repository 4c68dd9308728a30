"""test_other_buses.py: the same firmware on vcan and on a real driver's SJA1000 chips."""

import pytest

from harness.checks import assert_nothing_lost, assert_safe, assert_sample_clock, assert_whole, raw_log
from harness.results import Result


@pytest.mark.scenario("on_virtual_bus")
def test_virtual_bus_serves_a_scan(result: Result) -> None:
    for name in ("home", "raw"):
        assert result.command(name).status == 0, result.command(name).stderr
    assert_nothing_lost(result.raw())
    assert_sample_clock(raw_log(result.raw()))
    assert_safe(result)


@pytest.mark.scenario("on_pci_cards")
def test_pci_cards_serve_a_scan(result: Result) -> None:
    for name in ("home", "raw"):
        assert result.command(name).status == 0, result.command(name).stderr
    assert_whole(result.raw())  # the emulated chips may lose frames of the bus, and the firmware counts them
    assert_sample_clock(raw_log(result.raw()))
    assert_safe(result)
