"""test_watcher.py: python-canopen, independent of our code, reads what candump saw and agrees with the firmware."""

from dataclasses import dataclass, field
from pathlib import Path

import canopen
import numpy as np
import pytest
from gonio.units.instrument import load_instrument

from harness.bus import frames
from harness.checks import raw_log
from harness.results import Result
from harness.rig import Rig
from harness.session import ROOT

EDS = ROOT / "protocol" / "eds" / "gonio_full.eds"
SYNC = 0x080
SDO_REQUEST = 0x600
EXPEDITED = 0x23  # download, with size
OPERATIONAL = "OPERATIONAL"
LEAST_VALID = 0.9  # emulated drives are late now and then; such positions are flagged
HEARTBEAT_MS, FOLLOWING_ERROR = 0x1017, 0x6065


@dataclass
class Watcher:
    """The canopen network of the drives, fed by hand; it has no bus and can send nothing."""

    nodes: tuple[int, ...]
    states: dict[int, set[str]] = field(default_factory=dict)
    written: dict[tuple[int, int, int], int] = field(default_factory=dict)  # node, index, subindex: last raw value
    positions: list[list[int | None]] = field(default_factory=list)  # per SYNC, per node

    def watch(self, log: Path) -> None:
        network = canopen.Network()
        drives = {number: network.add_node(number, str(EDS)) for number in self.nodes}
        for number, drive in drives.items():
            pdo = drive.tpdo[1]
            pdo.clear()
            pdo.add_variable(0x6041)
            pdo.add_variable(0x6064)
            pdo.cob_id, pdo.enabled = 0x180 + number, True
            pdo.subscribe()
        for message in frames(log):
            identifier, data = message.arbitration_id, bytearray(message.data)
            if identifier == SYNC:
                self.positions.append([None] * len(self.nodes))
            network.notify(identifier, data, message.timestamp)
            number = identifier & 0x7F
            if number not in drives:
                continue
            if identifier == 0x180 + number and self.positions:
                value = drives[number].tpdo[1].map[1].raw
                self.positions[-1][self.nodes.index(number)] = value
            elif identifier == 0x700 + number:
                self.states.setdefault(number, set()).add(drives[number].nmt.state)
            elif identifier == SDO_REQUEST + number and data[0] & 0xE3 == EXPEDITED:
                size = 4 - ((data[0] >> 2) & 3)
                key = (number, int.from_bytes(data[1:3], "little"), data[3])
                self.written[key] = int.from_bytes(data[4 : 4 + size], "little")


@pytest.fixture
def watcher(result: Result, rig: Rig) -> Watcher:
    described = load_instrument(rig.file("instrument"))
    seen = Watcher(tuple(axis.node for axis in described.axes))
    seen.watch(result.session / "candump-sim.1.out")
    return seen


@pytest.mark.scenario("step_scan")
def test_every_node_was_seen_operational(watcher: Watcher) -> None:
    assert set(watcher.states) == set(watcher.nodes)
    for states in watcher.states.values():
        assert OPERATIONAL in states


@pytest.mark.scenario("step_scan")
def test_configured_values_went_over_the_bus(watcher: Watcher, rig: Rig) -> None:
    described = load_instrument(rig.file("instrument"))
    for axis in described.axes:
        assert watcher.written[axis.node, HEARTBEAT_MS, 0] == described.cycle.drive_heartbeat_ms
        wanted = abs(axis.following_error_deg * axis.counts_per_deg)
        assert watcher.written[axis.node, FOLLOWING_ERROR, 0] == pytest.approx(wanted, abs=1.0)


@pytest.mark.scenario("step_scan")
def test_pose_records_hold_what_the_drives_sent(watcher: Watcher, result: Result) -> None:
    poses = raw_log(result.raw()).poses
    recorded, number = poses["position_counts"], poses["sync_number"].astype(np.int64)
    sent = np.array([[value if value is not None else 0 for value in row] for row in watcher.positions])
    moving = np.flatnonzero(np.abs(np.diff(recorded[:, 2])) > 50)
    assert len(moving) > 100
    begin = int(moving[0])
    stretch = recorded[begin : begin + 5]
    places = [i for i in np.flatnonzero(sent[:, 2] == stretch[0, 2]) if np.array_equal(sent[i : i + 5], stretch)]
    assert places, "the drives never sent what the raw log holds"
    # The watcher counts SYNCs as the firmware does: one that the firmware had no pose for is passed over.
    at = places[0] + number - number[begin]
    there = (at >= 0) & (at < len(sent))
    valid = (poses["valid"][:, None] >> np.arange(len(watcher.nodes))) & 1 != 0
    valid &= there[:, None]
    assert valid.mean() > LEAST_VALID
    assert np.array_equal(sent[at[there]][valid[there]], recorded[there][valid[there]])
