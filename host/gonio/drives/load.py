"""load.py: the cycle's PDO schedule on the bus with motors off: SYNC with counter, an RPDO and a TPDO per drive."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import can

from gonio.drives.bus import HEARTBEAT, FirmwareInCharge
from gonio.drives.error_frames import ErrorTally
from gonio.drives.pdo_setup import ArmedDrive
from gonio.drives.values import FIRMWARE_NODE, SYNC_COUNTER_OVERFLOW

SYNC = 0x080
RPDO1, TPDO1 = 0x200, 0x180


class Clock(Protocol):
    """Where the load gets its time from; the frames carry their own."""

    def now_s(self) -> float:
        """Seconds, monotonic."""


class HostClock:
    """The host's."""

    def now_s(self) -> float:
        """Seconds since some moment."""
        return time.monotonic()


@dataclass
class NodeRecord:
    """What became of one drive's TPDOs."""

    node: int
    received: int = 0
    lost: int = 0
    late: int = 0  # beyond 0x1007 after the SYNC's echo
    duplicate: int = 0
    emergencies: list[int] = field(default_factory=list)  # error codes, without the resets
    boot_ups: int = 0
    delays_us: list[float] = field(default_factory=list)  # TPDO after the SYNC's echo


@dataclass
class LoadRecord:
    """What became of the whole schedule."""

    period_us: int
    window_us: int
    nodes: dict[int, NodeRecord]
    syncs: int = 0
    skipped: int = 0  # cycles that the host missed
    sends_failed: int = 0
    echoes_lost: int = 0
    echoes_seen: int = 0
    echo_errors_us: list[float] = field(default_factory=list)  # interval of two echoes, less the period
    lost_together: int = 0  # cycles in which every drive's TPDO was lost
    foreign_syncs: int = 0
    errors: ErrorTally = field(default_factory=ErrorTally)
    bus_state: str | None = None  # as python-can tells it


@dataclass
class _Cycle:
    counter: int
    echo_s: float | None = None
    seen: set[int] = field(default_factory=set)
    late: set[int] = field(default_factory=set)


class Load:
    """Runs the schedule; one thread, one loop, as the firmware does it."""

    def __init__(self, bus: Any, clock: Clock, drives: Sequence[ArmedDrive], period_us: int, window_us: int) -> None:
        self.bus = bus
        self.clock = clock
        self.drives = drives
        self.record = LoadRecord(period_us, window_us, {drive.node: NodeRecord(drive.node) for drive in drives})
        self._cycle: _Cycle | None = None
        self._last_echo: tuple[int, float] | None = None  # number of the SYNC, stamp

    def run(self, seconds: float, start_s: float) -> LoadRecord:
        """The schedule for this long, counted from when every drive has sent a TPDO, at the latest after `start_s`.

        Raises FirmwareInCharge if a firmware appears on the bus.
        """
        period_s = self.record.period_us * 1e-6
        self._cycles(max(1, round(start_s / period_s)), until_all_answer=True)
        self.record = LoadRecord(
            self.record.period_us, self.record.window_us, {node: NodeRecord(node) for node in self.record.nodes}
        )
        self._last_echo = None
        self._cycles(max(1, round(seconds / period_s)), until_all_answer=False)
        try:
            self.record.bus_state = self.bus.state.name.lower()
        except (NotImplementedError, AttributeError):
            self.record.bus_state = None
        return self.record

    def _cycles(self, count: int, until_all_answer: bool) -> None:
        period_s = self.record.period_us * 1e-6
        begin_s = self.clock.now_s()
        number = 0
        while number < count:
            self._receive_until(begin_s + number * period_s)
            if until_all_answer and all(node.received for node in self.record.nodes.values()):
                break
            behind = int((self.clock.now_s() - begin_s) / period_s) - number
            if behind > 0:
                skip = min(behind, count - 1 - number)
                self.record.skipped += skip
                number += skip
            self._close()
            self._begin(number)
            number += 1
        self._receive_until(begin_s + number * period_s)
        self._close()

    def _receive_until(self, due_s: float) -> None:
        while True:
            left_s = due_s - self.clock.now_s()
            message = self.bus.recv(timeout=max(0.0, left_s))
            if message is not None:
                self._take(message)
            elif left_s <= 0:
                return

    def _begin(self, number: int) -> None:
        counter = number % SYNC_COUNTER_OVERFLOW + 1
        self._cycle = _Cycle(counter)
        self._number = number
        self.record.syncs += 1
        self._send(SYNC, bytes((counter,)))
        for drive in self.drives:
            self._send(RPDO1 + drive.node, drive.rpdo)

    def _send(self, cob_id: int, data: bytes) -> None:
        try:
            self.bus.send(can.Message(arbitration_id=cob_id, is_extended_id=False, data=data))
        except (can.CanError, OSError):
            self.record.sends_failed += 1

    def _take(self, message: Any) -> None:
        if message.is_error_frame:
            self.record.errors.add(message)
            return
        if message.is_extended_id or message.is_remote_frame:
            return
        function, node = message.arbitration_id & 0x780, message.arbitration_id & 0x7F
        if message.arbitration_id == SYNC:
            self._on_sync(message)
        elif message.arbitration_id == HEARTBEAT + FIRMWARE_NODE:
            raise FirmwareInCharge
        elif node in self.record.nodes:
            if function == TPDO1:
                self._on_tpdo(node, message.timestamp)
            elif function == SYNC and len(message.data) >= 2:
                code = int.from_bytes(message.data[:2], "little")
                self.record.nodes[node].emergencies += [code] if code else []
            elif function == HEARTBEAT and message.data[:1] == b"\0":
                self.record.nodes[node].boot_ups += 1

    def _on_sync(self, message: Any) -> None:
        cycle = self._cycle
        mine = cycle is not None and len(message.data) == 1 and message.data[0] == cycle.counter
        if cycle is None or not mine or cycle.echo_s is not None:
            self.record.foreign_syncs += 1
            return
        cycle.echo_s = message.timestamp
        self.record.echoes_seen += 1
        if self._last_echo is not None:
            periods = self._number - self._last_echo[0]
            interval_us = 1e6 * (message.timestamp - self._last_echo[1])
            self.record.echo_errors_us.append(interval_us - periods * self.record.period_us)
        self._last_echo = (self._number, message.timestamp)

    def _on_tpdo(self, node: int, stamp_s: float) -> None:
        """The firmware's rules (sync.c); without echoes from the interface lateness cannot be judged."""
        cycle, record = self._cycle, self.record.nodes[node]
        if cycle is None:
            return
        if node in cycle.seen or node in cycle.late:
            record.duplicate += 1
            return
        record.received += 1
        if cycle.echo_s is not None:
            delay_us = 1e6 * (stamp_s - cycle.echo_s)
            record.delays_us.append(delay_us)
            if delay_us > self.record.window_us:
                cycle.late.add(node)
                record.late += 1
                return
        cycle.seen.add(node)

    def _close(self) -> None:
        cycle, self._cycle = self._cycle, None
        if cycle is None:
            return
        self.record.echoes_lost += cycle.echo_s is None
        lost = [node for node in self.record.nodes if node not in cycle.seen and node not in cycle.late]
        for node in lost:
            self.record.nodes[node].lost += 1
        self.record.lost_together += len(lost) == len(self.record.nodes) > 0
