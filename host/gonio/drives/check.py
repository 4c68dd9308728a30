"""check.py: one drive against the table of objects that the firmware uses, its EDS and the instrument file."""

from dataclasses import dataclass
from fractions import Fraction

from gonio.drives.bus import Aborted, DriveBus, Silent
from gonio.drives.findings import Finding, Grade
from gonio.drives.objects import UsedObject, object_name
from gonio.drives.scan import look_at
from gonio.drives.sheet import Sheet, check_identity, check_sheet
from gonio.drives.values import same_period, values_of
from gonio.units.instrument import Axis, Instrument

PERIOD = 0x60C2
STORE = 0x1010
COUNTS_PER_S = (0x00B50300, 0x00000300)  # CiA 303-2: increments, or plain numbers, per second
DEADLINE = (0x1400, 5)
RPDO_MAP, TPDO_MAP = 0x1600, 0x1A00
MAP_NEEDS = {RPDO_MAP: (0x6040, 0x607A), TPDO_MAP: (0x6041, 0x6064)}


@dataclass(frozen=True)
class CheckedDrive:
    """An axis's drive and everything found."""

    axis: str
    node: int
    values: dict[str, int]  # "0x1017" -> what the drive holds; only what it gave
    findings: list[Finding]


def place(axis: Axis, node: int) -> str:
    """How a sentence names a drive."""
    return f"node {node} ({axis.name})"


def check_drive(
    bus: DriveBus, instrument: Instrument, axis: Axis, node: int, table: tuple[UsedObject, ...], sheet: Sheet | None
) -> CheckedDrive:
    """Read every object of the table once and judge it. Writes nothing."""
    where = place(axis, node)
    mine = tuple(used for used in table if used.only != "brake" or axis.brake)
    wanted = values_of(instrument.cycle, axis, node)
    findings: list[Finding] = []
    values: dict[str, int] = {}
    for used in mine:
        try:
            data = bus.read(node, used.index, used.subindex)
        except Silent as silent:
            findings.append(Finding(Grade.WRONG, where, used.name, str(silent)))
            return CheckedDrive(axis.name, node, values, findings)
        except Aborted as aborted:
            findings += _refused(used, aborted, where)
            continue
        if len(data) != used.bytes:
            sentence = f"{used.why}: {len(data)} bytes, {used.type} has {used.bytes}: the drive does not follow CiA 402"
            findings.append(Finding(Grade.WRONG, where, used.name, sentence))
            continue
        values[used.name] = int.from_bytes(data, "little", signed=used.signed)
    findings += _device(values, where)
    findings += _scale(axis, values, where)
    findings += _deadline(values, where)
    if sheet is None:
        text = "no EDS given (--eds FILE): access rights and ranges are not checked"
        findings.append(Finding(Grade.NOTE, where, "", text))
    else:
        seen = look_at(bus, node)
        findings += check_identity(sheet, seen.identity["vendor"], seen.identity["product"], where)
        held_back = {(finding.object, finding.grade) for finding in findings}
        findings += [f for f in check_sheet(sheet, mine, wanted, where) if (f.object, f.grade) not in held_back]
        findings += _read_only(bus, instrument, node, mine, sheet, values, wanted, where)
    findings += _storing(bus, node, where)
    return CheckedDrive(axis.name, node, values, findings)


def _refused(used: UsedObject, aborted: Aborted, where: str) -> list[Finding]:
    if used.use == "rpdo" and aborted.write_only:
        return []
    if aborted.absent and used.lacking:
        return [Finding(Grade.FALLBACK, where, used.name, f"{used.why}: the drive has none; {used.lacking}")]
    if aborted.absent:
        sentence = f"{used.why}: the drive has none, and the firmware needs it: update the drive or choose another"
        return [Finding(Grade.WRONG, where, used.name, sentence)]
    return [Finding(Grade.WRONG, where, used.name, f"{used.why}: the drive refuses to tell it: {aborted}")]


def _device(values: dict[str, int], where: str) -> list[Finding]:
    kind = values.get("0x1000")
    if kind is None or kind & 0xFFFF == 0x0192:
        return []
    return [Finding(Grade.WRONG, where, "0x1000", f"device type 0x{kind:08X} is no CiA 402 drive: check the node ids")]


def _deadline(values: dict[str, int], where: str) -> list[Finding]:
    guards = [name for name in ("0x1016:01", "0x6007") if name in values]
    if object_name(*DEADLINE) in values:
        return []
    rest = f"what is left is {' and '.join(guards)}" if guards else "no other guard is left either"
    sentence = f"without an RPDO deadline a drive runs on for a heartbeat time-out when set-points stop; {rest}"
    return [Finding(Grade.NOTE, where, object_name(*DEADLINE), sentence)]


def _scale(axis: Axis, values: dict[str, int], where: str) -> list[Finding]:
    """The firmware's rules (boot_units.c), and what only a person can know: a gear outside the drive."""
    findings: list[Finding] = []

    def say(grade: Grade, name: str, sentence: str) -> None:
        findings.append(Finding(grade, where, name, sentence))

    increments, turns = values.get("0x608F:01"), values.get("0x608F:02")
    if increments is not None and increments != axis.counts_per_turn:
        told = f"the instrument file counts_per_turn = {axis.counts_per_turn}: correct the one that is wrong"
        say(Grade.WRONG, "0x608F:01", f"the drive has {increments} encoder increments, {told}")
    if turns is not None and turns != 1:
        say(Grade.WRONG, "0x608F:02", f"its increments are for {turns} motor revolutions, the firmware expects 1")
    gear = _ratio(values, 0x6091) or Fraction(1)
    feed = _ratio(values, 0x6092)
    shaft = axis.counts_per_turn * gear
    per_axis_turn = abs(axis.counts_per_deg_ratio) * 360
    if feed is not None and feed != shaft:
        text = f"makes {_plain(feed)} units of a shaft revolution that has {_plain(shaft)} encoder counts"
        say(Grade.WRONG, "0x6092", f"feed: {text}: set it so that positions are encoder counts")
    elif shaft != per_axis_turn and gear != 1:
        text = f"{_plain(shaft)} counts per turn of the shaft, counts_per_deg makes {_plain(per_axis_turn)}"
        say(Grade.WRONG, "0x6091", f"gear: {text}: correct the one that is wrong")
    elif shaft != per_axis_turn:
        text = f"counts_per_deg says that {_plain(per_axis_turn / shaft)} turns of the shaft turn the axis once"
        say(Grade.NOTE, "0x6091", f"gear: the drive knows none, {text}: prove it by turning the axis by hand")
    unit = values.get("0x60A9")
    if unit is not None and unit not in COUNTS_PER_S:
        say(Grade.WRONG, "0x60A9", f"velocity unit 0x{unit:08X} is not counts per second: set 0x00B50300")
    text = "whether speeds (0x6099, 0x6081) agree with the slope of positions shows only when the axis moves"
    say(Grade.NOTE, "0x60A9", f"velocity unit: {text}: not proven here, motors stay off")
    return findings


def _ratio(values: dict[str, int], index: int) -> Fraction | None:
    top, bottom = values.get(object_name(index, 1)), values.get(object_name(index, 2))
    return Fraction(top, bottom) if top and bottom else None


def _plain(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else f"{float(value):.6g}"


def _read_only(
    bus: DriveBus,
    instrument: Instrument,
    node: int,
    table: tuple[UsedObject, ...],
    sheet: Sheet,
    values: dict[str, int],
    wanted: dict[str, int],
    where: str,
) -> list[Finding]:
    """What the EDS lets no one write must hold the value already, or be a map that the firmware can use."""
    findings: list[Finding] = []
    done: set[int] = set()
    for used in table:
        variable = sheet.variable(used.index, used.subindex)
        if used.use != "write" or variable is None or variable.writable or used.name not in values:
            continue
        if used.index in MAP_NEEDS and used.index not in done:
            done.add(used.index)
            findings += _fixed_map(bus, node, used.index, where)
        elif used.index == PERIOD and used.index not in done and f"0x{PERIOD:04X}:02" in values:
            done.add(used.index)
            units, exponent = values[f"0x{PERIOD:04X}:01"], values[f"0x{PERIOD:04X}:02"]
            if not same_period(units, exponent, instrument.cycle.sync_period_us):
                sentence = f"{units} * 10^{exponent} s and read only, sync_period_us is "
                sentence += f"{instrument.cycle.sync_period_us}: set it to the drive's period"
                findings.append(Finding(Grade.WRONG, where, used.name, sentence))
        elif used.index not in MAP_NEEDS and used.index != PERIOD and used.value in wanted:
            held = values[used.name]
            if used.index in (0x1400, 0x1800) and used.subindex == 1:
                held &= ~0x40000000  # no RTR: a drive may insist on this bit
            if held != wanted[used.value]:
                sentence = f"{used.why}: 0x{held:X} and read only, the firmware needs 0x{wanted[used.value]:X}"
                findings.append(Finding(Grade.WRONG, where, used.name, sentence))
    return findings


def read_map(bus: DriveBus, node: int, index: int) -> list[int]:
    """The mapped objects of a PDO as index, subindex, bits."""
    return [bus.read_int(node, index, k + 1) for k in range(bus.read_int(node, index, 0))]


def _fixed_map(bus: DriveBus, node: int, index: int, where: str) -> list[Finding]:
    entries = read_map(bus, node, index)
    has = {entry >> 16 for entry in entries}
    lacks = [object_name(need, 0) for need in MAP_NEEDS[index] if need not in has]
    whole = all(entry & 0xFF and (entry & 0xFF) % 8 == 0 for entry in entries)
    short = sum(entry & 0xFF for entry in entries) <= 64
    if not lacks and whole and short:
        return []
    problem = f"lacks {' and '.join(lacks)}" if lacks else "is not of whole bytes, 8 at most"
    sentence = f"its fixed map {problem}: change it with the maker's tool, or change the drive"
    return [Finding(Grade.WRONG, where, object_name(index, 0), sentence)]


def _storing(bus: DriveBus, node: int, where: str) -> list[Finding]:
    try:
        bus.read(node, STORE, 1)
    except (Aborted, Silent):
        sentence = "the drive cannot store settings (gonio drives store): the firmware writes them at every boot anyway"
        return [Finding(Grade.NOTE, where, object_name(STORE, 1), sentence)]
    return []
