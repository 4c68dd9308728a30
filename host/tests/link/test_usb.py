"""test_usb.py: the USB transport against a libusb that is not there: splitting, finding, unplugging, a whole scan."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import usb1
from fake_firmware import FakeFirmware
from fake_usb import Bus, FakeController
from hypothesis import given
from hypothesis import strategies as st
from tiny_scan import run_tiny_scan, with_data

from gonio.acquire.control import ControlSocket
from gonio.acquire.interrupt import ScanStopped
from gonio.cli import main
from gonio.link import connect, transport
from gonio.link.client import Client
from gonio.link.connect import open_transport
from gonio.link.device import parse_device
from gonio.link.usb import LARGEST_WRITE, READS, transfers
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.rawlog.segment_reader import read_segment
from gonio.units.errors import InstrumentFault, UsageError

Plug = Callable[..., Bus]


@pytest.fixture
def plug(monkeypatch: pytest.MonkeyPatch) -> Plug:
    """plug(controller, ...) puts controllers on the bus."""
    monkeypatch.delenv("GONIO_USB_ID", raising=False)

    def make(*controllers: FakeController) -> Bus:
        bus = Bus(list(controllers))
        monkeypatch.setattr(usb1, "USBContext", bus.context)
        return bus

    return make


@pytest.fixture
def firmware() -> Iterator[Callable[..., FakeFirmware]]:
    """firmware(**FakeFirmware arguments): a scripted firmware in real time, closed after the test."""
    made: list[FakeFirmware] = []

    def make(**arguments: Any) -> FakeFirmware:
        made.append(FakeFirmware(lock_step=False, **arguments))
        return made[-1]

    yield make
    for fake in made:
        fake.close()


@given(st.integers(0, 5 * LARGEST_WRITE) | st.integers(0, 2000).map(lambda n: 64 * n))
def test_no_transfer_is_a_multiple_of_64_bytes_and_none_is_lost(size: int) -> None:
    data = bytes(range(256)) * (size // 256 + 1)
    pieces = transfers(data[:size])
    assert b"".join(pieces) == data[:size]
    assert all(len(piece) % 64 and len(piece) <= LARGEST_WRITE for piece in pieces)
    assert len(pieces) <= size // LARGEST_WRITE + 2  # one byte split off at the end, no more


def test_a_whole_scan_over_usb(plug: Plug, firmware: Callable[..., FakeFirmware], tmp_path: Path) -> None:
    fake = firmware(on_tick=with_data)
    bus = plug(FakeController(fake.port))
    log = run_tiny_scan(tmp_path, "usb:")
    assert fake.broken == []
    assert bus.broken == []
    assert bus.said == ["claim", "open", "close", "release", "closed"]
    assert bus.contexts == 0
    assert bus.most_in_flight == READS
    segment = read_segment(log)
    assert segment.complete
    assert segment.link_gap_frames == 0
    assert segment.metadata["device"] == "usb:"
    assert len(segment.sample_payloads) > 5
    assert [e.path.path_id for e in segment.events if e.HasField("path")] == [1, 2]


def test_long_transfers_and_many_frames_arrive_whole(plug: Plug, firmware: Callable[..., FakeFirmware]) -> None:
    """Longer than a read, or just a read long, or a multiple of a packet: the stream is the same."""
    sizes = [60_000, 16_384 - 20, 16_384, 512 - 20, 44, 1, 40_000]

    def talk(fake: FakeFirmware, tick: int) -> None:
        if tick == 2:
            for size in sizes:
                fake.put(records.FRAME_SAMPLES, bytes([size % 251]) * size)

    fake = firmware(on_tick=talk)
    plug(FakeController(fake.port))
    seen: list[bytes] = []
    with Client(open_transport(parse_device("usb:"))) as client:
        client.on_frame = lambda frame: (
            seen.append(bytes(frame.payload)) if frame.kind == records.FRAME_SAMPLES else None
        )
        while len(seen) < len(sizes):
            client.step()
        assert client.gap_frames == 0
    assert seen == [bytes([size % 251]) * size for size in sizes]


def test_unplugged_in_a_scan(plug: Plug, firmware: Callable[..., FakeFirmware], tmp_path: Path) -> None:
    """What came before is in the file, which is readable; the sentence says what to do."""
    controller = FakeController()

    def unplug(fake: FakeFirmware, tick: int) -> None:
        with_data(fake, tick)
        if fake.knots_received >= 60:
            controller.plugged = False

    controller.port = firmware(on_tick=unplug).port
    bus = plug(controller)
    with pytest.raises(InstrumentFault, match=r"^usb:A1: the controller was unplugged or switched off;.*--resume"):
        run_tiny_scan(tmp_path, "usb:A1")
    assert (bus.broken, bus.contexts) == ([], 0)
    segment = read_segment(tmp_path / "raw.mcap")
    assert not segment.damaged
    assert len(segment.sample_payloads) >= 2
    assert [e for e in segment.events if e.HasField("path")] == []


def test_what_came_before_the_unplugging_is_received(plug: Plug, firmware: Callable[..., FakeFirmware]) -> None:
    controller = FakeController(firmware(ticks=0, refusal="x").port)
    bus = plug(controller)
    with open_transport(parse_device("usb:")) as link:
        bus.handles[0].wire.extend([b"the last", b" words"])
        controller.plugged = False
        assert link.receive() == b"the last words"
        for call in (link.receive, link.receive, lambda: link.send(b"x")):
            with pytest.raises(InstrumentFault, match="unplugged"):
                call()
    assert bus.broken == []


def test_a_firmware_that_takes_nothing_or_says_nothing(
    plug: Plug, firmware: Callable[..., FakeFirmware], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transport, "PACED_SILENCE_S", 0.2)
    controller = FakeController(firmware(ticks=0, refusal="x").port)
    plug(controller)
    with open_transport(parse_device("usb:")) as link:
        with pytest.raises(InstrumentFault, match="no word from the firmware"):
            link.receive()
        controller.deaf = True
        with pytest.raises(InstrumentFault, match="took nothing"):
            link.send(b"x")


def test_what_the_device_kept_for_the_client_before_is_dropped(
    plug: Plug, firmware: Callable[..., FakeFirmware]
) -> None:
    fake = firmware()
    plug(controller := FakeController(fake.port, stale=[b"GN of somebody else", b"x"]))
    with Client(open_transport(parse_device("usb:"))) as client:
        client.step()
        assert client.hello.schema_hash == records.SCHEMA_HASH
    assert controller.stale == []


def test_signals_do_not_disturb(plug: Plug, firmware: Callable[..., FakeFirmware]) -> None:
    """A signal cuts libusb's wait short: its handler has run, and the wait goes on."""
    bus = plug(FakeController(firmware().port))
    with Client(open_transport(parse_device("usb:"))) as client:
        bus.interruptions = 3
        for _ in range(3):  # the first may have come with HELLO
            client.step()
        assert bus.interruptions == 0


def test_what_a_handler_raises_inside_a_callback_is_not_lost(
    plug: Plug, firmware: Callable[..., FakeFirmware], monkeypatch: pytest.MonkeyPatch
) -> None:
    """ctypes would print it and go on; the second Ctrl-C must end the program wherever it comes."""

    def handler(_: object) -> int:
        raise KeyboardInterrupt

    plug(FakeController(firmware().port))
    with Client(open_transport(parse_device("usb:"))) as client:
        monkeypatch.setattr("fake_usb.FakeTransfer.getActualLength", handler)
        with pytest.raises(KeyboardInterrupt):
            client.wait_until(lambda: False, 10**9, "an interrupt")
        monkeypatch.undo()


@pytest.mark.parametrize(
    ("name", "controllers", "says"),
    [
        ("usb:", [], "no controller with USB id 1209:0001 is there: check cable"),
        ("usb:@1d6b:0104", [FakeController()], "no controller with USB id 1d6b:0104"),
        ("usb:", [FakeController(serial="B2"), FakeController(serial="A1")], "usb:SERIAL with A1, B2"),
        ("usb:C3", [FakeController(serial="B2"), FakeController(serial="A1")], "no controller has serial C3.*A1, B2"),
        ("usb:", [FakeController(forbidden=True)], 'ATTR{idVendor}=="1209".*70-gonio-host.rules'),
        ("usb:A1", [FakeController(forbidden=True)], "70-gonio-host.rules"),
        ("usb:", [FakeController(busy=True)], "another program has the controller.*ssh -L"),
        ("usb:", [FakeController(protocol=0x44)], "no gonio link"),
    ],
)
def test_what_prevents_it_is_one_line(plug: Plug, name: str, controllers: list[FakeController], says: str) -> None:
    bus = plug(*controllers)
    with pytest.raises(UsageError, match=says) as caught:
        open_transport(parse_device(name))
    assert str(caught.value).startswith(f"{name.removesuffix(':')}: ")
    assert "\n" not in str(caught.value)
    assert bus.contexts == 0


def test_the_controller_of_that_serial(plug: Plug, firmware: Callable[..., FakeFirmware]) -> None:
    other = FakeController(serial="B2", forbidden=False, busy=True)
    plug(other, FakeController(firmware().port, serial="A1"))
    with Client(open_transport(parse_device("usb:A1"))) as client:
        client.step()


def test_a_machine_without_libusb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gonio.link.usb", None)
    with pytest.raises(UsageError, match="libusb is not there"):
        connect.open_transport(parse_device("usb:"))


def test_libusb_is_loaded_for_a_usb_device_alone() -> None:
    """gonio scan --help, and every other device, must not wait for it, or fail without it."""
    script = "import sys, gonio.acquire.scan, gonio.cli.main, gonio.link.connect; print('usb1' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def describe(_: FakeFirmware, request: pb.Request) -> pb.Reply | None:
    """A script: what a real controller says of itself."""
    if request.WhichOneof("body") != "get_info":
        return None
    node = pb.NodeInfo(node=3, notes="no 0x6007")
    told = pb.Info(device="board", firmware="goniod 1", kernel="Linux 6.1.0-rt aarch64", realtime=True, nodes=[node])
    return pb.Reply(info=told)


def test_info_home_and_stop_on_the_command_line(
    plug: Plug, firmware: Callable[..., FakeFirmware], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    fakes = [firmware(on_request=describe) for _ in range(4)]
    controller = FakeController()
    bus = plug(controller)

    def run(fake: FakeFirmware, *arguments: str) -> str:
        controller.port = fake.port
        assert main.run([*arguments, "--device", "usb:A1"]) == 0
        assert (fake.broken, bus.broken, bus.contexts) == ([], [], 0)
        return str(capsys.readouterr().out)

    assert "Linux 6.1.0-rt aarch64, PREEMPT_RT: yes\n" in (told := run(fakes[0], "info"))
    assert "node 3: vendor 0x00000000, product 0x00000000; no 0x6007\n" in told
    assert json.loads(run(fakes[1], "info", "--json"))["realtime"] is True
    assert run(fakes[2], "home").count("deg\n") == 4
    assert run(fakes[3], "stop") == "usb:A1 stops\n"
    assert [r.stop.reason for r in fakes[3].requests] == ["gonio stop"]


def test_stop_goes_to_the_process_that_drives(
    plug: Plug, firmware: Callable[..., FakeFirmware], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The interface is its alone: gonio stop asks that process, by whichever name it has the instrument."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    stopper: list[subprocess.Popen[str]] = []

    def ask(fake: FakeFirmware, tick: int) -> None:
        with_data(fake, tick)
        if fake.knots_received >= 60 and not stopper:
            command = [sys.executable, "-m", "gonio.cli.main", "stop", "--device", "usb:A1"]
            stopper.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        if stopper:
            fake.knots_received = 60  # grants no more: the path is under way until the stop comes

    fake = firmware(on_tick=ask, ticks=100_000)
    bus = plug(FakeController(fake.port))
    with ControlSocket("usb:") as control, pytest.raises(ScanStopped, match=r"gonio stop.*at rest"):
        run_tiny_scan(tmp_path, "usb:", control)
    assert stopper[0].communicate()[0].endswith("stops usb:\n")
    assert bus.broken == []
    assert [r.stop.reason for r in fake.requests if r.HasField("stop")] == ["stopped by gonio stop"]
