"""bus.py: a CAN bus by python-can, guarded against a firmware that is in charge, and SDO access to its nodes."""

import logging
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import can
import canopen
from canopen.sdo import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoError

from gonio.drives.objects import object_name
from gonio.drives.values import FIRMWARE_NODE
from gonio.units.errors import GonioError, InstrumentFault, UsageError

HEARTBEAT = 0x700
SDO_REQUEST = 0x600
SDO_ANSWER = 0x580
NMT_RESET_NODE = 0x81
NODES = range(1, 128)
SEND_PATIENCE_S = 0.1  # 127 requests through a queue of ten frames: it drains in 2 ms at 1 Mbit/s, in 20 at 100 kbit/s
NOTIFIER_CYCLE_S = 0.05  # how long the end of the receiving thread may take
PRE_OPERATIONAL = 127
NMT_WORDS = {4: "stopped", 5: "operational", 127: "pre-operational"}

_NO_OBJECT = 0x06020000
_NO_SUBINDEX = 0x06090011
_WRITE_ONLY = 0x06010001
_READ_ONLY = 0x06010002
_DEVICE_STATE = 0x08000022


class Aborted(GonioError):  # noqa: N818 - the standard's word
    """The drive refused an SDO transfer."""

    def __init__(self, node: int, index: int, subindex: int, code: int) -> None:
        words = SdoAbortedError.CODES.get(code, "a code of its maker")
        super().__init__(f"node {node}, {object_name(index, subindex)}: {words.lower()} (0x{code:08X})")
        self.code = code

    @property
    def absent(self) -> bool:
        """No such object or part."""
        return self.code in (_NO_OBJECT, _NO_SUBINDEX)

    @property
    def write_only(self) -> bool:
        """It cannot be read."""
        return self.code == _WRITE_ONLY

    @property
    def read_only(self) -> bool:
        """It cannot be written, or never in this state: a fixed PDO map answers with either."""
        return self.code in (_READ_ONLY, _DEVICE_STATE)


class Silent(InstrumentFault):
    """A node gave no answer in time."""


class FirmwareInCharge(UsageError):  # noqa: N818 - named for what it says
    """A goniod was heard: two masters on a bus move an axis that nobody watches."""

    def __init__(self) -> None:
        super().__init__(
            f"goniod is in charge of this bus (its heartbeat 0x{HEARTBEAT + FIRMWARE_NODE:03X} was heard): "
            "stop it first (systemctl stop goniod)"
        )


@dataclass
class Heard:
    """What nodes said by themselves since the bus was opened."""

    nmt_state: dict[int, int] = field(default_factory=dict)
    sdo_answers: dict[int, int] = field(default_factory=dict)


class DriveBus:
    """An open bus: SDO to any node, NMT, and what the nodes say."""

    def __init__(self, bus: Any, sdo_timeout_ms: int) -> None:
        self.bus = bus
        self.sdo_timeout_s = sdo_timeout_ms / 1000.0
        self.heard = Heard()
        self._clients: dict[int, Any] = {}
        self._boot_ups: dict[int, threading.Event] = {}
        self.network = canopen.Network(bus)
        self.network.NOTIFIER_CYCLE = NOTIFIER_CYCLE_S
        for node in NODES:
            self.network.subscribe(HEARTBEAT + node, self._on_heartbeat)
            self.network.subscribe(SDO_ANSWER + node, self._on_answer)
        self.network.connect()

    def _on_heartbeat(self, cob_id: int, data: bytearray, _time: float) -> None:
        if len(data) != 1:
            return
        node, state = cob_id - HEARTBEAT, data[0] & 0x7F
        self.heard.nmt_state[node] = state or PRE_OPERATIONAL  # a node goes there by itself after its boot-up
        if state == 0 and node in self._boot_ups:
            self._boot_ups[node].set()

    def _on_answer(self, cob_id: int, _data: bytearray, _time: float) -> None:
        node = cob_id - SDO_ANSWER
        self.heard.sdo_answers[node] = self.heard.sdo_answers.get(node, 0) + 1

    def listen(self, seconds: float) -> None:
        """Wait for heartbeats; ends early, with FirmwareInCharge, when the firmware's is among them."""
        end = threading.Event()
        self.network.subscribe(HEARTBEAT + FIRMWARE_NODE, lambda *_: end.set())
        end.wait(seconds)
        self.refuse_beside_firmware()

    def refuse_beside_firmware(self) -> None:
        """Raises FirmwareInCharge if a goniod has been heard since the bus was opened."""
        if FIRMWARE_NODE in self.heard.nmt_state:
            raise FirmwareInCharge

    def send(self, cob_id: int, data: bytes) -> None:
        """One frame. Raises InstrumentFault if the interface does not take it."""
        try:
            self.bus.send(can.Message(arbitration_id=cob_id, is_extended_id=False, data=data), timeout=SEND_PATIENCE_S)
        except (can.CanError, OSError) as error:
            raise InstrumentFault(f"the CAN interface does not send ({_one_line(error)}): {UNHEARD}") from error

    def nmt(self, command: int, node: int) -> None:
        """One NMT command to one node; never beside a firmware."""
        self.refuse_beside_firmware()
        self.send(0x000, bytes((command, node)))

    def reset(self, node: int, timeout_ms: int) -> None:
        """NMT reset of a node; waits for its boot-up message. Raises Silent."""
        self._boot_ups[node] = threading.Event()
        self.nmt(NMT_RESET_NODE, node)
        if not self._boot_ups[node].wait(timeout_ms / 1000.0):
            raise Silent(f"node {node}: no boot-up message within {timeout_ms} ms of its reset: check its power")

    def read(self, node: int, index: int, subindex: int = 0) -> bytes:
        """SDO upload. Raises Aborted or Silent."""
        return self._transfer(node, index, subindex, None, self.sdo_timeout_s)

    def read_int(self, node: int, index: int, subindex: int = 0, signed: bool = False) -> int:
        """SDO upload of a whole number."""
        return int.from_bytes(self.read(node, index, subindex), "little", signed=signed)

    def write(self, node: int, index: int, subindex: int, data: bytes, timeout_ms: int | None = None) -> None:
        """SDO download; never beside a firmware. Raises Aborted or Silent."""
        self.refuse_beside_firmware()
        self._transfer(node, index, subindex, data, self.sdo_timeout_s if timeout_ms is None else timeout_ms / 1000.0)

    def _transfer(self, node: int, index: int, subindex: int, data: bytes | None, timeout_s: float) -> bytes:
        client = self._clients.get(node)
        if client is None:
            client = SdoClient(SDO_REQUEST + node, SDO_ANSWER + node, canopen.ObjectDictionary())
            client.network = self.network
            self.network.subscribe(SDO_ANSWER + node, client.on_response)
            self._clients[node] = client
        client.RESPONSE_TIMEOUT = timeout_s
        where = f"node {node}, {object_name(index, subindex)}"
        try:
            if data is None:
                return bytes(client.upload(index, subindex))
            client.download(index, subindex, data)
        except SdoAbortedError as error:
            raise Aborted(node, index, subindex, error.code) from error
        except SdoError as error:
            if "No SDO response" not in str(error):
                text = f"{where}: an answer that does not belong to the question ({_one_line(error)})"
                raise Silent(f"{text}: two nodes with one id? see gonio drives list") from error
            waited_ms = round(1000 * timeout_s)
            raise Silent(f"{where}: no answer within {waited_ms} ms: check power, cable, node id, bit rate") from error
        except (can.CanError, OSError) as error:
            raise InstrumentFault(f"{where}: the CAN interface failed ({_one_line(error)}): {UNHEARD}") from error
        return b""

    @contextmanager
    def taken_over(self) -> Iterator[Any]:
        """The bare bus for a loop of its own; SDO and heartbeats rest meanwhile."""
        self.network.notifier.stop()
        try:
            yield self.bus
        finally:
            self.network.notifier = can.Notifier(self.bus, self.network.listeners, self.network.NOTIFIER_CYCLE)

    def close(self) -> None:
        """End of the session."""
        self.network.disconnect()


UNHEARD = "nobody acknowledges frames if no drive has power, the cable is open or the bit rate is wrong"


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def open_bus(
    interface: str, channel: str, bitrate: int | None, extra: Sequence[str], sdo_timeout_ms: int
) -> Iterator[DriveBus]:
    """A bus as python-can names it; `extra` are KEY=VALUE of its interface. Raises UsageError."""
    for name in ("can", "canopen"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what matters becomes an error of one line
    arguments: dict[str, Any] = {"interface": interface, "channel": channel, "receive_own_messages": True}
    arguments |= {} if bitrate is None else {"bitrate": bitrate}
    for pair in extra:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise UsageError(f"--bus-arg {pair}: KEY=VALUE expected")
        arguments[key] = int(value) if value.isdecimal() else value
    try:
        bus = can.Bus(**arguments)
    except Exception as error:  # every interface has errors of its own
        raise UsageError(
            f"--interface {interface} --channel {channel}: python-can cannot open it ({_one_line(error)}): "
            "check the names, that the interface is up, and your permission"
        ) from error
    drives = DriveBus(bus, sdo_timeout_ms)
    try:
        yield drives
    finally:
        drives.close()
