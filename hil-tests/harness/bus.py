"""bus.py: what candump, an independent program, wrote down of a bus."""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import can

_EMERGENCIES = range(0x081, 0x100)


@dataclass(frozen=True)
class Emergency:
    """An EMCY message; the time is the kernel's stamp, on the guest's wall clock."""

    time_s: float
    node: int
    code: int


def frames(log: Path) -> Iterator[can.Message]:
    """Every frame of a candump log; a last line that was cut is no frame."""
    whole_lines = "".join(log.read_text().rpartition("\n")[:2])
    for message in can.CanutilsLogReader(io.StringIO(whole_lines)):
        if not message.is_error_frame:
            yield message


def emergencies(log: Path, since_s: float, until_s: float) -> list[Emergency]:
    """The EMCY messages of this time, but for those that say that all is well again."""
    found = []
    for message in frames(log):
        identifier = message.arbitration_id
        if identifier in _EMERGENCIES and since_s <= message.timestamp <= until_s:
            code = int.from_bytes(message.data[:2], "little")
            if code:
                found.append(Emergency(message.timestamp, identifier - 0x80, code))
    return found
