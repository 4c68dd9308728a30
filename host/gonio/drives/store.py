"""store.py: writes the instrument file's settings into a drive, verifies them, stores them and verifies them again."""

from dataclasses import dataclass

from gonio.drives.bus import Aborted, DriveBus
from gonio.drives.check import place
from gonio.drives.findings import Finding, Grade
from gonio.drives.objects import UsedObject, object_name
from gonio.drives.pdo_setup import HAS_TORQUE, NMT_PRE_OPERATIONAL
from gonio.drives.values import values_of
from gonio.units.errors import InstrumentFault, UsageError
from gonio.units.instrument import Axis, Instrument

STORE = (0x1010, 1)
SAVE = b"save"
ON_COMMAND = 0x1  # 0x1010:01


@dataclass(frozen=True)
class Setting:
    """One object: what the drive holds, what the instrument file says."""

    used: UsedObject
    old: int
    new: int

    @property
    def changes(self) -> bool:
        """Whether the drive is to be written."""
        return self.old != self.new


@dataclass(frozen=True)
class StorePlan:
    """What would be written into one drive."""

    axis: str
    node: int
    settings: list[Setting]
    findings: list[Finding]


def plan_store(
    bus: DriveBus, instrument: Instrument, axis: Axis, node: int, table: tuple[UsedObject, ...]
) -> StorePlan:
    """Reads; writes nothing. Raises UsageError for a drive with torque, Silent for one that does not answer."""
    where = place(axis, node)
    status = bus.read_int(node, 0x6041)
    if status & HAS_TORQUE:
        text = f"{where}: 0x6041 (statusword) 0x{status:04X}: its motor has torque; release it before storing"
        raise UsageError(text)
    values = values_of(instrument.cycle, axis, node)
    settings, findings = [], []
    for used in table:
        if not used.setting or (used.only == "brake" and not axis.brake):
            continue
        try:
            old = bus.read_int(node, used.index, used.subindex, used.signed)
        except Aborted as aborted:
            grade = Grade.FALLBACK if aborted.absent and used.lacking else Grade.WRONG
            findings.append(Finding(grade, where, used.name, f"{used.why}: left out: {aborted}"))
            continue
        settings.append(Setting(used, old, values[used.value]))
    try:
        can_store = bool(bus.read_int(node, *STORE) & ON_COMMAND)
    except Aborted:
        can_store = False
    if not can_store:
        sentence = "the drive does not store on command: nothing is written; the firmware writes these at every boot"
        findings.append(Finding(Grade.WRONG, where, object_name(*STORE), sentence))
    return StorePlan(axis.name, node, settings if can_store else [], findings)


def carry_out(bus: DriveBus, instrument: Instrument, plan: StorePlan) -> None:
    """Write, read back, save, reset, read back again. Raises InstrumentFault; what was written is then put back."""
    node = plan.node
    bus.nmt(NMT_PRE_OPERATIONAL, node)
    written: list[Setting] = []
    try:
        for setting in plan.settings:
            if setting.changes:
                written.append(setting)
                _write(bus, node, setting, setting.new)
        _verify(bus, plan, "reads back")
        bus.write(node, *STORE, SAVE, timeout_ms=instrument.cycle.boot_timeout_ms)  # flash takes its time
    except (Aborted, InstrumentFault) as error:
        lost = _put_back(bus, node, written)
        rest = f"not put back: {', '.join(lost)}" if lost else "the drive's values were put back"
        raise InstrumentFault(f"{error}; nothing was stored, {rest}") from error
    bus.reset(node, instrument.cycle.boot_timeout_ms)
    _verify(bus, plan, "after its reset holds")


def _put_back(bus: DriveBus, node: int, written: list[Setting]) -> list[str]:
    lost = []
    for setting in reversed(written):
        try:
            if bus.read_int(node, setting.used.index, setting.used.subindex, setting.used.signed) != setting.old:
                _write(bus, node, setting, setting.old)
        except (Aborted, InstrumentFault):
            lost.append(setting.used.name)
    return lost


def _write(bus: DriveBus, node: int, setting: Setting, value: int) -> None:
    data = value.to_bytes(setting.used.bytes, "little", signed=setting.used.signed)
    bus.write(node, setting.used.index, setting.used.subindex, data)


def _verify(bus: DriveBus, plan: StorePlan, words: str) -> None:
    for setting in plan.settings:
        used = setting.used
        found = bus.read_int(plan.node, used.index, used.subindex, used.signed)
        if found != setting.new:
            where = f"node {plan.node} ({plan.axis}), {used.name} ({used.why})"
            raise InstrumentFault(f"{where}: is to be {setting.new} and {words} {found}: check the drive's own limits")
