"""test_drives_store.py: the instrument file's settings written, stored, and still there after a reset."""

from pathlib import Path

import pytest
from virtual_drives import VirtualBench, VirtualDrive, instrument_text

from gonio.cli import main

# Of node 3 (arm azimuth): 400000 counts per turn; 200 deg, 200 deg/s2, 0.5 deg, 30 * 1.05 deg/s ...
COUNTS_PER_DEG = 400000 / 360
EXPECTED = {
    "0x6085": round(200 * COUNTS_PER_DEG),
    "0x607D:01": -round(200 * COUNTS_PER_DEG),
    "0x607D:02": round(200 * COUNTS_PER_DEG),
    "0x6065": round(0.5 * COUNTS_PER_DEG),
    "0x6066": 20,
    "0x6098": 1,
    "0x6099:01": round(10 * COUNTS_PER_DEG),
    "0x6099:02": round(1 * COUNTS_PER_DEG),
    "0x607C": -round(200 * COUNTS_PER_DEG),
    "0x609A": round(60 * COUNTS_PER_DEG),
    "0x6081": round(1.05 * 30 * COUNTS_PER_DEG),
    "0x6083": round(1.05 * 60 * COUNTS_PER_DEG),
    "0x6084": round(1.05 * 60 * COUNTS_PER_DEG),
    "0x60C2:01": 2,
    "0x60C2:02": -3,
    "0x608F:01": 400000,
    "0x608F:02": 1,
    "0x1017": 10,
}


@pytest.fixture
def drive(bench: VirtualBench) -> VirtualDrive:
    made = VirtualDrive(3, "full")
    bench.add(made)
    return made


def changed(told) -> dict[str, int]:
    return {s["object"]: s["new"] for s in told["drives"][0]["settings"] if s["old"] != s["new"]}


def writes(drive: VirtualDrive) -> set[tuple[int, int]]:
    return {(index, subindex) for index, subindex, _ in drive.writes}


def test_a_dry_run_shows_and_writes_nothing(drive, run) -> None:
    status, told = run("store", "--node", "3", "--dry-run")
    assert status == 0
    assert {s["object"]: s["new"] for s in told["drives"][0]["settings"]} == EXPECTED
    assert told["drives"][0]["stored"] is False
    assert "0x6065" in changed(told)
    assert not drive.writes


def test_stored_settings_outlast_a_reset(drive, run) -> None:
    wanted = changed(run("store", "--node", "3", "--dry-run")[1])
    status, told = run("store", "--node", "3", "--yes")
    assert status == 0
    assert told["drives"][0]["stored"] is True
    assert changed(told) == wanted
    names = {f"0x{i:04X}" + (f":{s:02X}" if s else "") for i, s in writes(drive)}
    assert names == set(wanted) | {"0x1010:01"}  # only what differs
    for name, value in EXPECTED.items():
        index, _, subindex = name.partition(":")
        size = len(drive.get_data(int(index, 16), int(subindex or "0", 16)))
        held = drive.get_data(int(index, 16), int(subindex or "0", 16))
        assert held == value.to_bytes(size, "little", signed=value < 0), name
    assert changed(run("store", "--node", "3", "--dry-run")[1]) == {}


def test_a_drive_that_forgets_is_found_out(drive, run) -> None:
    drive.keeps_saved = False
    assert run("store", "--node", "3", "--yes")[0] == 3
    assert "after its reset holds" in run.error()


def test_a_drive_that_limits_a_value_gets_its_own_back(drive, run) -> None:
    drive.clamp[0x6085, 0] = (1000).to_bytes(4, "little")
    drive.data_store[0x6085] = {0: (500).to_bytes(4, "little")}
    drive.data_store[0x6066] = {0: b"\x63\0"}
    assert run("store", "--node", "3", "--yes")[0] == 3
    assert "0x6085" in run.error()
    assert "nothing was stored" in run.error()
    assert drive.number(0x6066, 0) == 0x63
    assert (0x1010, 1) not in writes(drive)


def test_a_failing_save_puts_everything_back(drive, run) -> None:
    drive.data_store[0x6066] = {0: b"\x63\0"}
    drive.write_aborts[0x1010, 1] = 0x06060000
    assert run("store", "--node", "3", "--yes")[0] == 3
    assert "0x1010:01" in run.error()
    assert drive.number(0x6066, 0) == 0x63


def test_a_read_only_setting_must_agree(drive, run) -> None:
    drive.object_dictionary[0x608F][1].default = 4000
    assert run("store", "--node", "3", "--yes")[0] == 3
    assert "0x608F:01" in run.error()
    assert (0x1010, 1) not in writes(drive)


def test_without_0x1010_nothing_is_written(bench: VirtualBench, run) -> None:
    drive = VirtualDrive(3, "full", stores=False)
    bench.add(drive)
    status, told = run("store", "--node", "3", "--yes")
    assert status == 1
    assert "does not store on command" in told["findings"][0]["sentence"]
    assert not drive.writes


def test_torque_is_refused(drive, run) -> None:
    drive.statusword = 0x0027
    assert run("store", "--node", "3", "--yes")[0] == 2
    assert not drive.writes


def test_the_question_and_its_no(
    bench: VirtualBench, drive, instrument: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("typer.confirm", lambda _text: False)
    words = ["drives", "store", *bench.arguments, "--instrument", str(instrument), "--node", "3"]
    assert main.run(words) == 0
    text = capsys.readouterr().out
    assert "0x6065 following error window (following_error_deg):" in text
    assert f"-> {EXPECTED['0x6065']}" in text
    assert "nothing was written" in text
    assert not drive.writes


def test_json_does_not_ask(run) -> None:
    assert run("store", "--node", "3")[0] == 2
    assert "--yes or --dry-run" in run.error()


def test_the_sign_of_an_axis_turns_its_limits(drive, instrument: Path, run) -> None:
    text = instrument_text().replace("counts_per_deg = [10000, 9]", "counts_per_deg = [-10000, 9]")
    instrument.write_text(text.replace("min_deg = -200.0", "min_deg = -100.0"), encoding="utf-8")
    settings = run("store", "--node", "3", "--dry-run")[1]["drives"][0]["settings"]
    new = {s["object"]: s["new"] for s in settings}
    assert (new["0x607D:01"], new["0x607D:02"]) == (-round(200 * COUNTS_PER_DEG), round(100 * COUNTS_PER_DEG))
    assert not drive.writes
