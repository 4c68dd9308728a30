"""usb_find.py: finds the controller on USB, opens it and takes its interface; what prevents that, in one line."""

import sys
from dataclasses import dataclass
from typing import Any

import usb1

from gonio.link.device import UsbAddress
from gonio.units.errors import UsageError

INTERFACE = (0xFF, 0x47, 0x4C)  # class, subclass, protocol of the link (protocol/link.md)
UDEV_RULES = "/etc/udev/rules.d/70-gonio-host.rules"


@dataclass(frozen=True)
class Claimed:
    """An open controller, the link's interface ours alone."""

    context: Any  # usb1.USBContext
    handle: Any  # usb1.USBDeviceHandle
    interface: int
    endpoint_in: int
    endpoint_out: int


def claim(address: UsbAddress, name: str) -> Claimed:
    """Open the one controller that `address` means. Raises UsageError when there is none, there are several, it may not
    be opened, or another program has it."""
    context = usb1.USBContext()
    try:
        context.open()
        handle = _open(_choose(context, address, name), address, name)
        try:
            number, endpoint_in, endpoint_out = _interface(handle.getDevice(), name)
            handle.claimInterface(number)
        except BaseException:
            handle.close()
            raise
        return Claimed(context, handle, number, endpoint_in, endpoint_out)
    except usb1.USBErrorBusy as error:
        context.close()
        raise UsageError(
            f"{name}: another program has the controller; end it (gonio stop), or go through TCP on the controller:"
            " ssh -L 7411:127.0.0.1:7411 CONTROLLER, then --device tcp://127.0.0.1"
        ) from error
    except usb1.USBError as error:
        context.close()
        raise UsageError(f"{name}: cannot be opened ({error}): check the cable, and plug it in again") from error
    except BaseException:
        context.close()
        raise


def _choose(context: Any, address: UsbAddress, name: str) -> Any:
    """The device meant. A serial is asked for only where it decides: that needs the right to open the device."""
    there = [
        device
        for device in context.getDeviceIterator(skip_on_error=True)
        if (device.getVendorID(), device.getProductID()) == (address.vendor, address.product)
    ]
    if not there:
        raise UsageError(
            f"{name}: no controller with USB id {address.usb_id} is there: check cable and power, or the id"
            " (usb:@VVVV:PPPP, GONIO_USB_ID)"
        )
    if len(there) == 1 and not address.serial:
        return there[0]
    serials = [_serial(device, address, name) for device in there]
    meant = [device for device, serial in zip(there, serials, strict=True) if serial == address.serial]
    if len(meant) == 1:
        return meant[0]
    listed = ", ".join(sorted(serials))
    if address.serial:
        raise UsageError(f"{name}: no controller has serial {address.serial}; there: {listed}")
    raise UsageError(f"{name}: {len(there)} controllers are there: name one of usb:SERIAL with {listed}")


def _serial(device: Any, address: UsbAddress, name: str) -> str:
    try:
        return str(device.getSerialNumber() or "(no serial)")
    except usb1.USBErrorAccess as error:
        raise _forbidden(address, name) from error


def _open(device: Any, address: UsbAddress, name: str) -> Any:
    try:
        return device.open()
    except usb1.USBErrorAccess as error:
        raise _forbidden(address, name) from error
    except usb1.USBErrorNotSupported as error:
        raise UsageError(f"{name}: the system has no driver for it; Windows needs WinUSB, plug it in again") from error


def _forbidden(address: UsbAddress, name: str) -> UsageError:
    if not sys.platform.startswith("linux"):
        return UsageError(f"{name}: you may not open USB device {address.usb_id}: end the program that has it")
    rule = f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{address.vendor:04x}", ATTR{{idProduct}}=="{address.product:04x}"'
    return UsageError(
        f'{name}: you may not open USB device {address.usb_id}: as root write the line {rule}, TAG+="uaccess"'
        f" into {UDEV_RULES}, and plug it in again"
    )


def _interface(device: Any, name: str) -> tuple[int, int, int]:
    """Number and endpoints (in, out) of the link's interface."""
    for setting in device.iterSettings():
        if (*setting.getClassTuple(), setting.getProtocol()) != INTERFACE:
            continue
        bulk = [
            e.getAddress() for e in setting if e.getAttributes() & usb1.TRANSFER_TYPE_MASK == usb1.TRANSFER_TYPE_BULK
        ]
        into = [address for address in bulk if address & usb1.ENDPOINT_DIR_MASK == usb1.ENDPOINT_IN]
        out = [address for address in bulk if address & usb1.ENDPOINT_DIR_MASK == usb1.ENDPOINT_OUT]
        if into and out:
            return setting.getNumber(), into[0], out[0]
    raise UsageError(f"{name}: the device has no gonio link: it is another device, or goniod does not run on it")
