"""scan.py: which nodes are on the bus and what they are."""

import threading
from dataclasses import dataclass

from gonio.drives.bus import NMT_WORDS, NODES, SDO_REQUEST, Aborted, DriveBus, Silent

CIA402_PROFILE = 402
READ_DEVICE_TYPE = bytes((0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0))
IDENTITY = ("vendor", "product", "revision", "serial")


@dataclass(frozen=True)
class FoundNode:
    """One node; None is what it does not tell."""

    node: int
    nmt_state: int | None
    device_type: int | None
    name: str | None
    identity: dict[str, int | None]
    problem: str = ""

    @property
    def is_drive(self) -> bool:
        """The profile in the lower half of 0x1000."""
        return self.device_type is not None and self.device_type & 0xFFFF == CIA402_PROFILE

    @property
    def state_words(self) -> str:
        """NMT state; only a heartbeat tells it."""
        if self.nmt_state is None:
            return "NMT state unknown (no heartbeat: 0x1017 is 0)"
        return NMT_WORDS.get(self.nmt_state, f"NMT state {self.nmt_state}")


def scan(bus: DriveBus) -> list[FoundNode]:
    """Every node that answers or was heard, in order of its id."""
    bus.heard.sdo_answers.clear()
    for node in NODES:
        bus.send(SDO_REQUEST + node, READ_DEVICE_TYPE)
    threading.Event().wait(bus.sdo_timeout_s)  # all have been asked: one time-out is enough for all
    answers = dict(bus.heard.sdo_answers)
    return [look_at(bus, node, answers.get(node, 0)) for node in sorted(set(answers) | set(bus.heard.nmt_state))]


def look_at(bus: DriveBus, node: int, answers: int = 1) -> FoundNode:
    """What one node says of itself; `answers` is how often it answered one question."""
    state = bus.heard.nmt_state.get(node)
    if answers == 0:
        return FoundNode(node, state, None, None, {}, "heartbeat only, no answer to SDO")
    problem = "" if answers == 1 else f"{answers} nodes answer under this id: give each its own"
    device_type = _number(bus, node, 0x1000, 0)
    identity = {name: _number(bus, node, 0x1018, k + 1) for k, name in enumerate(IDENTITY)}
    return FoundNode(node, state, device_type, _name(bus, node), identity, problem)


def _number(bus: DriveBus, node: int, index: int, subindex: int) -> int | None:
    try:
        return bus.read_int(node, index, subindex)
    except (Aborted, Silent):
        return None


def _name(bus: DriveBus, node: int) -> str | None:
    try:
        text = bus.read(node, 0x1008).decode("latin-1")
    except (Aborted, Silent):
        return None
    return "".join(c for c in text if c.isprintable()).strip()
