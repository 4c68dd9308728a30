"""test_watcher.py: python-canopen, independent of our code, reads what candump saw and agrees with the firmware."""

from collections import Counter
from dataclasses import dataclass, field
from functools import cache
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
# candump hears SYNC and TPDO on two processors and now and then writes down a neighbouring pair in the other order.
LEAST_AGREEMENT = 0.99
LEAST_MOVING = 100
UNSEEN = -(2**31)
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


@cache
def watched(log: Path, nodes: tuple[int, ...]) -> Watcher:
    """All of a log, read once for all tests."""
    seen = Watcher(nodes)
    seen.watch(log)
    return seen


@pytest.fixture
def watcher(result: Result, rig: Rig) -> Watcher:
    described = load_instrument(rig.file("instrument"))
    return watched(result.session / "candump-sim.1.out", tuple(axis.node for axis in described.axes))


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
    sent = np.array([[UNSEEN if value is None else value for value in row] for row in watcher.positions])
    valid = (poses["valid"][:, None] >> np.arange(len(watcher.nodes))) & 1 != 0
    assert valid.mean() > LEAST_VALID
    # Both count SYNCs: the rows that both have tell where the firmware's numbers stand in the watcher's count.
    moving = np.flatnonzero(np.any(np.diff(recorded, axis=0) != 0, axis=1) & np.all(valid[1:], axis=1)) + 1
    assert len(moving) > LEAST_MOVING
    place = {tuple(row): index for index, row in enumerate(sent)}
    offsets = Counter(place[row] - number[i] for i in moving if (row := tuple(recorded[i])) in place)
    assert offsets, "the drives never sent what the raw log holds"
    offset, agreed = offsets.most_common(1)[0]
    assert agreed > LEAST_VALID * len(moving)  # some places are passed twice
    seen = sent[number + offset]
    compared = valid & (seen != UNSEEN)
    equal = seen[compared] == recorded[compared]
    assert equal.mean() > LEAST_AGREEMENT
