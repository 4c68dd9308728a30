"""device.py: how a device is named on the command line: twin:SCENARIO.toml or tcp://HOST:PORT."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from gonio.units.errors import UsageError

DEFAULT_PORT = 7411
_FORMS = "twin:SCENARIO.toml or tcp://HOST:PORT"


@dataclass(frozen=True)
class Device:
    """A parsed device name. `twin` starts its own simulated instrument in virtual time; `tcp` keeps real time."""

    kind: Literal["twin", "tcp"]
    name: str  # as the user wrote it
    scenario: Path | None = None
    host: str = ""
    port: int = 0

    @property
    def lock_step(self) -> bool:
        """Virtual time: the device waits for this program, which must say IDLE (protocol/link.md)."""
        return self.kind == "twin"


def parse_device(name: str) -> Device:
    """Read a device name. Raises UsageError for an unknown form or a scenario that is not there."""
    if name.startswith("twin:"):
        scenario = Path(name.removeprefix("twin:"))
        if not scenario.is_file():
            raise UsageError(f"{name}: there is no scenario file {scenario}")
        return Device("twin", name, scenario=scenario)
    if name.startswith("tcp://"):
        try:
            parts = urlsplit(name)
            host, port = parts.hostname, parts.port or DEFAULT_PORT
        except ValueError:
            host, port = None, 0
        if host:
            return Device("tcp", name, host=host, port=port)
    raise UsageError(f"{name}: no device name; write {_FORMS}")
