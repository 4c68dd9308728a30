"""control.py: the per-user control socket: the process that drives an instrument listens, gonio stop talks to it."""

import json
import os
import socket
import stat
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from gonio.link.device import may_be_same
from gonio.units.errors import InstrumentFault, UsageError

_ANSWER_TIMEOUT_S = 10.0  # the driver polls between frames: 100 ms, more while it computes
_READ_TIMEOUT_S = 0.5  # a client that connects and says nothing must not hold up the link
_MAX_MESSAGE = 4096


def control_directory() -> Path:
    """The user's directory of control sockets, made with mode 0700. Raises UsageError when it is not ours alone."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    path = Path(runtime) / "gonio" if runtime else Path(f"/tmp/gonio-{os.getuid()}")
    with suppress(FileExistsError):
        path.mkdir(mode=0o700)
    found = path.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise UsageError(f"{path}: must be a directory of mode 0700 that belongs to you; remove it")
    return path


class ControlSocket:
    """Listens for `stop`. Nothing blocks: poll() takes what is there."""

    def __init__(self, device: str) -> None:
        self._device = device
        self._path = control_directory() / f"{os.getpid()}.sock"
        self._path.unlink(missing_ok=True)  # of an earlier process with our number
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(self._path))
        self._listener.listen(8)
        self._listener.setblocking(False)

    def poll(self) -> str | None:
        """Answer who has connected; the reason to stop when someone asked for it."""
        reason: str | None = None
        while True:
            try:
                connection, _ = self._listener.accept()
            except BlockingIOError:
                return reason
            with connection, suppress(OSError):
                connection.settimeout(_READ_TIMEOUT_S)
                answer = self._answer(connection.recv(_MAX_MESSAGE))
                if answer["ok"]:
                    reason = "gonio stop"
                connection.sendall(json.dumps(answer).encode())

    def _answer(self, message: bytes) -> dict[str, Any]:
        answer = {"ok": False, "device": self._device, "pid": os.getpid()}
        with suppress(ValueError):
            document = json.loads(message)
            if isinstance(document, dict) and document.get("command") == "stop":
                asked = document.get("device")
                answer["ok"] = asked is None or may_be_same(self._device, str(asked))
        return answer

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()
        self._path.unlink(missing_ok=True)


@dataclass(frozen=True)
class Stopped:
    """A process that took a stop."""

    pid: int
    device: str


def stop_running(device: str | None = None) -> list[Stopped]:
    """Ask every driving process of this user (or those of one device) to stop; who accepted.

    Raises InstrumentFault when a process is there and does not answer.
    """
    request = json.dumps({"command": "stop", "device": device}).encode()
    stopped: list[Stopped] = []
    for path in sorted(control_directory().glob("*.sock")):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
            connection.settimeout(_ANSWER_TIMEOUT_S)
            try:
                connection.connect(str(path))
                connection.sendall(request)
                answer = json.loads(connection.recv(_MAX_MESSAGE))
            except (ConnectionRefusedError, FileNotFoundError):
                path.unlink(missing_ok=True)  # left by a killed process
                continue
            except (OSError, ValueError) as error:
                raise InstrumentFault(
                    f"process {path.stem} drives an instrument and does not answer: press its emergency stop, or end it"
                ) from error
        if answer["ok"]:
            stopped.append(Stopped(int(answer["pid"]), str(answer["device"])))
    return stopped
