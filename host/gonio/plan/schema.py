"""schema.py: the plan file (TOML) as frozen dataclasses; every wrong key or value is one sentence that names it."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast

from gonio.units.errors import UsageError

Direction = tuple[float, float]  # theta_deg, phi_deg
NamedDirection = Literal["mirror", "retro", "through"]

_ANGLE = (0.0, 180.0)
_PITCH = (0.01, 45.0)
_RADIUS = (0.1, 60.0)


@dataclass(frozen=True)
class SamplePlan:
    """What is measured, as the user declares it; goes into the dataset unchanged."""

    name: str
    front_faces: str
    symmetry: str
    thickness_mm: float | None
    manufacturer: str


@dataclass(frozen=True)
class BeamPlan:
    """The illumination: `diameter_mm` on the sample, full divergence as seen at the arm's radius."""

    kind: str
    diameter_mm: float
    divergence_deg: float
    polarisation: str


@dataclass(frozen=True)
class ScanPlan:
    """`speed_deg_per_s` is the detector's along its track; `incident` the directions in the order of measurement."""

    speed_deg_per_s: float
    incident: tuple[Direction, ...]


@dataclass(frozen=True)
class SpiralPlan:
    """A spiral of constant pitch out to a radius."""

    radius_deg: float
    pitch_deg: float


@dataclass(frozen=True)
class CoarsePlan:
    """Interleaved circles over the sphere or the hemisphere in front of or behind the sample."""

    pitch_deg: float
    sphere: str


@dataclass(frozen=True)
class PeakPlan:
    """A spiral about an expected peak, for all incident directions (`for_incident` is None) or the listed ones."""

    about: NamedDirection | Direction
    spiral: SpiralPlan
    for_incident: tuple[Direction, ...] | None


@dataclass(frozen=True)
class SinusoidPlan:
    """All axes on sinusoids, to measure how well samples are paired with positions."""

    amplitude_deg: float
    peak_speed_deg_per_s: float
    duration_s: float


@dataclass(frozen=True)
class Plan:
    """A whole plan file; `text` is the file as it was read, `source` names it in errors."""

    source: str
    text: str
    sample: SamplePlan
    beam: BeamPlan
    scan: ScanPlan
    reference: SpiralPlan | None
    coarse: CoarsePlan | None
    peaks: tuple[PeakPlan, ...]
    dark_s: float
    sinusoid: SinusoidPlan | None


def load_plan(path: Path) -> Plan:
    """Read a plan file. Raises UsageError, naming file and key, for anything unreadable, unknown or out of range."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise UsageError(f"{path}: cannot read the plan ({_one_line(error)}): check the name") from error
    return parse_plan(text, str(path))


def parse_plan(text: str, source: str) -> Plan:
    """Parse the text of a plan; `source` names it in errors. Raises UsageError."""
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise UsageError(f"{source}: not TOML ({_one_line(error)})") from error
    plan = _Table(source, "", document)
    plan.only("sample", "beam", "scan", "reference", "coarse", "peak", "dark", "sinusoid")
    sinusoid = plan.optional("sinusoid")
    if sinusoid is not None:
        for key in ("scan", "reference", "coarse", "peak"):
            if key in document:
                raise plan.error(key, "does not go with [sinusoid]: that plan moves the axes, not the directions")
    elif "coarse" not in document and "peak" not in document:
        raise plan.error("coarse", "and [[peak]] are both missing: there is nothing to measure")
    scan = _scan(plan.table("scan")) if sinusoid is None else ScanPlan(30.0, ())
    reference = plan.optional("reference")
    coarse = plan.optional("coarse")
    return Plan(
        source=source,
        text=text,
        sample=_sample(plan.optional("sample") or plan.empty("sample")),
        beam=_beam(plan.optional("beam") or plan.empty("beam")),
        scan=scan,
        reference=_spiral(reference) if reference is not None else None,
        coarse=_coarse(coarse) if coarse is not None else None,
        peaks=tuple(_peak(row, scan) for row in plan.rows("peak")),
        dark_s=_dark(plan.optional("dark") or plan.empty("dark")),
        sinusoid=_sinusoid(sinusoid) if sinusoid is not None else None,
    )


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())


class _Table:
    """Typed access to one table of the plan."""

    def __init__(self, source: str, where: str, values: Mapping[str, Any]) -> None:
        self._source = source
        self._where = where
        self._values = values

    def error(self, key: str, problem: str) -> UsageError:
        name = f"{self._where}.{key}" if self._where else key
        return UsageError(f"{self._source}: {name} {problem}")

    def only(self, *known: str) -> None:
        for key in self._values:
            if key not in known:
                raise self.error(repr(key)[1:-1], f"is unknown; known are {', '.join(known)}")

    def empty(self, key: str) -> "_Table":
        return _Table(self._source, key, {})

    def optional(self, key: str) -> "_Table | None":
        if key not in self._values:
            return None
        value = self._values[key]
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table [{key}]")
        return _Table(self._source, key, value)

    def table(self, key: str) -> "_Table":
        table = self.optional(key)
        if table is None:
            raise self.error(key, "is missing")
        return table

    def rows(self, key: str) -> list["_Table"]:
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
            raise self.error(key, f"must be tables [[{key}]]")
        return [_Table(self._source, f"{key}[{i}]", row) for i, row in enumerate(value)]

    def raw(self, key: str) -> Any:
        return self._values.get(key)

    def text(self, key: str, default: str) -> str:
        value = self._values.get(key, default)
        if not isinstance(value, str) or "\n" in value or len(value) > 200:
            raise self.error(key, "must be one line of text of at most 200 characters")
        return value

    def choice(self, key: str, default: str, choices: tuple[str, ...]) -> str:
        value = self._values.get(key, default)
        if value not in choices:
            raise self.error(key, f"is {_shown(value)}: one of {', '.join(choices)} expected")
        return str(value)

    def number(self, key: str, limits: tuple[float, float], unit: str, default: float | None = None) -> float:
        value = self.optional_number(key, limits, unit)
        if value is None:
            value = default
        if value is None:
            raise self.error(key, "is missing")
        return value

    def optional_number(self, key: str, limits: tuple[float, float], unit: str) -> float | None:
        if key not in self._values:
            return None
        value = self._values[key]
        if not _is_number(value) or not limits[0] <= value <= limits[1]:
            raise self.error(key, f"is {_shown(value)}: a number from {limits[0]:g} to {limits[1]:g} {unit} expected")
        return float(value)

    def direction(self, key: str, value: Any) -> Direction:
        good = isinstance(value, list) and len(value) == 2 and all(_is_number(x) for x in value)
        if not good or not _ANGLE[0] <= value[0] <= _ANGLE[1] or not 0.0 <= value[1] <= 360.0:
            raise self.error(key, f"has {_shown(value)}: [theta 0 to 180, phi 0 to 360] in degrees expected")
        return float(value[0]), float(value[1]) % 360.0

    def directions(self, key: str, value: Any) -> tuple[Direction, ...]:
        if not isinstance(value, list) or not value:
            raise self.error(key, f"is {_shown(value)}: a list of [theta, phi] expected")
        found = tuple(self.direction(key, item) for item in value)
        if len(set(found)) < len(found):
            raise self.error(key, "names a direction twice")
        return found


def _shown(value: Any) -> str:
    shown = repr(value)
    return shown if len(shown) <= 60 else shown[:57] + "..."


def _is_number(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return abs(value) < 1e9 if isinstance(value, int) else math.isfinite(value)


def _sample(table: _Table) -> SamplePlan:
    table.only("name", "front_faces", "symmetry", "thickness_mm", "manufacturer")
    return SamplePlan(
        name=table.text("name", "sample"),
        front_faces=table.choice("front_faces", "undeclared", ("exterior", "interior", "undeclared")),
        symmetry=table.choice(
            "symmetry", "undeclared", ("none", "isotropic", "bilateral", "quadrilateral", "up", "undeclared")
        ),
        thickness_mm=table.optional_number("thickness_mm", (0.001, 1000.0), "mm"),
        manufacturer=table.text("manufacturer", ""),
    )


def _beam(table: _Table) -> BeamPlan:
    table.only("kind", "diameter_mm", "divergence_deg", "polarisation")
    kind = table.choice("kind", "collimated", ("collimated", "focused"))
    return BeamPlan(
        kind=kind,
        diameter_mm=table.number("diameter_mm", (0.1, 500.0), "mm", 65.0 if kind == "collimated" else 10.0),
        divergence_deg=table.number("divergence_deg", (0.0, 30.0), "degrees", 0.0),
        polarisation=table.choice("polarisation", "unknown", ("unpolarised", "s", "p", "unknown")),
    )


def _scan(table: _Table) -> ScanPlan:
    table.only("speed_deg_per_s", "incident")
    return ScanPlan(
        speed_deg_per_s=table.number("speed_deg_per_s", (0.1, 360.0), "degrees/s", 30.0),
        incident=table.directions("incident", table.raw("incident")),
    )


def _spiral(table: _Table) -> SpiralPlan:
    table.only("radius_deg", "pitch_deg")
    return _radius_and_pitch(table)


def _radius_and_pitch(table: _Table) -> SpiralPlan:
    spiral = SpiralPlan(table.number("radius_deg", _RADIUS, "degrees"), table.number("pitch_deg", _PITCH, "degrees"))
    if spiral.radius_deg < spiral.pitch_deg:
        raise table.error(
            "radius_deg", f"is {spiral.radius_deg:g}: at least the pitch of {spiral.pitch_deg:g} expected"
        )
    return spiral


def _coarse(table: _Table) -> CoarsePlan:
    table.only("pitch_deg", "sphere")
    return CoarsePlan(
        pitch_deg=table.number("pitch_deg", (0.1, 30.0), "degrees", 6.0),
        sphere=table.choice("sphere", "whole", ("whole", "front", "back")),
    )


def _peak(table: _Table, scan: ScanPlan) -> PeakPlan:
    table.only("about", "radius_deg", "pitch_deg", "for_incident")
    raw = table.raw("about")
    about: NamedDirection | Direction
    if isinstance(raw, list):
        about = table.direction("about", raw)
    else:
        about = cast(NamedDirection, table.choice("about", "", ("mirror", "retro", "through")))
    listed = table.raw("for_incident")
    chosen = None if listed in (None, "all") else table.directions("for_incident", listed)
    for direction in chosen or ():
        if direction not in scan.incident:
            raise table.error("for_incident", f"has [{direction[0]:g}, {direction[1]:g}], which scan.incident has not")
    return PeakPlan(about, _radius_and_pitch(table), chosen)


def _dark(table: _Table) -> float:
    table.only("duration_s")
    return table.number("duration_s", (0.05, 600.0), "s", 1.0)


def _sinusoid(table: _Table) -> SinusoidPlan:
    table.only("amplitude_deg", "peak_speed_deg_per_s", "duration_s")
    return SinusoidPlan(
        amplitude_deg=table.number("amplitude_deg", (0.1, 90.0), "degrees"),
        peak_speed_deg_per_s=table.number("peak_speed_deg_per_s", (0.1, 360.0), "degrees/s"),
        duration_s=table.number("duration_s", (20.0, 36000.0), "s"),
    )
