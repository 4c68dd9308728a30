"""virtual_drives.py: drives made of python-canopen's own nodes and our EDS files, on python-can's virtual bus.

Nothing of our firmware or twin is in them. Their faults are scripted: set an attribute before the command runs.
"""

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import can
import canopen
from canopen.objectdictionary import ODRecord, ODVariable
from canopen.sdo import SdoAbortedError

EDS_DIRECTORY = Path(__file__).parents[3] / "protocol" / "eds"
REFERENCE = Path(__file__).parents[3] / "protocol" / "axes.toml"
_channels = itertools.count()


def eds(personality: str) -> Path:
    return EDS_DIRECTORY / f"gonio_{personality}.eds"


def unsigned32(index: int, subindex: int, value: int) -> ODVariable:
    variable = ODVariable("added", index, subindex)
    variable.data_type = canopen.objectdictionary.datatypes.UNSIGNED32
    variable.access_type, variable.default = "rw", value
    return variable


class VirtualDrive(canopen.LocalNode):
    """A drive that answers SDO by its EDS, SYNCs with TPDO 1, and keeps over a reset what was saved."""

    def __init__(self, node: int, personality: str, without: Sequence[int | tuple[int, int]] = (), stores: bool = True):
        super().__init__(node, str(eds(personality)))
        self.statusword, self.position = 0x0040, 1000 * node
        self.aborts: dict[tuple[int, int], int] = {}  # of reads
        self.write_aborts: dict[tuple[int, int], int] = {}
        self.clamp: dict[tuple[int, int], bytes] = {}  # what it takes instead
        self.keeps_saved = True
        self.writes: list[tuple[int, int, bytes]] = []
        self.rpdos: list[bytes] = []
        self.saved: dict[int, dict[int, bytes]] = {}
        self.add_read_callback(self._live)
        for what in without:
            if isinstance(what, int):
                del self.object_dictionary.indices[what]
            else:
                del self.object_dictionary[what[0]].subindices[what[1]]
        if stores:
            record = ODRecord("Store parameters", 0x1010)
            record.add_member(unsigned32(0x1010, 0, 1))
            record.add_member(unsigned32(0x1010, 1, 1))
            self.object_dictionary.add_object(record)

    def define(self, index: int, value: int) -> None:
        """One more object, or another value of one that is there."""
        self.object_dictionary.add_object(unsigned32(index, 0, value))

    def _live(self, index: int, subindex: int, od: Any) -> int | None:  # noqa: ARG002 - canopen's names
        if (index, subindex) in self.aborts:
            raise SdoAbortedError(self.aborts[index, subindex])
        return {0x6041: self.statusword, 0x6064: self.position}.get(index)

    def _find_object(self, index: int, subindex: int) -> Any:
        entry = self.object_dictionary.get(index)
        if entry is not None and hasattr(entry, "subindices") and subindex not in entry.subindices:
            raise SdoAbortedError(0x06090011)  # canopen would invent members of an array
        return super()._find_object(index, subindex)

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        if (index, subindex) in self.write_aborts:
            raise SdoAbortedError(self.write_aborts[index, subindex])
        self.writes.append((index, subindex, bytes(data)))
        if index == 0x1010:
            assert bytes(data) == b"save"
            self.saved = {i: dict(parts) for i, parts in self.data_store.items()} if self.keeps_saved else {}
            return
        super().set_data(index, subindex, self.clamp.get((index, subindex), data), check_writable)

    def attach(self, network: canopen.Network) -> None:
        network.add_node(self)
        network.subscribe(0x000, self._on_nmt)
        network.subscribe(0x080, self._on_sync)
        network.subscribe(0x200 + self.id, lambda _id, data, _time: self.rpdos.append(bytes(data)))

    def _on_nmt(self, _cob_id: int, data: bytearray, _time: float) -> None:
        if data[1] in (0, self.id) and data[0] in (0x81, 0x82):
            self.data_store = {i: dict(parts) for i, parts in self.saved.items()}
            self.nmt._state = 127
            self.network.send_message(0x700 + self.id, b"\0")

    def _on_sync(self, _cob_id: int, _data: bytearray, _time: float) -> None:
        if self.nmt.state == "OPERATIONAL":
            entries = [self.number(0x1A00, k + 1) for k in range(self.number(0x1A00, 0))]
            data = b"".join(self.get_data(e >> 16, e >> 8 & 0xFF)[: (e & 0xFF) // 8] for e in entries)
            self.network.send_message(self.number(0x1800, 1) & 0x7FF, data)

    def number(self, index: int, subindex: int) -> int:
        return int.from_bytes(self.get_data(index, subindex), "little")

    def all_values(self) -> dict[tuple[int, int], bytes]:
        """What every object holds, as an SDO client would see it."""
        values = {}
        for index, entry in self.object_dictionary.items():
            members = [0] if isinstance(entry, ODVariable) else list(entry)
            if index >= 0x1000:
                values |= {(index, sub): self.get_data(index, sub) for sub in members}
        return values


class VirtualBench:
    """A bus with drives; `arguments` lead the command line to it."""

    def __init__(self) -> None:
        self.channel = f"bench-{next(_channels)}"
        self.networks: list[canopen.Network] = []
        self.monitor = can.Bus(interface="virtual", channel=self.channel)

    @property
    def arguments(self) -> list[str]:
        return ["--interface", "virtual", "--channel", self.channel]

    def network(self) -> canopen.Network:
        network = canopen.Network()
        network.NOTIFIER_CYCLE = 0.02
        network.connect(interface="virtual", channel=self.channel)
        self.networks.append(network)
        return network

    def add(self, *drives: VirtualDrive) -> None:
        network = self.network()
        for drive in drives:
            drive.attach(network)

    def frames(self) -> list[can.Message]:
        """Everything that was on the bus so far."""
        return list(iter(lambda: self.monitor.recv(timeout=0), None))

    def close(self) -> None:
        for network in self.networks:
            for node in network.values():
                node.nmt.stop_heartbeat()
            network.disconnect()
        self.monitor.shutdown()


def instrument_text(edit: Callable[[str], str] = lambda text: text) -> str:
    """The reference instrument with patience for a busy machine and short heartbeats."""
    text = REFERENCE.read_text(encoding="utf-8")
    for key, value in (
        ("firmware_heartbeat_ms = 100", "firmware_heartbeat_ms = 10"),
        ("drive_heartbeat_ms = 100", "drive_heartbeat_ms = 10"),
        ("sdo_timeout_ms = 200", "sdo_timeout_ms = 5000"),
        ("boot_timeout_ms = 2000", "boot_timeout_ms = 10000"),
    ):
        assert key in text
        text = text.replace(key, value)
    return edit(text)
