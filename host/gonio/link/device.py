"""device.py: how a device is named on the command line: twin:SCENARIO.toml, usb:SERIAL or tcp://HOST:PORT."""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from gonio.units.errors import UsageError

DEFAULT_PORT = 7411
# A test id of pid.codes: for laboratories' own use, not for instruments that are passed on (protocol/link.md).
DEFAULT_USB_ID = "1209:0001"
USB_ID_VARIABLE = "GONIO_USB_ID"
_FORMS = "twin:SCENARIO.toml, usb:, usb:SERIAL, usb:SERIAL@VVVV:PPPP or tcp://HOST:PORT"
_USB_ID = re.compile(r"([0-9a-fA-F]{4}):([0-9a-fA-F]{4})")


@dataclass(frozen=True)
class UsbAddress:
    """Which USB device: its vendor and product id, and its serial number (empty: the only one there is)."""

    vendor: int
    product: int
    serial: str = ""

    @property
    def usb_id(self) -> str:
        """As it is written: VVVV:PPPP."""
        return f"{self.vendor:04x}:{self.product:04x}"


@dataclass(frozen=True)
class Device:
    """A parsed device name. `twin` starts its own simulated instrument in virtual time; the others keep real time."""

    kind: Literal["twin", "usb", "tcp"]
    name: str  # as the user wrote it
    scenario: Path | None = None
    usb: UsbAddress | None = None
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
    if name.startswith("usb:"):
        return Device("usb", name, usb=_usb_address(name))
    if name.startswith("tcp://"):
        try:
            parts = urlsplit(name)
            host, port = parts.hostname, parts.port or DEFAULT_PORT
        except ValueError:
            host, port = None, 0
        if host:
            return Device("tcp", name, host=host, port=port)
    raise UsageError(f"{name}: no device name; write {_FORMS}")


def _usb_address(name: str) -> UsbAddress:
    serial, at, written = name.removeprefix("usb:").partition("@")
    where = name if at else USB_ID_VARIABLE
    usb_id = written if at else os.environ.get(USB_ID_VARIABLE) or DEFAULT_USB_ID
    found = _USB_ID.fullmatch(usb_id)
    if not found:
        raise UsageError(f"{where}: {usb_id!r} is no USB id; write vendor and product in hexadecimal: {DEFAULT_USB_ID}")
    return UsbAddress(int(found[1], 16), int(found[2], 16), serial)


def may_be_same(ours: str, asked: str) -> bool:
    """Whether two device names may mean one instrument: a usb: name without a serial means any with that id."""
    if ours == asked:
        return True
    if not (ours.startswith("usb:") and asked.startswith("usb:")):
        return False
    try:
        a, b = _usb_address(ours), _usb_address(asked)
    except UsageError:
        return False
    return a.usb_id == b.usb_id and (not a.serial or not b.serial or a.serial == b.serial)
