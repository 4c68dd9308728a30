"""usb.py: the link over USB bulk transfers (libusb): several reads wait in the kernel while Python works."""

import time
from collections import deque
from contextlib import suppress
from typing import Any

import usb1

from gonio.link.device import UsbAddress
from gonio.link.transport import Transport
from gonio.link.usb_find import Claimed, claim
from gonio.units.errors import InstrumentFault, UsageError

OPEN, CLOSE = 1, 2  # vendor requests, protocol/link.md
CONTROL_TIMEOUT_MS = 1000  # the firmware answers a vendor request between two transfers
STALE_MS = 20  # what the device's USB controller kept of the client before comes at once (protocol/link.md)
READS = 32  # in flight; a transfer of the firmware ends one, so they hold 32 of its frames and more
READ_BYTES = 16384  # what Linux moves in one piece; a multiple of every packet size, so that none overflows
LARGEST_WRITE = READ_BYTES - 1
PACKET_STEP = 64  # every bulk packet size is a multiple of it
GONE = "the controller was unplugged or switched off"
CLOSE_TIMEOUT_S = 2.0  # cancelled transfers come back at once, unless the host controller hangs


def transfers(data: bytes) -> list[bytes]:
    """`data` cut into transfers, none with a length that is a multiple of 64: a short packet ends each at once."""
    pieces: list[bytes] = []
    begin = 0
    while begin < len(data):
        size = min(LARGEST_WRITE, len(data) - begin)
        if size % PACKET_STEP == 0:
            size -= 1
        pieces.append(data[begin : begin + size])
        begin += size
    return pieces


class UsbTransport(Transport):
    """A claimed controller. One thread: libusb's callbacks run inside receive, send and close."""

    def __init__(self, claimed: Claimed, name: str) -> None:
        super().__init__(name, lock_step=False)
        self._usb = claimed
        self._arrived: deque[bytes] = deque()
        self._trouble = ""  # why nothing more comes
        self._escaped: BaseException | None = None  # raised in a callback, where ctypes would swallow it
        self._closed = False
        self._reads: list[Any] = []
        self._request(OPEN)
        self._drop_stale()
        for _ in range(READS):
            read = claimed.handle.getTransfer()
            read.setBulk(claimed.endpoint_in, READ_BYTES, callback=self._on_read)
            read.submit()
            self._reads.append(read)

    def _request(self, number: int) -> None:
        kind = usb1.ENDPOINT_OUT | usb1.TYPE_VENDOR | usb1.RECIPIENT_INTERFACE
        self._usb.handle.controlWrite(kind, number, 0, self._usb.interface, b"", CONTROL_TIMEOUT_MS)

    def _drop_stale(self) -> None:
        # The firmware says nothing before our HELLO, so nothing of worth is lost.
        with suppress(usb1.USBErrorTimeout):
            while True:
                self._usb.handle.bulkRead(self._usb.endpoint_in, READ_BYTES, STALE_MS)

    def _on_read(self, read: Any) -> None:
        try:
            status = read.getStatus()
            if count := read.getActualLength():
                self._arrived.append(bytes(read.getBuffer()[:count]))
            if status == usb1.TRANSFER_COMPLETED and not self._closed:
                read.submit()
            elif status == usb1.TRANSFER_NO_DEVICE:
                self._trouble = GONE
            elif status == usb1.TRANSFER_STALL:
                self._trouble = self._trouble or "the firmware closed the link"
            elif status not in (usb1.TRANSFER_COMPLETED, usb1.TRANSFER_CANCELLED):
                self._trouble = self._trouble or f"a USB transfer failed (status {status})"
        except usb1.USBError as error:
            self._trouble = self._trouble or _why(error)
        except BaseException as error:  # a signal's handler may run here
            self._escaped = error

    def receive(self) -> bytes:
        give_up_s = time.monotonic() + self.silence_s
        self._handle_events(0.0)
        while not self._arrived:
            if self._trouble:
                raise self._lost(self._trouble)
            left_s = give_up_s - time.monotonic()
            if left_s <= 0.0:
                raise InstrumentFault(
                    f"{self.name}: no word from the firmware for {self.silence_s:.0f} s; the instrument stops by itself"
                )
            self._handle_events(left_s)
        data = b"".join(self._arrived)
        self._arrived.clear()
        return data

    def _handle_events(self, longest_s: float) -> None:
        try:
            self._usb.context.handleEventsTimeout(longest_s)
        except usb1.USBErrorInterrupted:
            pass  # by a signal, whose handler has run
        except usb1.USBError as error:
            self._trouble = self._trouble or _why(error)
        if self._escaped is not None:
            escaped, self._escaped = self._escaped, None
            raise escaped

    def send(self, data: bytes) -> None:
        for piece in transfers(data):
            if self._trouble:
                raise self._lost(self._trouble)
            try:
                self._usb.handle.bulkWrite(self._usb.endpoint_out, piece, round(1e3 * self.silence_s))
            except usb1.USBErrorTimeout as error:
                raise InstrumentFault(
                    f"{self.name}: the firmware took nothing for {self.silence_s:g} s; the instrument stops by itself"
                ) from error
            except usb1.USBError as error:
                self._trouble = self._trouble or _why(error)
                raise self._lost(self._trouble) from error

    def _lost(self, why: str) -> InstrumentFault:
        return InstrumentFault(
            f"{self.name}: {why}; the instrument stops by itself: check cable and power, then go on (scan: --resume)"
        )

    def close(self) -> None:
        """Say CLOSE, take the reads back, give the interface back. A device that is gone is no news here."""
        if self._closed:
            return
        self._closed = True
        with suppress(usb1.USBError):
            self._request(CLOSE)
        for read in self._reads:
            if read.isSubmitted():
                with suppress(usb1.USBError):
                    read.cancel()
        give_up_s = time.monotonic() + CLOSE_TIMEOUT_S
        while any(read.isSubmitted() for read in self._reads) and time.monotonic() < give_up_s:
            with suppress(usb1.USBError):
                self._usb.context.handleEventsTimeout(CLOSE_TIMEOUT_S)
        with suppress(usb1.USBError):
            self._usb.handle.releaseInterface(self._usb.interface)
        self._usb.handle.close()
        self._usb.context.close()


def _why(error: Any) -> str:
    if error.value == usb1.ERROR_NO_DEVICE:
        return GONE
    return f"USB failed ({error})"


def open_usb(address: UsbAddress, name: str) -> UsbTransport:
    """Find the controller and open the link. Raises UsageError where that is not possible."""
    claimed = claim(address, name)
    try:
        return UsbTransport(claimed, name)
    except usb1.USBError as error:
        claimed.handle.close()
        claimed.context.close()
        raise UsageError(
            f"{name}: the controller does not open the link ({error}): is goniod running on it?"
        ) from error
