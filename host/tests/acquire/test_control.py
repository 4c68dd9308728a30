"""test_control.py: the control socket between processes of one user."""

import socket
import threading
from pathlib import Path

import pytest

from gonio.acquire.control import ControlSocket, control_directory, stop_running
from gonio.acquire.interrupt import Interrupt, ScanStopped
from gonio.units.errors import UsageError


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


def serve(control: ControlSocket, reasons: list[str], until: threading.Event) -> None:
    while not until.is_set():
        if (reason := control.poll()) is not None:
            reasons.append(reason)


def stop_against(device: str, asked: str | None) -> tuple[list[str], list[str]]:
    """A driving process on `device`, and a stop for `asked`: the reasons it got, the devices that were stopped."""
    reasons: list[str] = []
    done = threading.Event()
    with ControlSocket(device) as control:
        thread = threading.Thread(target=serve, args=(control, reasons, done))
        thread.start()
        try:
            stopped = [process.device for process in stop_running(asked)]
        finally:
            done.set()
            thread.join()
    return reasons, stopped


@pytest.mark.parametrize("asked", [None, "tcp://here:1"])
def test_stop_reaches_the_driver(asked: str | None) -> None:
    assert stop_against("tcp://here:1", asked) == (["gonio stop"], ["tcp://here:1"])


def test_stop_of_another_device_is_not_for_us() -> None:
    assert stop_against("tcp://here:1", "tcp://there:1") == ([], [])


def test_nobody_drives() -> None:
    assert stop_running() == []


def test_socket_of_a_killed_process_is_removed() -> None:
    stale = control_directory() / "1.sock"
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(stale))
    dead.close()
    assert stop_running() == []
    assert not stale.exists()


def test_nonsense_is_answered_and_ignored() -> None:
    with ControlSocket("x") as control, socket.socket(socket.AF_UNIX) as client:
        client.connect(str(next(control_directory().glob("*.sock"))))
        client.sendall(b"\xff[[[")
        assert control.poll() is None
        assert b'"ok": false' in client.recv(4096)


def test_directory_is_ours_alone(tmp_path: Path) -> None:
    directory = control_directory()
    assert directory.stat().st_mode & 0o777 == 0o700
    directory.chmod(0o755)
    with pytest.raises(UsageError, match="0700"):
        control_directory()
    directory.rmdir()
    directory.symlink_to(tmp_path)
    with pytest.raises(UsageError, match="0700"):
        control_directory()


def test_socket_goes_with_the_scan() -> None:
    with ControlSocket("x"):
        assert len(list(control_directory().glob("*.sock"))) == 1
    assert list(control_directory().glob("*.sock")) == []


def test_interrupt_stops_once() -> None:
    """A second check while the stop is under way does not interrupt the stop itself."""
    interrupt = Interrupt()
    interrupt.check()
    interrupt.reason = "SIGTERM"
    with pytest.raises(ScanStopped, match="SIGTERM"):
        interrupt.check()
    interrupt.check()
