"""scripted_bus.py: a bus in simulated time for the load: echoes and TPDOs come when the script says, in one thread."""

import heapq
import itertools
from collections.abc import Callable

import can

PERIOD_US, WINDOW_US = 2000, 1500
NODES = (1, 2, 3, 4)
ECHO_US = 100.0
TPDO_US = {1: 300.0, 2: 420.0, 3: 540.0, 4: 660.0}  # after the SYNC was handed over
EPOCH_S = 1_700_000_000.0  # frames carry another clock than the schedule


class ScriptedBus:
    """Both the bus and the clock of a load. `reply(cycle, node)` gives the TPDO's delays in us, usually one."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.sent: list[can.Message] = []
        self.cycle = -1  # counted from the first SYNC
        self.reply: Callable[[int, int], list[float]] = lambda _cycle, node: [TPDO_US[node]]
        self.echo: Callable[[int], float | None] = lambda _cycle: ECHO_US
        self.extra: Callable[[int], list[tuple[float, can.Message]]] = lambda _cycle: []
        self.refuses_from = 10**9  # cycle
        self.state = can.BusState.ACTIVE
        self._queue: list[tuple[float, int, can.Message]] = []
        self._order = itertools.count()

    def now_s(self) -> float:
        return self.time_s

    def send(self, message: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002 - python-can's
        if message.arbitration_id == 0x080:
            self.cycle += 1
        if self.cycle >= self.refuses_from:
            raise can.CanOperationError("Transmit buffer full")
        self.sent.append(message)
        if message.arbitration_id == 0x080:
            echo = self.echo(self.cycle)
            if echo is not None:
                self._put(echo, frame(0x080, bytes(message.data)))
            for node in NODES:
                for delay in self.reply(self.cycle, node):
                    self._put(delay, frame(0x180 + node, bytes(6)))
            for delay, other in self.extra(self.cycle):
                self._put(delay, other)

    def recv(self, timeout: float) -> can.Message | None:
        until = self.time_s + timeout
        if self._queue and self._queue[0][0] <= until + 1e-12:
            at, _, message = heapq.heappop(self._queue)
            self.time_s = max(self.time_s, at)
            return message
        self.time_s = until
        return None

    def _put(self, delay_us: float, message: can.Message) -> None:
        at = self.time_s + 1e-6 * delay_us
        message.timestamp = EPOCH_S + at
        heapq.heappush(self._queue, (at, next(self._order), message))


def frame(cob_id: int, data: bytes) -> can.Message:
    return can.Message(arbitration_id=cob_id, is_extended_id=False, data=data)


def error_frame(bits: int, **data: int) -> can.Message:
    """As SocketCAN delivers it; data by position: d1=0x10."""
    content = bytearray(8)
    for key, value in data.items():
        content[int(key[1:])] = value
    return can.Message(arbitration_id=bits, is_extended_id=True, is_error_frame=True, data=content)
