"""test_firmware_killed.py: goniod dies in mid-scan: drives and shutter board bring everything to rest by themselves."""

import json

import pytest

from harness.checks import assert_recovered, assert_safe, raw_log
from harness.results import Result


def assert_came_to_rest_alone(result: Result) -> None:
    assert result.values["status"] == -9
    assert max(map(abs, result.values["speed_before"])) > 1.0
    assert_safe(result)
    command = result.command("raw")
    assert command.status == 3, command.stderr
    assert len(raw_log(result.raw()).sample_number) > 0
    assert result.values["unplugged"]  # the host sees the USB link go
    assert json.loads(result.command("info").stdout)["state"] == "unconfigured"  # no position is taken over
    assert_recovered(result)


@pytest.mark.scenario("firmware_killed")
def test_rpdo_deadline_stops_the_axes(result: Result) -> None:
    assert_came_to_rest_alone(result)
    frames = (result.session / "candump-sim.1.out").read_text()
    assert "8250" in json.dumps(result.values) or "5082" in frames  # EMCY 0x8250, RPDO time-out


@pytest.mark.scenario("firmware_killed_basic_drives")
def test_drives_without_a_deadline_come_to_rest_too(result: Result) -> None:
    assert_came_to_rest_alone(result)
