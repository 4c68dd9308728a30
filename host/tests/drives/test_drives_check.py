"""test_drives_check.py: a drive and its EDS against the table of objects that the firmware uses."""

from pathlib import Path

import pytest
from virtual_drives import VirtualBench, VirtualDrive, eds, instrument_text

FULL = ("--eds", str(eds("full")))
# Objects that the firmware can do without and that the twin's drives may not have.
UNTOLD = {"0x60A9"} - {f"0x{index:04X}" for index in VirtualDrive(1, "full").object_dictionary}


def objects(told, grade: str, node: int | None = None) -> set[str]:
    return {
        f["object"]
        for f in told["findings"]
        if f["grade"] == grade and (node is None or f["where"].startswith(f"node {node} "))
    } - UNTOLD


def sentences(told, name: str) -> str:
    return "\n".join(f["sentence"] for f in told["findings"] if f["object"] == name)


def only(bench: VirtualBench, drive: VirtualDrive) -> VirtualDrive:
    bench.add(drive)
    return drive


def test_full_drives_have_all(drives, run) -> None:
    status, told = run("check", *FULL)
    assert status == 0
    assert objects(told, "wrong") == objects(told, "fallback") == set()
    assert [drive["node"] for drive in told["drives"]] == [1, 2, 3, 4]
    assert told["drives"][0]["objects"]["0x608F:01"] == 400000
    assert "0x60FE:01" in told["drives"][3]["objects"]  # the axis with the brake, and no other
    assert "0x60FE:01" not in told["drives"][0]["objects"]
    assert not any(drive.writes for drive in drives)
    assert "not proven" in sentences(told, "0x60A9")


def test_basic_drive_has_fallbacks(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(2, "basic", stores=False))
    status, told = run("check", "--node", "2", "--eds", f"2={eds('basic')}")
    assert status == 0
    assert objects(told, "fallback") == {"0x1029:01", "0x6007", "0x60C2:01", "0x60C2:02"}
    assert "cannot store" in sentences(told, "0x1010:01")


def test_fixed_map_is_usable(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(3, "fixed"))
    status, told = run("check", "--node", "3", "--eds", str(eds("fixed")))
    assert status == 0
    assert {"0x1600", "0x1A00"} <= objects(told, "fallback")


def test_fixed_map_without_target_is_wrong(bench: VirtualBench, run) -> None:
    drive = only(bench, VirtualDrive(3, "fixed"))
    drive.object_dictionary[0x1600][2].default = 0x60FF0020  # target velocity
    status, told = run("check", "--node", "3", "--eds", str(eds("fixed")))
    assert status == 1
    assert objects(told, "wrong") == {"0x1600"}
    assert "lacks 0x607A" in sentences(told, "0x1600")


@pytest.mark.usefixtures("drives")
def test_without_sheet_access_and_range_are_open(run) -> None:
    status, told = run("check")
    assert status == 0
    assert [f["where"] for f in told["findings"] if "no EDS" in f["sentence"]] == [
        "node 1 (sample azimuth)",
        "node 2 (sample roll)",
        "node 3 (arm azimuth)",
        "node 4 (arm elevation)",
    ]


@pytest.mark.parametrize(
    ("without", "grade", "name"),
    [
        (0x605A, "wrong", "0x605A"),
        (0x6085, "wrong", "0x6085"),
        ((0x1016, 1), "wrong", "0x1016:01"),
        ((0x1400, 5), "fallback", "0x1400:05"),
        (0x6007, "fallback", "0x6007"),
        ((0x1018, 4), "fallback", "0x1018:04"),
        (0x6064, "wrong", "0x6064"),
        ((0x607D, 2), "wrong", "0x607D:02"),
    ],
)
def test_a_missing_object_is_named_with_what_follows(bench: VirtualBench, run, without, grade: str, name: str) -> None:
    only(bench, VirtualDrive(1, "full", without=[without]))
    status, told = run("check", "--node", "1", *FULL)
    assert status == (1 if grade == "wrong" else 0)
    assert objects(told, grade) == {name}


def test_no_deadline_says_what_is_left(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(1, "full", without=[(0x1400, 5)]))
    told = run("check", "--node", "1", *FULL)[1]
    assert "lowers this axis's speed limit" in sentences(told, "0x1400:05")
    assert "what is left is 0x1016:01 and 0x6007" in sentences(told, "0x1400:05")


def test_brake_outputs_matter_to_the_axis_with_the_brake(bench: VirtualBench, run) -> None:
    bench.add(VirtualDrive(3, "full", without=[0x60FE]), VirtualDrive(4, "full", without=[0x60FE]))
    told = run("check", "--node", "3", "--node", "4")[1]
    assert objects(told, "fallback", node=3) == set()
    assert objects(told, "fallback", node=4) == {"0x60FE:01", "0x60FE:02"}


@pytest.mark.parametrize(
    ("index", "subindex", "value", "name", "words"),
    [
        (0x608F, 1, 4096, "0x608F:01", "counts_per_turn = 400000"),
        (0x608F, 2, 10, "0x608F:02", "10 motor revolutions"),
        (0x6092, 1, 40000, "0x6092", "makes 40000 units of a shaft revolution that has 400000"),
        (0x6092, 2, 3, "0x6092", "makes 133333 units"),
        (0x6091, 1, 50, "0x6092", "that has 20000000 encoder counts"),
        (0x1000, 0, 0x00020191, "0x1000", "no CiA 402 drive"),
    ],
)
def test_wrong_values_are_found(bench, run, index: int, subindex: int, value: int, name: str, words: str) -> None:
    entry = only(bench, VirtualDrive(1, "full")).object_dictionary[index]
    (entry[subindex] if subindex else entry).default = value
    status, told = run("check", "--node", "1", *FULL)
    assert status == 1
    assert objects(told, "wrong") == {name}
    assert words in sentences(told, name)


def test_gear_speaks_where_there_is_no_feed(bench: VirtualBench, run) -> None:
    drive = only(bench, VirtualDrive(1, "full", without=[0x6092]))
    drive.object_dictionary[0x6091][1].default = 100
    status, told = run("check", "--node", "1")
    assert status == 1
    assert "40000000 counts per turn" in sentences(told, "0x6091")


def test_a_gear_outside_the_drive_is_left_to_a_person(bench: VirtualBench, instrument: Path, run) -> None:
    text = instrument_text().replace("counts_per_deg = [10000, 9]", "counts_per_deg = [-1000000, 9]")
    instrument.write_text(text, encoding="utf-8")
    only(bench, VirtualDrive(1, "full"))
    status, told = run("check", "--node", "1")
    assert status == 0
    assert "100 turns of the shaft turn the axis once" in sentences(told, "0x6091")


def test_another_velocity_unit_is_wrong(bench: VirtualBench, run) -> None:
    drive = VirtualDrive(1, "full")
    drive.define(0x60A9, 0x00B44700)  # revolutions per minute
    only(bench, drive)
    status, told = run("check", "--node", "1")
    assert status == 1
    assert "0x00B44700 is not counts per second" in sentences(told, "0x60A9")


def test_a_read_only_period_must_be_ours(bench: VirtualBench, instrument: Path, run) -> None:
    text = instrument_text().replace("sync_period_us = 2000", "sync_period_us = 4000")
    instrument.write_text(text, encoding="utf-8")
    only(bench, VirtualDrive(2, "basic"))
    status, told = run("check", "--node", "2", "--eds", str(eds("basic")))
    assert status == 1
    assert objects(told, "wrong") == {"0x60C2:01"}
    assert "2 * 10^-3 s" in sentences(told, "0x60C2:01")


@pytest.mark.parametrize(
    ("old", "new", "name", "words"),
    [
        (
            "[6065]\nParameterName=Following error window\nObjectType=0x7\nDataType=0x0007",
            "DataType=0x0006",
            "0x6065",
            "data type 0x0006",
        ),
        ("AccessType=rw", "AccessType=ro", "0x605A", "read only"),
        ("PDOMapping=1", "PDOMapping=0", "0x6064", "cannot be mapped"),
    ],
)
def test_the_sheet_alone_can_be_wrong(bench, tmp_path: Path, run, old: str, new: str, name: str, words: str) -> None:
    head = f"[{name[2:]}]"
    before, section = eds("full").read_text(encoding="utf-8").split(head)
    own, rest = section.split("\n[", 1)
    key = old.rsplit("\n", 1)[-1]
    assert key in own
    changed = tmp_path / "changed.eds"
    changed.write_text(before + head + own.replace(key, new) + "\n[" + rest, encoding="utf-8")
    only(bench, VirtualDrive(1, "full"))
    status, told = run("check", "--node", "1", "--eds", str(changed))
    assert status == 1
    assert objects(told, "wrong") == {name}
    assert words in sentences(told, name)


def test_the_range_of_the_sheet_holds_for_our_values(bench, tmp_path: Path, run) -> None:
    text = eds("full").read_text(encoding="utf-8")
    before, after = text.split("[6085]")
    assert "HighLimit=0xFFFFFFFF" in after.split("\n[")[0]
    changed = tmp_path / "changed.eds"
    changed.write_text(before + "[6085]" + after.replace("HighLimit=0xFFFFFFFF", "HighLimit=1000", 1))
    only(bench, VirtualDrive(1, "full"))
    status, told = run("check", "--node", "1", "--eds", str(changed))
    assert status == 1
    assert "1 to 1000: change quick_stop_deg_per_s2" in sentences(told, "0x6085")


def test_a_sheet_of_another_product_is_noticed(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(1, "full"))
    status, told = run("check", "--node", "1", "--eds", str(eds("basic")))
    assert status == 1
    assert "0x1018" in objects(told, "wrong")
    assert "gonio_basic.eds" in sentences(told, "0x1018")


def test_other_aborts_are_told_with_the_standards_words(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(1, "full")).aborts[0x6065, 0] = 0x06060000
    status, told = run("check", "--node", "1", *FULL)
    assert status == 1
    assert "hardware error (0x06060000)" in sentences(told, "0x6065")


def test_a_value_of_another_length_is_told(bench: VirtualBench, run) -> None:
    only(bench, VirtualDrive(1, "full")).object_dictionary[0x6065].data_type = 0x0006
    status, told = run("check", "--node", "1")
    assert status == 1
    assert "2 bytes, UNSIGNED32 has 4" in sentences(told, "0x6065")


def test_a_silent_node_does_not_hide_the_others(bench: VirtualBench, instrument: Path, run) -> None:
    instrument.write_text(instrument_text().replace("sdo_timeout_ms = 5000", "sdo_timeout_ms = 500"), encoding="utf-8")
    bench.add(*(VirtualDrive(node, "full") for node in (1, 2, 4)))
    status, told = run("check", *FULL)
    assert status == 1
    assert [bool(drive["objects"]) for drive in told["drives"]] == [True, True, False, True]
    assert "no answer within 500 ms" in sentences(told, "0x1000")
    status, told = run("check", "--node", "3")
    assert (status, told) == (3, None)
    assert "no answer from node 3" in run.error()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--node", "77"], "--node 77"),
        (["--eds", "none.eds"], "none.eds"),
        (["--eds", str(Path(__file__))], "not an EDS"),
        (["--eds", "9=none.eds"], "node 9"),
        (["--load", "0"], "--load"),
    ],
)
def test_wrong_use_names_the_option(run, arguments: list[str], words: str) -> None:
    assert run("check", *arguments)[0] == 2
    assert words in run.error()
    assert run.error().count("\n") == 1
