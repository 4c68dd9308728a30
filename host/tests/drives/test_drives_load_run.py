"""test_drives_load_run.py: `check --load` on the virtual bus: PDOs are taken over, and everything is put back."""

from pathlib import Path

import pytest
from virtual_drives import VirtualBench, VirtualDrive, eds, instrument_text

CYCLES = 20


@pytest.fixture(autouse=True)
def _slow(instrument: Path) -> None:
    """20 ms and all of it as window: this is about what is set and restored; test_drives_load judges times."""
    text = instrument_text().replace("sync_period_us = 2000", "sync_period_us = 20000")
    instrument.write_text(text.replace("sync_window_us = 1500", "sync_window_us = 20000"), encoding="utf-8")


LOAD = ("--load", str(CYCLES * 0.02))


def states(drives: list[VirtualDrive]) -> list[str]:
    return [drive.nmt.state for drive in drives]


def test_the_schedule_runs_and_leaves_the_drives_as_they_were(drives, run) -> None:
    drives[1].data_store[0x1400] = {5: b"\x09\0", 2: b"\x03"}
    drives[2].data_store[0x1A00] = {0: b"\2", 1: b"\x10\0\x41\x60", 2: b"\x08\0\x61\x60"}
    before = [drive.all_values() for drive in drives]
    told = run("check", "--bitrate", "1000000", *LOAD)[1]
    load = told["load"]
    assert load["syncs"] + load["cycles_skipped_by_host"] == CYCLES
    assert load["worst_bus_load"] == pytest.approx((65 + 8 * 115) / 20000, abs=1e-3)
    assert load["echo_jitter_us"] is not None
    assert [node["node"] for node in load["nodes"]] == [1, 2, 3, 4]
    assert all(node["received"] > 0 for node in load["nodes"])
    for drive, values in zip(drives, before, strict=True):
        assert drive.all_values() == values
        assert {bytes(rpdo) for rpdo in drive.rpdos} == {b"\0\0" + drive.position.to_bytes(4, "little")}
    assert states(drives) == ["PRE-OPERATIONAL"] * 4


def test_the_cycles_own_pdos_are_set_for_the_time(drives, run) -> None:
    seen: list[tuple[int, ...]] = []
    drives[0].network.subscribe(
        0x080, lambda *_: seen.append(tuple(drives[0].number(*o) for o in ((0x1800, 2), (0x1A00, 2), (0x1400, 5))))
    )
    drives[0].data_store[0x1400] = {5: b"\x09\0"}
    run("check", *LOAD)
    assert set(seen) == {(1, 0x60640020, 0)}  # at every SYNC, the position, no deadline that this host would miss


def test_a_fixed_map_is_used_as_it_is(bench: VirtualBench, run) -> None:
    drive = VirtualDrive(3, "fixed")
    drive.data_store[0x6060] = {0: b"\x06"}
    bench.add(drive)
    told = run("check", "--node", "3", "--eds", str(eds("fixed")), *LOAD)[1]
    assert told["load"]["nodes"][0]["received"] > 0
    assert set(drive.rpdos) == {b"\0\0" + (3000).to_bytes(4, "little") + b"\x06"}


@pytest.mark.parametrize(("which", "statusword"), [(0, 0x0027), (3, 0x0027), (3, 0x0007), (3, 0x000F)])
def test_a_motor_with_torque_is_never_let_go(drives, run, which: int, statusword: int) -> None:
    drives[which].statusword = statusword
    before = [drive.all_values() for drive in drives]
    status, told = run("check", *LOAD)
    assert (status, told) == (2, None)
    assert "motor has torque" in run.error()
    assert [drive.all_values() for drive in drives] == before
    assert not any(drive.rpdos for drive in drives)
    assert not any(drive.writes for drive in drives)


def test_a_drive_that_refuses_its_pdos_is_put_back(drives, run) -> None:
    drives[1].write_aborts[0x1A00, 2] = 0x06040041  # cannot be mapped
    before = [drive.all_values() for drive in drives]
    status, _ = run("check", *LOAD)
    assert status == 3
    assert "0x1A00:02" in run.error()
    assert [drives[0].all_values(), *(drive.all_values() for drive in drives[2:])] == [before[0], *before[2:]]
    assert not any(drive.rpdos for drive in drives)


def test_a_firmware_that_comes_up_is_left_alone(bench: VirtualBench, drives, run) -> None:
    """Its heartbeat at the fifth SYNC: from then on nothing is sent, not even to restore; its boot resets drives."""
    syncs: list[int] = []

    def on_sync(_cob_id: int, data: bytearray, _time: float) -> None:
        syncs.append(data[0])
        if len(syncs) == 5:
            other.send_message(0x77F, b"\0")

    other = bench.network()
    other.subscribe(0x080, on_sync)
    status, told = run("check", *LOAD)
    assert (status, told) == (2, None)
    assert "goniod is in charge" in run.error()
    ids = [frame.arbitration_id for frame in bench.frames()]
    after = ids[ids.index(0x77F) :]
    assert not {cob_id for cob_id in after if cob_id == 0 or 0x600 <= cob_id < 0x680}
    assert drives[0].nmt.state == "OPERATIONAL"


def test_the_load_needs_every_drive(bench: VirtualBench, instrument: Path, run) -> None:
    text = instrument.read_text(encoding="utf-8").replace("sdo_timeout_ms = 5000", "sdo_timeout_ms = 400")
    instrument.write_text(text, encoding="utf-8")
    bench.add(*(VirtualDrive(node, "full") for node in (1, 2, 3)))
    assert run("check", *LOAD)[0] == 3
    assert "node 4" in run.error()
    assert not any(frame.arbitration_id == 0x080 for frame in bench.frames())
