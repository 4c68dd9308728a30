"""instrument.py: the instrument file (axes, cycle, zones, channels) as dataclasses; see protocol/axes.toml."""

import tomllib
from collections.abc import Callable
from dataclasses import MISSING, asdict, dataclass, fields, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

from gonio.units.calibration import Calibration
from gonio.units.errors import UsageError

MAX_AXES = 4  # positions in a pose record
_T = TypeVar("_T")


@dataclass(frozen=True)
class Homing:
    """How an axis finds its zero: CiA 402 homing method and speeds; `switch_deg` is the reading at the switch."""

    method: int  # 0x6098
    fast_deg_per_s: float
    slow_deg_per_s: float
    acceleration_deg_per_s2: float
    switch_deg: float
    order: int  # axes of equal order home together, lowest first


@dataclass(frozen=True)
class Axis:
    """One turning axis. `vector` is in the lab frame when every reading is zero; `carries` is what turns with it."""

    name: str
    carries: str  # "sample" or "detector"
    vector: tuple[float, float, float]
    driven: bool
    node: int
    counts_per_turn: int
    counts_per_deg_ratio: Fraction  # signed
    min_deg: float
    max_deg: float
    max_velocity_deg_per_s: float
    max_acceleration_deg_per_s2: float
    cable_wrap_deg: float
    encoder: bool
    brake: bool
    gravity: bool
    following_error_deg: float
    following_error_timeout_ms: int
    quick_stop_deg_per_s2: float
    latch_delay_us: float
    latch_delay_u_us: float
    homing: Homing

    @property
    def counts_per_deg(self) -> float:
        """Signed encoder counts per degree of the axis reading."""
        return float(self.counts_per_deg_ratio)


@dataclass(frozen=True)
class HalfSpace:
    """The readings q with a . q_deg <= b."""

    a: tuple[float, ...]
    b: float


@dataclass(frozen=True)
class Zone:
    """A convex forbidden region: inside where every half-space holds."""

    name: str
    half_spaces: tuple[HalfSpace, ...]


@dataclass(frozen=True)
class Channel:
    """Calibration of a detector channel: the value belongs to the light `delay_us` before its strobe time."""

    name: str
    delay_us: float
    delay_u_us: float
    gain: float  # counts per unit signal, relative to the low channel
    gain_u_rel: float
    full_scale_counts: int


@dataclass(frozen=True)
class Cycle:
    """Periods and time-outs of the control cycle and of the digitiser; reasons stand beside the values in axes.toml."""

    sync_period_us: int
    sync_window_us: int
    firmware_heartbeat_ms: int
    drive_heartbeat_ms: int
    heartbeat_timeout_ms: int
    rpdo_deadline_syncs: int
    sdo_timeout_ms: int
    boot_timeout_ms: int
    expiry_ms: int
    sample_period_us: int
    samples_per_strobe: int
    clock_settle_ms: int
    edge_tolerance_percent: int


@dataclass(frozen=True)
class Instrument:
    """A whole instrument file; `text` is the file as it was read and goes into the raw log."""

    name: str
    arm_radius_mm: float
    detector_aperture_mm: float
    head_diameter_mm: float
    cycle: Cycle
    axes: tuple[Axis, ...]
    zones: tuple[Zone, ...]
    channels: tuple[Channel, ...]
    calibration: Calibration
    text: str


def reference_instrument_path() -> Path:
    """The reference instrument's file: packaged beside this module, else protocol/axes.toml of the source tree.

    Raises UsageError when neither is there.
    """
    here = Path(__file__).resolve()
    for candidate in (here.with_name("axes.toml"), here.parents[3] / "protocol" / "axes.toml"):
        if candidate.is_file():
            return candidate
    raise UsageError("the reference instrument (protocol/axes.toml) is not installed: name a file with --instrument")


def load_instrument(path: Path | None) -> Instrument:
    """Read an instrument file; None is the reference instrument.

    Raises UsageError, naming file and key, for an unreadable file or an unknown, missing or wrong value.
    """
    source = reference_instrument_path() if path is None else path
    try:
        text = source.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{source}: cannot read the instrument file ({error}): check the name") from error
    return parse_instrument(text, str(source))


def parse_instrument(text: str, source: str) -> Instrument:
    """Parse the text of an instrument file; `source` names it in errors. Raises UsageError."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{source}: not TOML ({error})") from error
    reader = _Reader(source)
    known = {"instrument", "cycle", "axis", "zone", "channel", "calibration"}
    for key in document:
        if key not in known:
            raise reader.error(key, f"is unknown; known are {', '.join(sorted(known))}")
    head = reader.table(document, "instrument")
    reader.only(head, "instrument", {"name", "arm_radius_mm", "detector_aperture_mm", "head_diameter_mm"})
    axes = tuple(_axis(reader, row, f"axis[{i}]") for i, row in enumerate(reader.rows(document, "axis")))
    if not 1 <= len(axes) <= MAX_AXES:
        raise reader.error("axis", f"has {len(axes)} entries: 1 to {MAX_AXES} are possible")
    return Instrument(
        name=reader.value(head, "instrument", "name", str),
        arm_radius_mm=reader.value(head, "instrument", "arm_radius_mm", float),
        detector_aperture_mm=reader.value(head, "instrument", "detector_aperture_mm", float),
        head_diameter_mm=reader.value(head, "instrument", "head_diameter_mm", float),
        cycle=reader.build(Cycle, reader.table(document, "cycle"), "cycle"),
        axes=axes,
        zones=tuple(_zone(reader, row, f"zone[{i}]", len(axes)) for i, row in enumerate(reader.rows(document, "zone"))),
        channels=tuple(
            reader.build(Channel, row, f"channel[{i}]") for i, row in enumerate(reader.rows(document, "channel"))
        ),
        calibration=_calibration(reader, document.get("calibration", {})),
        text=text,
    )


def override_calibration(instrument: Instrument, text: str, source: str) -> Instrument:
    """The instrument with what the TOML `text` says in its one table [calibration]; other values stay as they are.
    Raises UsageError, naming `source` and key."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{source}: not TOML ({error})") from error
    reader = _Reader(source)
    if set(document) != {"calibration"}:
        raise reader.error("calibration", "must be the only table of this file")
    return replace(instrument, calibration=_calibration(reader, document["calibration"], instrument.calibration))


class _Reader:
    """Typed access to TOML tables; every error names the file and the key."""

    def __init__(self, source: str) -> None:
        self.source = source

    def error(self, key: str, problem: str) -> UsageError:
        return UsageError(f"{self.source}: {key} {problem}")

    def table(self, parent: dict[str, Any], key: str) -> dict[str, Any]:
        value = parent.get(key)
        if not isinstance(value, dict):
            raise self.error(key, "is missing or not a table")
        return value

    def rows(self, parent: dict[str, Any], key: str) -> list[dict[str, Any]]:
        value = parent.get(key, [])
        if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
            raise self.error(key, "must be an array of tables")
        return value

    def only(self, table: dict[str, Any], where: str, known: set[str]) -> None:
        for key in table:
            if key not in known:
                raise self.error(f"{where}.{key}", f"is unknown; known are {', '.join(sorted(known))}")

    def value(self, table: dict[str, Any], where: str, key: str, kind: type) -> Any:
        if key not in table:
            raise self.error(f"{where}.{key}", "is missing")
        value = table[key]
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        if not isinstance(value, kind) or (kind is not bool and isinstance(value, bool)):
            raise self.error(f"{where}.{key}", f"is {value!r}: {kind.__name__} expected")
        return value

    def numbers(self, table: dict[str, Any], where: str, key: str, count: int) -> tuple[float, ...]:
        value = self.value(table, where, key, list)
        if len(value) != count or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in value):
            raise self.error(f"{where}.{key}", f"is {value!r}: {count} numbers expected")
        return tuple(float(x) for x in value)

    def build(
        self, cls: type[_T], table: dict[str, Any], where: str, special: dict[str, Callable[[], Any]] | None = None
    ) -> _T:
        """The dataclass `cls` from a table; `special` makes the fields that are not plain values."""
        return cls(**self._values(cls, table, where, special or {}))

    def _values(
        self, cls: Any, table: dict[str, Any], where: str, special: dict[str, Callable[[], Any]]
    ) -> dict[str, Any]:
        names = {field.name: field for field in fields(cls)}
        self.only(table, where, set(names))
        values: dict[str, Any] = {}
        for name, field in names.items():
            if name in special:
                values[name] = special[name]()
            elif name in table or field.default is MISSING:
                assert isinstance(field.type, type)
                values[name] = self.value(table, where, name, field.type)
        return values


def _axis(reader: _Reader, row: dict[str, Any], where: str) -> Axis:
    row = dict(row)
    if "counts_per_deg" in row:
        row["counts_per_deg_ratio"] = row.pop("counts_per_deg")

    def ratio() -> Fraction:
        value = row.get("counts_per_deg_ratio")
        if (
            not isinstance(value, list)
            or len(value) != 2
            or not all(isinstance(x, int) and not isinstance(x, bool) and x != 0 for x in value)
        ):
            raise reader.error(f"{where}.counts_per_deg", f"is {value!r}: two whole numbers [counts, degrees], not 0")
        return Fraction(value[0], value[1])

    axis = reader.build(
        Axis,
        row,
        where,
        {
            "counts_per_deg_ratio": ratio,
            "vector": lambda: reader.numbers(row, where, "vector", 3),
            "homing": lambda: reader.build(Homing, reader.table(row, "homing"), f"{where}.homing"),
        },
    )
    if axis.carries not in ("sample", "detector"):
        raise reader.error(f"{where}.carries", f'is "{axis.carries}": "sample" or "detector" expected')
    if not axis.min_deg < axis.max_deg:
        raise reader.error(f"{where}.min_deg", f"is {axis.min_deg}: it must be less than max_deg = {axis.max_deg}")
    if axis.max_deg - axis.min_deg > axis.cable_wrap_deg:
        turn_deg = axis.max_deg - axis.min_deg
        raise reader.error(f"{where}.cable_wrap_deg", f"is {axis.cable_wrap_deg}: the limits let it turn {turn_deg}")
    if axis.max_velocity_deg_per_s <= 0 or axis.max_acceleration_deg_per_s2 <= 0:
        raise reader.error(f"{where}.max_velocity_deg_per_s", "and max_acceleration_deg_per_s2 must be positive")
    return axis


def _zone(reader: _Reader, row: dict[str, Any], where: str, axis_count: int) -> Zone:
    reader.only(row, where, {"name", "half_spaces"})
    half_spaces = []
    for i, line in enumerate(reader.value(row, where, "half_spaces", list)):
        here = f"{where}.half_spaces[{i}]"
        if not isinstance(line, dict):
            raise reader.error(here, "must be a table { a = [...], b = ... }")
        reader.only(line, here, {"a", "b"})
        half_spaces.append(HalfSpace(reader.numbers(line, here, "a", axis_count), reader.value(line, here, "b", float)))
    return Zone(reader.value(row, where, "name", str), tuple(half_spaces))


def _calibration(reader: _Reader, table: Any, base: Calibration | None = None) -> Calibration:
    if not isinstance(table, dict):
        raise reader.error("calibration", "is not a table")
    calibration = reader.build(Calibration, {**(asdict(base) if base else {}), **table}, "calibration")
    for field in fields(Calibration):
        if "_u" in field.name and getattr(calibration, field.name) < 0.0:
            raise reader.error(f"calibration.{field.name}", "is negative: an uncertainty is 0 or more")
    return calibration
