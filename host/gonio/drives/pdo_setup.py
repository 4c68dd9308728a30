"""pdo_setup.py: gives a drive the PDOs of the real cycle for a while, and puts its own back."""

from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass

from gonio.drives.bus import Aborted, DriveBus, Silent
from gonio.drives.check import RPDO_MAP, TPDO_MAP
from gonio.drives.values import MAP_CONTROLWORD, MAP_POSITION, MAP_STATUSWORD, MAP_TARGET, SYNC_COUNTER_OVERFLOW
from gonio.units.errors import InstrumentFault, UsageError

RPDO, TPDO = 0x1400, 0x1800
PDO_OFF = 0x80000000
DEADLINE = 5
SYNC_COUNTER = 0x1019
NMT_START, NMT_PRE_OPERATIONAL = 0x01, 0x80
HAS_TORQUE = 0x04  # statusword: operation enabled, quick stop active, fault reaction active
CONTROLWORD_INDEX = MAP_CONTROLWORD >> 16
TARGET_INDEX = MAP_TARGET >> 16


@dataclass(frozen=True)
class _Part:
    """A PDO of the drive: as it was found, or as it is to be. The first `count` entries are mapped."""

    parameter: int
    mapping: int
    cob_id: int
    type: int
    entries: tuple[int, ...]
    count: int

    @property
    def map(self) -> tuple[int, ...]:
        """What is mapped."""
        return self.entries[: self.count]


@dataclass(frozen=True)
class ArmedDrive:
    """A drive that will answer SYNCs; `rpdo` is what it is sent: controlword 0, the position that it has."""

    node: int
    rpdo: bytes
    tpdo_bytes: int


class PdoSetup:
    """Takes one drive's PDO parameters over and puts them back."""

    def __init__(self, bus: DriveBus, node: int) -> None:
        self.bus = bus
        self.node = node
        self._undo: list[Callable[[], None]] = []

    def refuse_torque(self) -> None:
        """Raises UsageError for a drive whose motor is on: controlword 0 would let its axis drop."""
        status = self.bus.read_int(self.node, 0x6041)
        if status & HAS_TORQUE:
            raise UsageError(
                f"node {self.node}: 0x6041 (statusword) 0x{status:04X}: its motor has torque; "
                "release it before the load"
            )

    def arm(self) -> ArmedDrive:
        """Set the cycle's PDOs. Raises InstrumentFault, the drive then as before."""
        self.bus.nmt(NMT_PRE_OPERATIONAL, self.node)
        try:
            self._optional(SYNC_COUNTER, 0, SYNC_COUNTER_OVERFLOW, 1)
            # This host is not the real-time firmware: an armed deadline would find the host's delays, not the bus's.
            self._optional(RPDO, DEADLINE, 0, 2)
            rpdo = self._take(RPDO, RPDO_MAP, 0x200, (MAP_CONTROLWORD, MAP_TARGET))
            tpdo = self._take(TPDO, TPDO_MAP, 0x180, (MAP_STATUSWORD, MAP_POSITION))
            data = b"".join(self._content(entry) for entry in rpdo)
        except Aborted as aborted:
            self.restore()
            raise InstrumentFault(f"{aborted}: the drive does not take the cycle's PDOs") from aborted
        except BaseException:
            self.restore()
            raise
        return ArmedDrive(self.node, data, sum(entry & 0xFF for entry in tpdo) // 8)

    def restore(self) -> list[str]:
        """Pre-operational, and everything as it was found; sentences about what could not be put back."""
        problems = []
        self.bus.nmt(NMT_PRE_OPERATIONAL, self.node)
        while self._undo:
            try:
                self._undo.pop()()
            except (Aborted, Silent) as error:
                problems.append(f"not put back: {error}; power the drive off and on")
        return problems

    def _write(self, index: int, subindex: int, value: int, size: int) -> None:
        self.bus.write(self.node, index, subindex, value.to_bytes(size, "little"))

    def _optional(self, index: int, subindex: int, value: int, size: int) -> None:
        """Write an object that a drive may lack."""
        with suppress(Aborted):
            found = self.bus.read_int(self.node, index, subindex)
            if found != value:
                self._write(index, subindex, value, size)
                self._undo.append(lambda: self._write(index, subindex, found, size))

    def _take(self, parameter: int, mapping: int, base: int, wanted: tuple[int, ...]) -> tuple[int, ...]:
        count = self.bus.read_int(self.node, mapping, 0)
        found = _Part(
            parameter,
            mapping,
            self.bus.read_int(self.node, parameter, 1),
            self.bus.read_int(self.node, parameter, 2),
            self._entries(mapping, max(count, len(wanted))),
            count,
        )
        self._undo.append(lambda: self._set(found))
        fixed = False
        try:
            self._set(_Part(parameter, mapping, base + self.node, 1, wanted, len(wanted)))
        except Aborted as aborted:
            if not aborted.read_only:
                raise
            fixed = True
        if fixed:  # the map stays; the rest may already be right
            self._set(_Part(parameter, mapping, base + self.node, 1, found.entries, count))
        return found.map if fixed else wanted

    def _entries(self, mapping: int, most: int) -> tuple[int, ...]:
        """The map's members, mapped or not; a fixed map may have no more than it maps."""
        entries: list[int] = []
        with suppress(Aborted):
            for k in range(most):
                entries.append(self.bus.read_int(self.node, mapping, k + 1))
        return tuple(entries)

    def _set(self, part: _Part) -> None:
        """CiA 301's order: PDO off, map empty, members, their number, type, PDO on. Writes only what differs."""
        held = self.bus.read_int(self.node, part.parameter, 1)
        same_type = self.bus.read_int(self.node, part.parameter, 2) == part.type
        same_map = self.bus.read_int(self.node, part.mapping, 0) == part.count
        same_map = same_map and self._entries(part.mapping, len(part.entries)) == part.entries
        if same_map and same_type and held == part.cob_id:
            return
        if not held & PDO_OFF:
            with suppress(Aborted):  # a drive may not let it be switched off; its map then decides
                self._write(part.parameter, 1, held | PDO_OFF, 4)
        if not same_map:
            self._write(part.mapping, 0, 0, 1)
            for k, entry in enumerate(part.entries):
                with suppress(Aborted) if k >= part.count else nullcontext():  # a drive may refuse to hold a 0
                    self._write(part.mapping, k + 1, entry, 4)
            self._write(part.mapping, 0, part.count, 1)
        if not same_type:
            self._write(part.parameter, 2, part.type, 1)
        if self.bus.read_int(self.node, part.parameter, 1) != part.cob_id:
            self._write(part.parameter, 1, part.cob_id, 4)

    def _content(self, entry: int) -> bytes:
        index, subindex, size = entry >> 16, entry >> 8 & 0xFF, (entry & 0xFF) // 8
        if index == CONTROLWORD_INDEX:
            return bytes(size)  # disable voltage: the load never enables a motor
        source = MAP_POSITION >> 16 if index == TARGET_INDEX else index
        return self.bus.read(self.node, source, subindex)[:size].ljust(size, b"\0")
