"""error_frames.py: what a CAN controller reports in SocketCAN's error frames (linux/can/error.h), tallied."""

from dataclasses import dataclass
from typing import Any

ARBITRATION, CONTROLLER, PROTOCOL, TRANSCEIVER, NO_ACK = 0x002, 0x004, 0x008, 0x010, 0x020
BUS_OFF, BUS_ERROR, RESTARTED, COUNTERS = 0x040, 0x080, 0x100, 0x200
RX_OVERFLOW, TX_OVERFLOW = 0x01, 0x02  # data[1] of CONTROLLER
WARNING, PASSIVE = 0x0C, 0x30
STATES = ("error active", "error warning", "error passive", "bus off")


@dataclass
class ErrorTally:
    """Counts by kind, the worst state, and the last error counters if the controller tells them."""

    frames: int = 0
    no_acknowledge: int = 0
    protocol: int = 0  # bit, stuff, form and CRC errors
    overflows: int = 0
    restarts: int = 0
    worst_state: int = 0
    counters: tuple[int, int] | None = None  # transmit, receive
    unexplained: int = 0  # the interface says no more than that there was one

    def add(self, message: Any) -> None:
        """One error frame."""
        bits, data = message.arbitration_id, bytes(message.data).ljust(8, b"\0")
        self.frames += 1
        self.no_acknowledge += bool(bits & NO_ACK)
        self.protocol += bool(bits & PROTOCOL)
        self.restarts += bool(bits & RESTARTED)
        if bits & BUS_OFF:
            self.worst_state = 3
        if bits & CONTROLLER:
            self.overflows += bool(data[1] & (RX_OVERFLOW | TX_OVERFLOW))
            self.worst_state = max(self.worst_state, 2 if data[1] & PASSIVE else 1 if data[1] & WARNING else 0)
        if bits & COUNTERS:
            self.counters = (data[6], data[7])
        if not bits & (ARBITRATION | CONTROLLER | PROTOCOL | TRANSCEIVER | NO_ACK | BUS_OFF | BUS_ERROR | RESTARTED):
            self.unexplained += 1

    @property
    def state_words(self) -> str:
        """The worst state that was reported."""
        return STATES[self.worst_state]
