"""test_drives_twin.py: the commands against the C++ drive models, over python-can's socketcand interface."""

import json
import select
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from virtual_drives import eds, instrument_text

from gonio.acquire.session import Session
from gonio.cli import main
from gonio.drives.objects import used_objects
from gonio.link.client import Client
from gonio.link.connect import open_transport
from gonio.link.device import parse_device
from gonio.link.twin import twin_program
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

pytestmark = pytest.mark.twin
SCENARIOS = Path(__file__).parents[3] / "sim" / "scenarios"
COMES_UP_S = 60.0
BOOT_NS = 30_000_000_000  # virtual time
CYCLES = 20


class Twin:
    """gonio-twin-devices with its control socket."""

    def __init__(self, program: Path, scenario: Path, folder: Path) -> None:
        self.control_path = folder / "control.sock"
        command = [str(program), str(scenario), "--can", "socketcand:127.0.0.1:0", "--control", str(self.control_path)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.port = 0
        text = b""
        assert self.process.stdout is not None
        while b"serving" not in text:
            assert select.select([self.process.stdout], [], [], COMES_UP_S)[0], "the twin does not come up"
            part = self.process.stdout.read1(4096)
            assert part, self.process.stderr and self.process.stderr.read()
            text += part
        self.port = int(text.split(b"listening 127.0.0.1:")[1].split()[0])
        end_s = time.monotonic() + COMES_UP_S
        while not self._booted():
            assert time.monotonic() < end_s, "the drives do not boot"

    def _booted(self) -> bool:
        state = self.control("state")
        return state["nmt_state"] == [127] * 4 and all(word & 0x6F == 0x40 for word in state["statusword"])

    def control(self, line: str) -> dict[str, Any]:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(COMES_UP_S)
            connection.connect(str(self.control_path))
            connection.sendall(line.encode() + b"\n")
            return json.loads(connection.makefile().readline())

    def close(self) -> None:
        self.process.terminate()
        assert self.process.wait(COMES_UP_S) == 0


@pytest.fixture
def twin(tmp_path: Path) -> Iterator[Callable[[str], Twin]]:
    try:
        program = twin_program().with_name("gonio-twin-devices")
    except UsageError as missing:
        pytest.skip(str(missing))
    if not program.is_file():
        pytest.skip(f"{program} is not built")
    with ExitStack() as stack:

        def start(name: str) -> Twin:
            made = Twin(program, SCENARIOS / name, tmp_path)
            stack.callback(made.close)
            return made

        yield start


@pytest.fixture
def ask(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, Any, str]]:
    """`gonio drives` on a twin: exit status, the JSON object, standard error."""
    instrument = tmp_path / "axes.toml"
    instrument.write_text(instrument_text().replace("sync_window_us = 1500", "sync_window_us = 2000"))

    def go(twin: Twin, command: str, *more: str) -> tuple[int, Any, str]:
        bus = ["--interface", "socketcand", "--channel", "can0", "--bus-arg", "host=127.0.0.1", "--bus-arg"]
        bus += [f"port={twin.port}", "--bus-arg", "tcp_tune=yes"]
        capsys.readouterr()
        status = main.run(["drives", command, *bus, "--instrument", str(instrument), "--json", *more])
        out = capsys.readouterr()
        return status, json.loads(out.out) if out.out.strip() else None, out.err

    return go


def grades(told: Any, grade: str, node: int) -> set[str]:
    return {f["object"] for f in told["findings"] if f["grade"] == grade and f["where"].startswith(f"node {node} ")}


def test_list_agrees_with_the_scenario(twin, ask) -> None:
    status, told, _ = ask(twin("fixed_drives.toml"), "list")
    assert status == 0, told
    assert [node["node"] for node in told["nodes"]] == [1, 2, 3, 4]
    assert [node["name"].rsplit(", ", 1)[1] for node in told["nodes"]] == ["fixed", "fixed", "full", "fixed"]


def notes_of_the_firmware(scenario: Path) -> dict[int, set[str]]:
    """What the firmware says it went without when it booted the drives of the same scenario, in virtual time."""
    transport = open_transport(parse_device(f"twin:{scenario}"))
    with transport, Client(transport) as client:
        Session(client, load_instrument(None)).configure()
        client.operation(BOOT_NS, boot=pb.Boot())
        info = client.request(get_info=pb.GetInfo()).info
    return {
        node.node: {word for word in node.notes.replace(",", " ").split() if word[:2] == "0x"} for node in info.nodes
    }


def test_fallbacks_are_what_the_firmware_went_without(twin, ask) -> None:
    """Two programs, one drive model: the check by its table and the EDS, the firmware by booting."""
    untold = {f"0x{used.index:04X}" for used in used_objects() if used.lacking and used.use == "read"}
    notes = notes_of_the_firmware(SCENARIOS / "basic_drives.toml")
    told = ask(twin("basic_drives.toml"), "check", "--eds", str(eds("basic")))[1]
    for node in (1, 2, 3, 4):
        found = {name.split(":")[0] for name in grades(told, "fallback", node)} - untold
        assert found == {name.split(":")[0] for name in notes[node]} == {"0x6007", "0x1029", "0x60C2"}
        assert grades(told, "wrong", node) == set()


def test_the_load_runs_and_leaves_the_models_as_they_were(twin, ask, tmp_path: Path) -> None:
    text = (tmp_path / "axes.toml").read_text(encoding="utf-8")
    text = text.replace("sync_period_us = 2000", "sync_period_us = 50000").replace("= 2000 ", "= 50000 ", 1)
    (tmp_path / "axes.toml").write_text(text, encoding="utf-8")
    bench = twin("fixed_drives.toml")
    before = ask(bench, "check")[1]["drives"]
    told = ask(bench, "check", "--load", str(CYCLES * 0.05))[1]
    assert told["load"]["syncs"] + told["load"]["cycles_skipped_by_host"] == CYCLES
    assert all(node["received"] > 0 for node in told["load"]["nodes"])
    assert not any(node["emergencies"] for node in told["load"]["nodes"])
    state = bench.control("state")
    assert state["nmt_state"] == [127] * 4
    assert [word & 0x04 for word in state["statusword"]] == [0] * 4  # no motor was ever enabled
    after = ask(bench, "check")[1]["drives"]
    for was, is_now in zip(before, after, strict=True):
        assert dict(was["objects"].items() ^ is_now["objects"].items()) == {}


def test_a_drive_that_is_off_is_named(twin, ask, tmp_path: Path) -> None:
    text = (tmp_path / "axes.toml").read_text(encoding="utf-8").replace("sdo_timeout_ms = 5000", "sdo_timeout_ms = 500")
    (tmp_path / "axes.toml").write_text(text, encoding="utf-8")
    bench = twin("demo.toml")
    bench.control("fault node_missing axis=2")
    status, told, _ = ask(bench, "check")
    assert status == 1
    assert [bool(drive["objects"]) for drive in told["drives"]] == [True, True, False, True]
    status, told, _ = ask(bench, "list")
    assert [node["node"] for node in told["nodes"]] == [1, 2, 4]


def test_a_drive_without_0x1010_is_not_written(twin, ask) -> None:
    status, told, _ = ask(twin("demo.toml"), "store", "--yes")
    assert status == 1
    assert {f["object"] for f in told["findings"]} == {"0x1010:01"}
    assert not any(drive["stored"] for drive in told["drives"])
