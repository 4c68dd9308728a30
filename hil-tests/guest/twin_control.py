"""twin_control.py: talks to gonio-twin-devices over its control socket: state, faults, what can be undone."""

import json
import socket
from pathlib import Path
from typing import Any

from guest.processes import RigError

ANSWER_LIMIT_S = 20.0  # of a twin on a busy emulated processor


class TwinControl:
    """One connection; one command per line, one JSON object per line back."""

    def __init__(self, path: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(ANSWER_LIMIT_S)
        self._socket.connect(str(path))
        self._lines = self._socket.makefile("r", encoding="utf-8")

    def ask(self, line: str) -> dict[str, Any]:
        """Send a command. Raises RigError when the twin is gone or refuses it."""
        try:
            self._socket.sendall(line.encode() + b"\n")
            answer = self._lines.readline()
        except OSError as error:
            raise RigError(f"the twin's control socket, at {line!r}: {error}") from error
        if not answer:
            raise RigError(f"the twin ended before it answered {line!r}")
        content: dict[str, Any] = json.loads(answer)
        if "error" in content:
            raise RigError(f"the twin refuses {line!r}: {content['error']}")
        return content

    def state(self) -> dict[str, Any]:
        """Where everything is now, in truth."""
        return self.ask("state")

    def fault(self, kind: str, **values: object) -> None:
        """Let a fault happen now; keys are the scenario file's."""
        self.ask(" ".join(["fault", kind, *(f"{key}={value}" for key, value in values.items())]))

    def clear(self) -> None:
        """Undo every fault that can be undone."""
        self.ask("clear")

    def close(self) -> None:
        self._lines.close()
        self._socket.close()
