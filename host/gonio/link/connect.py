"""connect.py: from a device's name to the connected stream."""

# ruff: noqa: PLC0415 - libusb is loaded only for a device that is on it

from pathlib import Path

from gonio.link.device import Device
from gonio.link.tcp import open_tcp
from gonio.link.transport import Transport
from gonio.link.twin import open_twin
from gonio.units.errors import UsageError


def open_transport(device: Device, *, truth: Path | None = None, journal: Path | None = None) -> Transport:
    """Connect to a device; a twin is started first and may write its truth and journal files.

    Raises UsageError when there is nothing to connect to, or when truth or journal are asked of a device that has none.
    """
    if device.scenario is not None:
        return open_twin(device.scenario, device.name, truth=truth, journal=journal)
    if truth or journal:
        raise UsageError(f"{device.name}: only a twin: device writes truth and journal files")
    if device.usb is not None:
        try:
            from gonio.link.usb import open_usb
        except (ImportError, OSError) as error:  # the package, or the library that it loads
            raise UsageError(
                f"{device.name}: libusb is not there ({error}): install the package libusb1 and the system's libusb 1.0"
            ) from error
        return open_usb(device.usb, device.name.removesuffix(":"))
    return open_tcp(device.host, device.port, device.name)
