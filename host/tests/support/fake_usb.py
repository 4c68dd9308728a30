"""fake_usb.py: libusb with controllers that are not there: the part of usb1 that gonio uses, bridged to a TCP port.

It keeps USB's rules: a transfer of the device ends with its short packet and fills one read, or several when it is
longer; reads complete in the order they were submitted; nothing arrives without a read; an unplugged device completes
every read with NO_DEVICE. What the host must not do is kept in `Bus.broken`.
"""

import select
import socket
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import usb1

BULK_IN, BULK_OUT, INTERFACE_NUMBER = 0x83, 0x02, 1
POLL_S = 0.05  # libusb may come back early: so it does, and looks for an unplugged cable


@dataclass
class FakeController:
    """A device on the bus; its firmware listens on `port`."""

    port: int = 0
    serial: str = "A1"
    usb_id: tuple[int, int] = (0x1209, 0x0001)
    protocol: int = 0x4C
    forbidden: bool = False  # by the rights on its device node
    busy: bool = False  # another process has its interface
    deaf: bool = False  # takes no more data
    stale: list[bytes] = field(default_factory=list)  # what its USB controller kept of the client before
    plugged: bool = True

    # What gonio asks of usb1.USBDevice
    bus: "Bus | None" = None

    def getVendorID(self) -> int:  # noqa: N802 - usb1's names
        return self.usb_id[0]

    def getProductID(self) -> int:  # noqa: N802
        return self.usb_id[1]

    def getSerialNumber(self) -> str:  # noqa: N802
        if self.forbidden:
            raise usb1.USBErrorAccess
        return self.serial

    def open(self) -> "FakeHandle":
        if self.forbidden:
            raise usb1.USBErrorAccess
        assert self.bus
        return FakeHandle(self, self.bus)

    def iterSettings(self) -> Iterator["FakeSetting"]:  # noqa: N802
        yield FakeSetting(0, (0x08, 0x06), 0x50)  # a disk beside it
        yield FakeSetting(INTERFACE_NUMBER, (0xFF, 0x47), self.protocol)


@dataclass
class FakeSetting:
    number: int
    kind: tuple[int, int]
    protocol: int

    def getNumber(self) -> int:  # noqa: N802
        return self.number

    def getClassTuple(self) -> tuple[int, int]:  # noqa: N802
        return self.kind

    def getProtocol(self) -> int:  # noqa: N802
        return self.protocol

    def __iter__(self) -> Iterator["FakeEndpoint"]:
        return iter([FakeEndpoint(0x81, 3), FakeEndpoint(BULK_IN, 2), FakeEndpoint(BULK_OUT, 2)])


@dataclass
class FakeEndpoint:
    address: int
    attributes: int

    def getAddress(self) -> int:  # noqa: N802
        return self.address

    def getAttributes(self) -> int:  # noqa: N802
        return self.attributes


class FakeHandle:
    """An open device. OPEN connects to the firmware, CLOSE and the end of the handle disconnect."""

    def __init__(self, controller: FakeController, bus: "Bus") -> None:
        self.controller = controller
        self.bus = bus
        self.reads: deque[FakeTransfer] = deque()
        self.wire: deque[bytes] = deque()  # transfers of the device that no read has taken
        self.connection: socket.socket | None = None
        bus.handles.append(self)

    def getDevice(self) -> FakeController:  # noqa: N802
        return self.controller

    def claimInterface(self, number: int) -> None:  # noqa: N802
        assert number == INTERFACE_NUMBER
        if self.controller.busy:
            raise usb1.USBErrorBusy
        self.bus.said.append("claim")

    def releaseInterface(self, number: int) -> None:  # noqa: N802
        assert number == INTERFACE_NUMBER
        self._alive()
        self.bus.said.append("release")

    def _alive(self) -> None:
        if not self.controller.plugged:
            raise usb1.USBErrorNoDevice

    def controlWrite(self, kind: int, request: int, value: int, index: int, data: bytes, timeout: int) -> int:  # noqa: N802
        assert (kind, value, index, data) == (0x41, 0, INTERFACE_NUMBER, b"")
        assert timeout > 0
        self._alive()
        self.bus.said.append({1: "open", 2: "close"}[request])
        if request == 1:
            self.connection = socket.create_connection(("127.0.0.1", self.controller.port))
        elif self.connection:
            self.connection.close()
            self.connection = None
        return 0

    def getTransfer(self) -> "FakeTransfer":  # noqa: N802
        return FakeTransfer(self)

    def bulkRead(self, endpoint: int, length: int, timeout: int) -> bytes:  # noqa: N802
        assert endpoint == BULK_IN
        assert timeout > 0
        self._alive()
        if not self.controller.stale:
            raise usb1.USBErrorTimeout
        return self.controller.stale.pop(0)[:length]

    def bulkWrite(self, endpoint: int, data: bytes, timeout: int) -> int:  # noqa: N802
        assert endpoint == BULK_OUT
        assert timeout > 0
        self._alive()
        if self.controller.deaf:
            raise usb1.USBErrorTimeout
        if len(data) % 64 == 0:
            self.bus.broken.append(f"a transfer of {len(data)} bytes")
        if self.connection is None:
            self.bus.broken.append("data without OPEN")
            return 0
        self.bus.most_in_flight = max(self.bus.most_in_flight, len(self.reads))
        self.connection.sendall(data)
        return len(data)

    def close(self) -> None:
        if any(read.submitted for read in self.reads):
            self.bus.broken.append("closed with reads in flight")
        if self.connection:
            self.connection.close()
        self.bus.said.append("closed")

    def events(self, longest_s: float) -> None:
        """One round of libusb's event loop."""
        listens = self.controller.plugged and self.connection is not None and not self.wire
        if listens and select.select([self.connection], [], [], min(longest_s, POLL_S))[0]:
            assert self.connection
            data = self.connection.recv(1 << 20)
            self.wire.extend(device_transfers(data))
            if not data:
                self.controller.plugged = False  # the firmware that ends takes its gadget off the bus
        for read in [read for read in self.reads if read.cancelled]:
            self._complete(read, usb1.TRANSFER_CANCELLED)
        while self.wire and self.reads:
            data = self.wire.popleft()
            read = self.reads[0]
            if len(data) > read.length:
                self.wire.appendleft(data[read.length :])
            self._complete(read, usb1.TRANSFER_COMPLETED, data[: read.length])
        if not self.controller.plugged:
            for read in list(self.reads):
                self._complete(read, usb1.TRANSFER_NO_DEVICE)

    def _complete(self, read: "FakeTransfer", status: int, data: bytes = b"") -> None:
        self.reads.remove(read)
        read.submitted = read.cancelled = False
        read.status, read.data = status, data
        read.callback(read)


def device_transfers(data: bytes) -> list[bytes]:
    """As the firmware sends it: at most 40,000 bytes in one, and one byte split off a multiple of 64."""
    out: list[bytes] = []
    while data:
        piece, data = data[:40_000], data[40_000:]
        out += [piece] if len(piece) % 64 else [piece[:-1], piece[-1:]]
    return out


class FakeTransfer:
    """A read: usb1.USBTransfer."""

    def __init__(self, handle: FakeHandle) -> None:
        self.handle = handle
        self.callback: Callable[[FakeTransfer], None] = lambda _: None
        self.length = 0
        self.submitted = self.cancelled = False
        self.status = -1
        self.data = b""

    def setBulk(self, endpoint: int, length: int, callback: Callable[["FakeTransfer"], None]) -> None:  # noqa: N802
        assert endpoint == BULK_IN
        assert length % 1024 == 0, "a packet could overflow the buffer"
        self.length, self.callback = length, callback

    def submit(self) -> None:
        assert not self.submitted
        if not self.handle.controller.plugged:
            raise usb1.USBErrorNoDevice
        self.submitted = True
        self.handle.reads.append(self)

    def cancel(self) -> None:
        assert self.submitted
        self.cancelled = True

    def isSubmitted(self) -> bool:  # noqa: N802
        return self.submitted

    def getStatus(self) -> int:  # noqa: N802
        return self.status

    def getActualLength(self) -> int:  # noqa: N802
        return len(self.data)

    def getBuffer(self) -> memoryview:  # noqa: N802
        return memoryview(self.data.ljust(self.length, b"\xaa"))


@dataclass
class Bus:
    """What is plugged in, what was said, what was broken. `Bus.context` takes the place of usb1.USBContext."""

    controllers: list[FakeController]
    said: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    handles: list[FakeHandle] = field(default_factory=list)
    most_in_flight: int = 0
    contexts: int = 0
    interruptions: int = 0  # so many rounds of events are cut short by a signal

    def context(self) -> "FakeContext":
        for controller in self.controllers:
            controller.bus = self
        return FakeContext(self)


class FakeContext:
    def __init__(self, bus: Bus) -> None:
        self.bus = bus

    def open(self) -> None:
        self.bus.contexts += 1

    def close(self) -> None:
        self.bus.contexts -= 1

    def getDeviceIterator(self, skip_on_error: bool) -> Iterator[FakeController]:  # noqa: N802
        assert skip_on_error  # somebody else's broken device is not our concern
        return iter(self.bus.controllers)

    def handleEventsTimeout(self, tv: float) -> None:  # noqa: N802
        if self.bus.interruptions:
            self.bus.interruptions -= 1
            raise usb1.USBErrorInterrupted
        for handle in self.bus.handles:
            handle.events(tv)
