"""objects.py: the table of the drive's objects that the firmware uses (protocol/objects.toml)."""

import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from gonio.units.errors import UsageError

# CiA 301: name -> (data type code, bytes, signed)
TYPES = {
    "INTEGER8": (0x0002, 1, True),
    "INTEGER16": (0x0003, 2, True),
    "INTEGER32": (0x0004, 4, True),
    "UNSIGNED8": (0x0005, 1, False),
    "UNSIGNED16": (0x0006, 2, False),
    "UNSIGNED32": (0x0007, 4, False),
}
USES = ("read", "write", "rpdo", "tpdo")


@dataclass(frozen=True)
class UsedObject:
    """One row of objects.toml; the words of the keys are explained there."""

    index: int
    subindex: int
    type: str
    use: str
    why: str
    lacking: str = ""
    read_only: str = ""
    only: str = ""
    value: str = ""
    setting: str = ""

    @property
    def name(self) -> str:
        """As in the firmware's sentences: 0x1017, or 0x1018:01 where the object has parts."""
        return object_name(self.index, self.subindex)

    @property
    def bytes(self) -> int:
        """Length of a value."""
        return TYPES[self.type][1]

    @property
    def signed(self) -> bool:
        """Whether a value may be negative."""
        return TYPES[self.type][2]


def object_name(index: int, subindex: int) -> str:
    """0x1017 or 0x1018:01."""
    return f"0x{index:04X}" + (f":{subindex:02X}" if subindex else "")


def table_path() -> Path:
    """The table: packaged beside this module, else protocol/objects.toml of the source tree. Raises UsageError."""
    here = Path(__file__).resolve()
    for candidate in (here.with_name("objects.toml"), here.parents[3] / "protocol" / "objects.toml"):
        if candidate.is_file():
            return candidate
    raise UsageError("the table of drive objects (protocol/objects.toml) is not installed: install gonio again")


def used_objects() -> tuple[UsedObject, ...]:
    """Every object that the firmware uses, in the order of its boot."""
    rows: list[dict[str, Any]] = tomllib.loads(table_path().read_text(encoding="utf-8"))["object"]
    known = {field.name for field in fields(UsedObject)}
    table = []
    for row in rows:
        if not set(row) <= known or row["type"] not in TYPES or row["use"] not in USES:
            raise UsageError(f"{table_path()}: wrong row {row}")
        table.append(UsedObject(**row))
    return tuple(table)
