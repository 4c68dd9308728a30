"""test_drives_load.py: the PDO schedule in simulated time: counts, jitter, causes; no real second passes."""

import can
import pytest
from scripted_bus import ECHO_US, NODES, PERIOD_US, TPDO_US, WINDOW_US, ScriptedBus, error_frame, frame

from gonio.drives.bus import FirmwareInCharge
from gonio.drives.causes import bus_load, frame_bits, judge, likely_causes, percentiles
from gonio.drives.findings import any_wrong
from gonio.drives.load import Load, LoadRecord
from gonio.drives.pdo_setup import ArmedDrive

MINUTE_CYCLES = 60_000_000 // PERIOD_US
FIRST = 1  # the load counts from the cycle after the one in which every drive answered


def run(bus: ScriptedBus, seconds: float = 1.0) -> LoadRecord:
    drives = [ArmedDrive(node, b"\0\0" + (1000 * node).to_bytes(4, "little"), 6) for node in NODES]
    return Load(bus, bus, drives, PERIOD_US, WINDOW_US).run(seconds, start_s=2.0)


def told(record: LoadRecord, load: float | None = None) -> str:
    return "\n".join(finding.line for finding in judge(record, load))


def test_a_minute_on_a_good_bus() -> None:
    bus = ScriptedBus()
    record = run(bus, 60.0)
    assert record.syncs == MINUTE_CYCLES == 30000
    assert bus.time_s == pytest.approx(60.0 + PERIOD_US * 1e-6 * FIRST)
    for node in record.nodes.values():
        assert (node.received, node.lost, node.late, node.duplicate) == (30000, 0, 0, 0)
        assert percentiles(node.delays_us).max_us == pytest.approx(TPDO_US[node.node] - ECHO_US, abs=0.5)
    assert percentiles(record.echo_errors_us).max_us < 0.5  # double precision of a time since 1970
    assert judge(record, 0.3) == []
    assert record.bus_state == "active"


def test_motors_stay_off_and_counters_run_from_1_to_240() -> None:
    bus = ScriptedBus()
    run(bus)
    rpdos = [m for m in bus.sent if 0x200 < m.arbitration_id < 0x280]
    assert {(m.arbitration_id, bytes(m.data)) for m in rpdos} == {
        (0x200 + node, b"\0\0" + (1000 * node).to_bytes(4, "little")) for node in NODES
    }
    counters = [m.data[0] for m in bus.sent if m.arbitration_id == 0x080][FIRST:]
    assert counters == [k % 240 + 1 for k in range(500)]
    assert {m.arbitration_id for m in bus.sent} == {0x080, 0x201, 0x202, 0x203, 0x204}


def test_lost_late_and_duplicate_are_counted_for_their_node() -> None:
    bus = ScriptedBus()

    def reply(cycle: int, node: int) -> list[float]:
        n = cycle - FIRST
        if node == 2 and n in (10, 20, 30):
            return []
        if node == 3 and n in (40, 50):
            return [ECHO_US + WINDOW_US + 50.0]
        if node == 4 and n == 60:
            return [500.0, 700.0]
        return [TPDO_US[node]]

    bus.reply = reply
    record = run(bus)
    counts = {node.node: (node.received, node.lost, node.late, node.duplicate) for node in record.nodes.values()}
    assert counts == {1: (500, 0, 0, 0), 2: (497, 3, 0, 0), 3: (500, 0, 2, 0), 4: (500, 0, 0, 1)}
    text = told(record)
    assert any_wrong(judge(record, None))
    assert "node 2 alone loses" in text
    assert "two drives with one node id" in text
    assert "answers slowly" in text


def test_drives_that_start_slowly_are_waited_for() -> None:
    bus = ScriptedBus()
    bus.reply = lambda cycle, node: [TPDO_US[node]] if node != 4 or cycle >= 700 else []  # 1.4 s of the 2 s
    record = run(bus)
    assert record.nodes[4].lost == 0
    assert record.syncs == 500


def test_a_drive_that_never_answers_the_sync() -> None:
    bus = ScriptedBus()
    bus.reply = lambda _cycle, node: [TPDO_US[node]] if node != 4 else []
    record = run(bus)
    assert record.nodes[4].lost == 500
    assert bus.time_s == pytest.approx(2.0 + 1.0)
    assert "node 4 alone" in told(record)


def test_jitter_is_the_echos_and_the_hosts_alone_is_no_fault() -> None:
    bus = ScriptedBus()
    bus.echo = lambda cycle: ECHO_US + (150.0 if cycle % 10 == 0 else 0.0)
    record = run(bus)
    spread = percentiles(record.echo_errors_us)
    assert spread.max_us == pytest.approx(150.0, abs=1.0)
    assert spread.p50_us == pytest.approx(0.0, abs=1.0)
    assert spread.p99_us == pytest.approx(150.0, abs=1.0)
    assert judge(record, None) == []
    bus = ScriptedBus()
    bus.echo = lambda cycle: ECHO_US + (500.0 if cycle % 10 == 0 else 0.0)
    bus.reply = lambda _cycle, node: [900.0 + node]
    record = run(bus)
    assert not any_wrong(judge(record, None))
    assert "this host is uneven" in told(record)


def test_an_interface_without_echo_is_of_no_use_to_goniod() -> None:
    bus = ScriptedBus()
    bus.echo = lambda _cycle: None
    record = run(bus)
    assert record.echo_errors_us == []
    assert record.nodes[1].lost == record.nodes[1].late == 0
    assert "echoes nothing" in told(record)


def test_lost_echoes_are_counted_and_the_next_interval_is_two_periods() -> None:
    bus = ScriptedBus()
    bus.echo = lambda cycle: None if cycle - FIRST == 100 else ECHO_US
    record = run(bus)
    assert record.echoes_lost == 1
    assert percentiles(record.echo_errors_us).max_us < 1.0
    assert "1 SYNCs did not come back" in told(record)


def test_a_second_sync_producer_is_found() -> None:
    bus = ScriptedBus()
    bus.extra = lambda cycle: [(1000.0, frame(0x080, b""))] if cycle - FIRST in (5, 6) else []
    record = run(bus)
    assert record.foreign_syncs == 2
    assert "another SYNC producer" in told(record)


def test_a_host_that_sleeps_skips_cycles_and_says_so() -> None:
    bus = ScriptedBus()

    def extra(cycle: int) -> list[tuple[float, can.Message]]:
        if cycle - FIRST == 100:
            bus.time_s += 5.5 * PERIOD_US * 1e-6
        return []

    bus.extra = extra
    record = run(bus)
    assert record.skipped == 4  # 5.5 periods: the fifth is sent, late
    assert record.syncs == 496
    assert sum(node.lost for node in record.nodes.values()) == 0
    assert "this host is uneven" in told(record)


@pytest.mark.parametrize(
    ("when", "what", "words"),
    [
        (7, frame(0x082, b"\x20\x32\x04\0\0\0\0\0"), ["EMCY 0x3220, 1 times", "power:"]),
        (7, frame(0x702, b"\0"), ["node 2: started anew 1 times", "power:"]),
        (7, frame(0x082, b"\x40\x82\x10\0\0\0\0\0"), ["EMCY 0x8240", "SYNC with counter"]),
        (7, frame(0x082, b"\x30\x81\x10\0\0\0\0\0"), ["EMCY 0x8130", "goniod is off"]),
        (7, error_frame(0x008 | 0x080, d2=0x04), ["1 error frames", "60 ohm"]),
        (7, error_frame(0x004 | 0x200, d1=0x20, d6=130, d7=5), ["error passive", "130 (send) and 5", "60 ohm"]),
        (7, error_frame(0x004, d1=0x01), ["CAN interface: its queues overflow"]),
    ],
)
def test_what_the_bus_says_and_the_likely_cause(when: int, what: can.Message, words: list[str]) -> None:
    bus = ScriptedBus()
    bus.extra = lambda cycle: [(200.0, what)] if cycle - FIRST == when else []
    text = told(run(bus))
    for word in words:
        assert word in text


def test_an_emergency_reset_is_none() -> None:
    bus = ScriptedBus()
    bus.extra = lambda cycle: [(200.0, frame(0x081, bytes(8)))] if cycle == 5 else []
    assert judge(run(bus), None) == []


def test_cycles_lost_by_all_point_to_what_all_share() -> None:
    bus = ScriptedBus()
    bus.reply = lambda cycle, node: [] if cycle - FIRST in (50, 51) else [TPDO_US[node]]
    record = run(bus)
    assert record.lost_together == 2
    assert "what all drives share: 2 cycles" in told(record)


def test_frames_in_bunches_accuse_the_interface_and_nobody_else() -> None:
    bus = ScriptedBus()
    bus.reply = lambda cycle, node: [TPDO_US[node] + k for k in range(3)] if cycle % 3 == 0 else []
    causes = likely_causes(run(bus), None)
    assert len(causes) == 1
    assert "delivers in bunches" in causes[0]


def test_late_on_a_full_bus_is_the_load() -> None:
    bus = ScriptedBus()
    bus.reply = lambda cycle, node: [ECHO_US + WINDOW_US + 10.0] if cycle > 50 and node == 4 else [TPDO_US[node]]
    record = run(bus)
    assert "bus load: up to 85 %" in told(record, 0.85)
    assert "bus with room" in told(record, 0.30)


def dead(bus: ScriptedBus) -> ScriptedBus:
    bus.reply = lambda _cycle, _node: []
    bus.echo = lambda _cycle: None
    return bus


def test_a_dead_bus_has_one_cause() -> None:
    silent = dead(ScriptedBus())
    silent.extra = lambda _cycle: [(200.0, error_frame(0x020 | 0x004, d1=0x20))]
    assert [cause.split(":")[0] for cause in likely_causes(run(silent, 0.1), None)] == ["power, cable or bit rate"]
    garbled = dead(ScriptedBus())
    garbled.extra = lambda _cycle: [(200.0, error_frame(0x008, d2=0x02))]
    assert [cause.split(":")[0] for cause in likely_causes(run(garbled, 0.1), None)] == ["bit rate"]
    refused = dead(ScriptedBus())
    refused.refuses_from = 3
    assert [cause.split(":")[0] for cause in likely_causes(run(refused, 0.1), None)] == ["power, cable or bit rate"]
    deaf = ScriptedBus()
    deaf.reply = lambda _cycle, _node: []
    assert "answer SDO and not the SYNC" in likely_causes(run(deaf, 0.1), None)[0]


def test_a_firmware_that_appears_ends_the_load() -> None:
    bus = ScriptedBus()
    bus.extra = lambda cycle: [(200.0, frame(0x77F, b"\0"))] if cycle == 100 else []
    with pytest.raises(FirmwareInCharge, match="goniod is in charge"):
        run(bus)
    assert bus.cycle == 100


def test_frame_lengths_and_load_by_hand() -> None:
    # CiA 301 frames at 1 Mbit/s: 8 data bytes are 111 bits and at most 24 stuffed ones (135 with the space after it).
    assert frame_bits(8) == 135
    assert frame_bits(0) == 55
    # 500 Hz: SYNC with counter, 4 RPDO and 4 TPDO of 6 bytes: 65 + 8 * 115 bits in 2000.
    assert bus_load(2000, [1] + 8 * [6], 1_000_000) == pytest.approx((65 + 8 * 115) / 2000)
    assert bus_load(2000, [1] + 8 * [6], 250_000) > 1.0


def test_percentiles_are_ranks_of_sizes() -> None:
    values = [float(-k if k % 2 else k) for k in range(1, 101)]
    found = percentiles(values)
    assert (found.p50_us, found.p99_us, found.max_us) == (50.0, 99.0, 100.0)
    assert percentiles([]) is None
