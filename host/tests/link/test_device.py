"""test_device.py: device names, and the twin that is not built."""

from pathlib import Path

import pytest

from gonio.link import transport
from gonio.link.connect import open_transport
from gonio.link.device import DEFAULT_PORT, UsbAddress, may_be_same, parse_device
from gonio.link.twin import TwinTransport
from gonio.units.errors import InstrumentFault, UsageError


def test_names(tmp_path: Path) -> None:
    scenario = tmp_path / "a.toml"
    scenario.write_text("")
    twin = parse_device(f"twin:{scenario}")
    assert twin.scenario == scenario
    assert twin.lock_step
    tcp = parse_device("tcp://127.0.0.1:4000")
    assert (tcp.host, tcp.port, tcp.lock_step) == ("127.0.0.1", 4000, False)
    assert parse_device("tcp://localhost").port == DEFAULT_PORT
    assert parse_device("tcp://[::1]:4000").host == "::1"


@pytest.mark.parametrize("name", ["", "twin:missing.toml", "tcp://", "tcp://host:port", "usb:A@1209", "127.0.0.1:4000"])
def test_other_names_are_refused_in_one_line(name: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_device(name)
    assert "\n" not in str(caught.value)


def test_names_of_usb_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GONIO_USB_ID", raising=False)
    assert parse_device("usb:").usb == UsbAddress(0x1209, 0x0001)
    assert parse_device("usb:A7").usb == UsbAddress(0x1209, 0x0001, "A7")
    assert parse_device("usb:A7@1d6b:0104").usb == UsbAddress(0x1D6B, 0x0104, "A7")
    assert parse_device("usb:@1D6B:0104").usb == UsbAddress(0x1D6B, 0x0104)
    assert not parse_device("usb:").lock_step
    monkeypatch.setenv("GONIO_USB_ID", "1d6b:0105")
    assert parse_device("usb:A7").usb == UsbAddress(0x1D6B, 0x0105, "A7")
    assert parse_device("usb:A7@1209:0001").usb == UsbAddress(0x1209, 0x0001, "A7")
    monkeypatch.setenv("GONIO_USB_ID", "nonsense")
    with pytest.raises(UsageError, match="GONIO_USB_ID"):
        parse_device("usb:")


@pytest.mark.parametrize(
    ("ours", "asked", "same"),
    [
        ("usb:", "usb:A7", True),
        ("usb:A7", "usb:", True),
        ("usb:A7", "usb:A7@1209:0001", True),
        ("usb:A7", "usb:B1", False),
        ("usb:", "usb:@1d6b:0104", False),
        ("usb:A7", "tcp://127.0.0.1", False),
        ("usb:", "usb:@nonsense", False),
    ],
)
def test_a_stop_by_another_name_of_the_same_instrument(
    ours: str, asked: str, same: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GONIO_USB_ID", raising=False)
    assert may_be_same(ours, asked) is same


def test_twin_that_is_not_built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = tmp_path / "a.toml"
    scenario.write_text("")
    monkeypatch.setenv("GONIO_TWIN", str(tmp_path / "no-twin"))
    with pytest.raises(UsageError, match="run make build"):
        open_transport(parse_device(f"twin:{scenario}"))


def test_twin_that_does_not_start_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = tmp_path / "a.toml"
    scenario.write_text("")
    program = tmp_path / "twin"
    program.write_text("#!/bin/sh\necho 'gonio-twin: a.toml: seed is missing' >&2\nexit 2\n")
    program.chmod(0o755)
    monkeypatch.setenv("GONIO_TWIN", str(program))
    with pytest.raises(UsageError, match=r"^a\.toml: seed is missing$"):
        open_transport(parse_device(f"twin:{scenario}"))


FAKE_TWIN = """#!/usr/bin/env python3
import socket, sys, time
listener = socket.create_server(("127.0.0.1", 0))
print("listening 127.0.0.1:%d" % listener.getsockname()[1], flush=True)
link, _ = listener.accept()
print("photon map: tracing incident (45, 0), 1000 photons", file=sys.stderr, flush=True)
time.sleep(0.5)
print("photon map: incident (45, 0) is ready, 0.5 s", file=sys.stderr, flush=True)
link.sendall(b"x")
link.recv(1)
"""


def test_a_twin_that_traces_is_waited_for_and_one_that_is_silent_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = tmp_path / "a.toml"
    scenario.write_text("")
    program = tmp_path / "twin"
    program.write_text(FAKE_TWIN)
    program.chmod(0o755)
    monkeypatch.setenv("GONIO_TWIN", str(program))
    monkeypatch.setattr(transport, "LOCK_STEP_SILENCE_S", 0.1)
    with open_transport(parse_device(f"twin:{scenario}")) as link:
        assert isinstance(link, TwinTransport)
        assert link.receive() == b"x"
        assert not link.twin.tracing()
        assert link.twin.last_words() == ""  # what it tells of its light is no complaint
        with pytest.raises(InstrumentFault, match="no word from the firmware"):
            link.receive()


def test_nobody_listens() -> None:
    with pytest.raises(UsageError, match="cannot connect"):
        open_transport(parse_device("tcp://127.0.0.1:1"))


def test_only_a_twin_writes_truth() -> None:
    with pytest.raises(UsageError, match="only a twin"):
        open_transport(parse_device("tcp://127.0.0.1:1"), truth=Path("truth.bin"))
