"""test_drives_list.py: finding nodes, and the refusal beside a firmware that is in charge."""

from pathlib import Path

import canopen
import pytest
from virtual_drives import VirtualBench, VirtualDrive, eds, instrument_text

SHORT_TIMEOUT = 300  # ms: ids that nobody has are waited for once


@pytest.fixture(autouse=True)
def _short(instrument: Path) -> None:
    text = instrument_text().replace("sdo_timeout_ms = 5000", f"sdo_timeout_ms = {SHORT_TIMEOUT}")
    instrument.write_text(text, encoding="utf-8")


def test_every_drive_is_found_with_what_its_sheet_says(bench: VirtualBench, run) -> None:
    personalities = {1: "full", 2: "basic", 3: "fixed", 126: "full"}
    bench.add(*(VirtualDrive(node, name) for node, name in personalities.items()))
    status, told = run("list")
    assert status == 0
    assert [node["node"] for node in told["nodes"]] == list(personalities)
    for node in told["nodes"]:
        od = canopen.import_od(str(eds(personalities[node["node"]])), node["node"])
        assert node["device_type"] == 0x00040192
        assert node["identity"]["vendor"] == od.device_information.vendor_number
        assert node["identity"]["product"] == od.device_information.product_number
        assert node["name"] == od[0x1008].default
        assert node["problem"] == ""


def test_a_node_that_only_beats_is_told_apart(bench: VirtualBench, drives, run) -> None:
    bench.network().send_periodic(0x709, b"\x04", 0.005)
    status, told = run("list")
    assert status == 1
    assert told["nodes"][-1]["node"] == 9
    assert told["nodes"][-1]["nmt_state"] == 4
    assert "no answer" in told["nodes"][-1]["problem"]
    assert len(told["nodes"]) == 1 + len(drives)


def test_two_nodes_with_one_id_are_found(bench: VirtualBench, drives, run) -> None:
    bench.add(VirtualDrive(3, "basic"))  # beside the one in `drives`
    status, told = run("list")
    assert status == 1
    assert [bool(node["problem"]) for node in told["nodes"]] == [node.id == 3 for node in drives]
    assert "2 nodes answer" in told["nodes"][2]["problem"]


def test_an_empty_bus_is_a_finding(run) -> None:
    assert run("list") == (1, {"nodes": []})


@pytest.mark.parametrize(
    "command", [["list"], ["check"], ["check", "--load", "1"], ["store", "--yes"], ["store", "--dry-run"]]
)
def test_nothing_is_sent_beside_a_firmware(bench: VirtualBench, drives, instrument: Path, run, command) -> None:
    instrument.write_text(instrument_text().replace("firmware_heartbeat_ms = 10", "firmware_heartbeat_ms = 10000"))
    bench.network().send_periodic(0x77F, b"\x05", 0.005)
    status, told = run(*command)
    assert (status, told) == (2, None)
    assert "goniod is in charge" in run.error()
    assert {frame.arbitration_id for frame in bench.frames()} == {0x77F}
    assert not any(drive.writes for drive in drives)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--interface", "nonsense"], "nonsense"),
        (["--bus-arg", "host"], "KEY=VALUE"),
    ],
)
def test_wrong_use_is_one_line(run, arguments: list[str], words: str) -> None:
    assert run("list", *arguments)[0] == 2
    assert run.error().startswith("gonio: ")
    assert run.error().count("\n") == 1
    assert words in run.error()
