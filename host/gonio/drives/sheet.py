"""sheet.py: an electronic data sheet (EDS, CiA 306), read by python-canopen, and what it says of the objects we use."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import canopen

from gonio.drives.findings import Finding, Grade
from gonio.drives.objects import TYPES, UsedObject
from gonio.units.errors import UsageError

MAPPED = {0x6040: "RPDO", 0x607A: "RPDO", 0x6041: "TPDO", 0x6064: "TPDO"}


@dataclass(frozen=True)
class Sheet:
    """One EDS for one node id."""

    path: Path
    dictionary: Any

    @staticmethod
    def read(path: Path, node: int) -> "Sheet":
        """Raises UsageError for a file that is none."""
        try:
            dictionary = canopen.import_od(str(path), node_id=node)
        except Exception as error:  # the parser's errors are of many kinds
            text = " ".join(str(error).split())
            raise UsageError(
                f"{path}: not an EDS that can be read ({text}): take the file of the drive's maker"
            ) from error
        if len(dictionary) == 0:
            raise UsageError(f"{path}: not an EDS (no objects in it): take the file of the drive's maker")
        return Sheet(path, dictionary)

    def variable(self, index: int, subindex: int) -> Any | None:
        """The entry of an object, or None."""
        entry = self.dictionary.get(index)
        if entry is None or isinstance(entry, canopen.objectdictionary.ODVariable):
            return entry if subindex == 0 else None
        return dict(entry.items()).get(subindex)  # entry[...] would invent members of an array


def check_sheet(sheet: Sheet, table: tuple[UsedObject, ...], values: dict[str, int], where: str) -> list[Finding]:
    """The EDS against the table: presence, type, access, range, mappability."""
    findings: list[Finding] = []

    def say(grade: Grade, used: UsedObject, sentence: str) -> None:
        findings.append(Finding(grade, where, used.name, f"{used.why}: {sentence}"))

    for used in table:
        variable = sheet.variable(used.index, used.subindex)
        if variable is None:
            if used.lacking:
                say(Grade.FALLBACK, used, f"not in its EDS; {used.lacking}")
            else:
                say(Grade.WRONG, used, "not in its EDS, and the firmware needs it: update the drive or choose another")
            continue
        if variable.data_type != TYPES[used.type][0]:
            say(Grade.WRONG, used, f"its EDS gives data type 0x{variable.data_type:04X}, not {used.type}")
        if used.use == "write" and not variable.writable:
            grade = Grade.FALLBACK if used.read_only else Grade.WRONG
            say(grade, used, f"read only by its EDS; {used.read_only or 'the firmware must write it'}")
        if used.use in ("read", "tpdo") and not variable.readable:
            say(Grade.WRONG, used, "write only by its EDS; the firmware must read it")
        if used.use in ("rpdo", "tpdo") and not variable.pdo_mappable:
            say(Grade.WRONG, used, f"cannot be mapped into a {MAPPED[used.index]} by its EDS")
        value = values.get(used.value)
        if used.use == "write" and variable.writable and value is not None:
            low, high = variable.min, variable.max
            if (low is not None and value < low) or (high is not None and value > high):
                bounds = f"{'any' if low is None else low} to {'any' if high is None else high}"
                setting = f": change {used.setting} in the instrument file" if used.setting else ""
                say(Grade.WRONG, used, f"{value} is to be written, its EDS allows {bounds}{setting}")
    return findings


def check_identity(sheet: Sheet, vendor: int | None, product: int | None, where: str) -> list[Finding]:
    """Whether the sheet is of this drive; a sheet may leave its numbers out."""
    info = sheet.dictionary.device_information
    findings = []
    for what, told, found in (("vendor", info.vendor_number, vendor), ("product", info.product_number, product)):
        if told is not None and found is not None and told != found:
            sentence = f"{what} 0x{found:08X}, {sheet.path.name} is of {what} 0x{told:08X}: take the drive's own EDS"
            findings.append(Finding(Grade.WRONG, where, "0x1018", sentence))
    return findings
