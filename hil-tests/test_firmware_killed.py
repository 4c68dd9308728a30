"""test_firmware_killed.py: goniod dies in mid-scan: drives and shutter board bring everything to rest by themselves."""

import json

import pytest
from gonio.units.instrument import Instrument, load_instrument

from harness.bus import Emergency, emergencies
from harness.checks import assert_fault_sentence, assert_recovered, assert_safe, raw_log
from harness.results import Result
from harness.rig import Rig

RPDO_DEADLINE, HEARTBEAT_LOST = 0x8250, 0x8130  # EMCY, CiA 301
UNGUARDED_WAY_DEG = 1.0  # firmware/core/canopen/unguarded.h


def assert_came_to_rest_alone(result: Result) -> None:
    assert result.values["status"] == -9
    assert max(map(abs, result.state("measuring")["speed_deg_per_s"])) > 1.0
    assert_safe(result)
    command = result.command("raw")
    assert command.status == 3, command.stderr
    assert len(raw_log(result.raw()).sample_number) > 0
    assert result.values["unplugged"]  # the host sees the USB link go
    assert json.loads(result.command("info").stdout)["state"] == "unconfigured"  # no position is taken over
    assert_recovered(result)


def first_emergencies(result: Result, instrument: Instrument) -> list[Emergency]:
    """What each drive said first, from the kill to the next start."""
    log = result.session / "candump-sim.1.out"
    told = emergencies(log, result.values["killed_at_s"], result.values["restarted_at_s"])
    nodes = {axis.node for axis in instrument.axes}
    assert {emergency.node for emergency in told} == nodes
    return [next(emergency for emergency in told if emergency.node == node) for node in sorted(nodes)]


@pytest.mark.scenario("firmware_killed")
def test_rpdo_deadline_acts_before_the_heartbeat_could(result: Result, rig: Rig) -> None:
    assert_came_to_rest_alone(result)
    instrument = load_instrument(rig.file("instrument"))
    cycle = instrument.cycle
    # The last heartbeat went out no longer before the kill than a heartbeat's period.
    heartbeat_lost_s = result.values["killed_at_s"] + 1e-3 * (cycle.heartbeat_timeout_ms - cycle.firmware_heartbeat_ms)
    for emergency in first_emergencies(result, instrument):
        assert emergency.code == RPDO_DEADLINE
        assert emergency.time_s < heartbeat_lost_s


@pytest.mark.scenario("firmware_killed_without_deadline")
def test_axes_without_a_deadline_stop_dead(result: Result, rig: Rig) -> None:
    assert_came_to_rest_alone(result)
    before, after = (result.state(label)["position_deg"] for label in ("measuring", "out of operation"))
    assert max(abs(b - a) for a, b in zip(before, after, strict=True)) <= UNGUARDED_WAY_DEG
    instrument = load_instrument(rig.folder / "vm-axes-unguarded.toml")
    assert {emergency.code for emergency in first_emergencies(result, instrument)} == {HEARTBEAT_LOST}


@pytest.mark.scenario("firmware_killed_without_deadline")
def test_axes_without_a_deadline_may_not_go_fast(result: Result) -> None:
    assert_fault_sentence(result.command("refused"), "0x1400:05", "max_velocity_deg_per_s")


@pytest.mark.scenario("firmware_frozen")
def test_shutter_board_closes_when_the_watchdog_stays_away(result: Result) -> None:
    assert_came_to_rest_alone(result)
    assert result.state("safe")["watchdog_trips"] == result.values["watchdog_trips"] + 1
