"""read.py: reads WINDOW XML with Klems matrices as found in the wild; what is odd becomes a finding."""

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from gonio.formats import xml_guard
from gonio.formats.findings import Findings
from gonio.formats.text_numbers import rounding_variance
from gonio.formats.window.klems import BASES, KlemsBasis, LightSide, Process, basis_from_rings
from gonio.formats.window.matrices import PROCESSES, SIDES, Band
from gonio.formats.xml_guard import child, children, local, text_of
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]
READ_BANDS: tuple[Band, ...] = get_args(Band)
# What older Radiance called by the same names (source of Radiance 4 and 5, table of angle bases).
OLD_BASES: tuple[KlemsBasis, ...] = (
    basis_from_rings(
        "LBNL/Klems Half",
        (0, 13, 26, 39.5, 54, 69, 83.25),
        (0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90),
        (1, 8, 12, 16, 20, 12, 4),
    ),
    basis_from_rings("LBNL/Klems Quarter", (0, 18, 36.5, 56, 78), (0, 9, 27, 46, 66, 90), (1, 8, 12, 12, 8)),
)
_LENGTH_MM = {"meter": 1000.0, "centimeter": 10.0, "millimeter": 1.0, "foot": 304.8, "inch": 25.4}  # Radiance's words
_SHORT_LABELS = {
    "tf": "transmission front",
    "tb": "transmission back",
    "rf": "reflection front",
    "rb": "reflection back",
}
_MATERIAL_FIELDS = ("Name", "Manufacturer", "DeviceType", "Comments")
_MATERIAL_NUMBERS = ("ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR")
_MOST_PATCHES = 2048


@dataclass
class WindowBsdf:
    """Content of a WINDOW file. Matrices hold BSDF [1/sr], shape (outgoing patches, incident patches)."""

    path: Path
    basis: KlemsBasis
    matrices: dict[tuple[Band, Process, LightSide], FloatArray]
    text: dict[str, str]  # Name, Manufacturer, DeviceType, Comments; only what is there
    numbers: dict[str, float]  # ThermalConductivity, EmissivityFront, EmissivityBack, TIR; only what is there
    thickness_mm: float | None
    findings: Findings
    root: ET.Element = field(repr=False)
    # Variance [1/sr^2] of rounding to the last written digit, shaped as the matrices; empty unless it was asked for.
    rounding: dict[tuple[Band, Process, LightSide], FloatArray] = field(default_factory=dict, repr=False)

    def hemispherical(self, band: Band, process: Process, side: LightSide) -> FloatArray:
        """Directional-hemispherical value per incident patch, sum of B L, shape (patches,)."""
        return self.basis.projected_solid_angle_sr @ self.matrices[band, process, side]


def read(path: Path, *, with_rounding: bool = False) -> WindowBsdf:
    """Reads a file, `with_rounding` too if wanted; UsageError when it is foreign, cut off or holds no Klems matrix."""
    content = xml_guard.read_limited(path)
    root, stray = xml_guard.parse(content, path.name)
    findings = Findings(path.name)
    if local(root) != "WindowElement":
        raise UsageError(f"{path.name}: its root is <{local(root)[:40]}>, not <WindowElement>: this is no WINDOW file")
    if stray:
        findings.add("warning", "stray-bytes", "start of file", f"{stray} bytes before the XML begins were skipped")
    if not root.tag.startswith("{http://windows.lbl.gov}"):
        findings.add("warning", "namespace", "WindowElement", "the namespace http://windows.lbl.gov is not declared")
    optical = child(root, "Optical")
    layers = [] if optical is None else children(optical, "Layer")
    if not layers:
        raise UsageError(f"{path.name}: no <Optical><Layer>: this is no WINDOW BSDF file")
    if len(layers) > 1:
        findings.add("warning", "layers", "Optical", f"{len(layers)} layers; the first one is read")
    layer = layers[0]
    definition = child(layer, "DataDefinition")
    structure = text_of(definition, "IncidentDataStructure")
    if structure.lower().startswith("tensortree"):
        raise UsageError(f"{path.name}: holds a {structure[:20]}, no Klems matrices")
    if structure not in ("Columns", "Rows"):
        findings.add("warning", "structure", "IncidentDataStructure", f"is {structure[:40]!r}; read as Columns")
    bases = _bases(definition, findings)
    rounding: dict[tuple[Band, Process, LightSide], FloatArray] | None = {} if with_rounding else None
    matrices, basis = _matrices(layer, bases, structure == "Rows", findings, path.name, rounding)
    material = child(layer, "Material")
    text = {name: found for name in _MATERIAL_FIELDS if (found := text_of(material, name))}
    numbers = {}
    for name in _MATERIAL_NUMBERS:
        found = text_of(material, name)
        value = _number(found)
        if value is not None:
            numbers[name] = value
        elif found:
            findings.add("warning", "number", name, f"{found[:40]!r} is no number")
    return WindowBsdf(
        path, basis, matrices, text, numbers, _thickness(material, findings), findings, root, rounding or {}
    )


def _thickness(material: ET.Element | None, findings: Findings) -> float | None:
    element = None if material is None else child(material, "Thickness")
    if element is None:
        return None
    value = _number((element.text or "").strip())
    unit = element.get("unit", "")
    if not (element.text or "").strip():
        findings.add("note", "number", "Thickness", "is empty")
        return None
    if unit not in ("Meter", "Millimeter"):
        odd = f"unit {unit[:20]!r}" if unit else "no unit"
        read_as = f"as {unit.lower()}" if unit.lower() in _LENGTH_MM else "as metres"
        findings.add("warning", "unit", "Thickness", f"{odd}, not Meter or Millimeter; read {read_as}")
    if value is None or value < 0:
        findings.add("warning", "number", "Thickness", "is no length")
        return None
    return value * _LENGTH_MM.get(unit.lower(), _LENGTH_MM["meter"])


def _bases(definition: ET.Element | None, findings: Findings) -> dict[str, KlemsBasis]:
    found: dict[str, KlemsBasis] = {}
    for element in [] if definition is None else children(definition, "AngleBasis"):
        name = text_of(element, "AngleBasisName")
        blocks = children(element, "AngleBasisBlock")
        try:
            found[name] = _basis(name, blocks)
        except UsageError as error:
            if not _known_bases(name):
                raise
            findings.add("warning", "basis", f"AngleBasis {name[:40]}", f"{error}; it is not used")
    return found


def _basis(name: str, blocks: list[ET.Element]) -> KlemsBasis:
    rows: list[tuple[float, float, float, int]] = []
    for block in blocks:
        bounds = child(block, "ThetaBounds")
        values = [
            _number(text_of(block, "Theta")),
            _number(text_of(bounds, "LowerTheta")),
            _number(text_of(bounds, "UpperTheta")),
            _number(text_of(block, "nPhis")),
        ]
        numbers = [value for value in values if value is not None]
        if len(numbers) != 4:
            raise UsageError(f"angle basis {name[:40]}: a block lacks Theta, LowerTheta, UpperTheta or nPhis")
        if not 1 <= numbers[3] <= _MOST_PATCHES:
            raise UsageError(f"angle basis {name[:40]}: {numbers[3]:g} patches in a ring")
        rows.append((numbers[0], numbers[1], numbers[2], int(numbers[3])))
    bounds_deg = [0.0, *(row[2] for row in rows)]
    if any(abs(row[1] - lower) > 1e-6 for row, lower in zip(rows, bounds_deg, strict=False)):
        raise UsageError(f"angle basis {name[:40]}: rings do not join")
    if sum(row[3] for row in rows) > _MOST_PATCHES:
        raise UsageError(f"angle basis {name[:40]}: more than {_MOST_PATCHES} patches")
    return basis_from_rings(name, [row[0] for row in rows], bounds_deg, [row[3] for row in rows])


def _known_bases(name: str) -> list[KlemsBasis]:
    """Bases of that name, today's first."""
    return [basis for basis in (*BASES.values(), *OLD_BASES) if basis.name.lower() == name.lower()]


def _matrices(
    layer: ET.Element,
    bases: dict[str, KlemsBasis],
    transposed: bool,
    findings: Findings,
    name: str,
    rounding: dict[tuple[Band, Process, LightSide], FloatArray] | None,
) -> tuple[dict[tuple[Band, Process, LightSide], FloatArray], KlemsBasis]:
    matrices: dict[tuple[Band, Process, LightSide], FloatArray] = {}
    basis: KlemsBasis | None = None
    for data in children(layer, "WavelengthData"):
        band = _band(data, findings)
        if band is None:
            continue
        for block in children(data, "WavelengthDataBlock"):
            key = _direction(text_of(block, "WavelengthDataDirection"), findings)
            if key is None:
                continue
            process, side = key
            where = f"{band} {process} {side}"
            kind = text_of(block, "ScatteringDataType")
            if kind.upper() not in ("BTDF", "BRDF", "BSDF", ""):
                findings.add("warning", "data-type", where, f"{kind[:40]!r} is not read")
                continue
            if kind != "BTDF":
                findings.add("warning", "data-type", where, f"type {kind!r}; read as BSDF in 1/sr")
            tokens = _tokens(child(block, "ScatteringData"))
            own = _block_basis(block, bases, len(tokens), where, findings, name)
            if basis is not None and own.rings != basis.rings:
                raise UsageError(f"{name}: {where} has another angle basis than the matrices before it")
            basis = own
            values = _numbers(tokens, own.size, where, name)
            if (band, process, side) in matrices:
                findings.add("warning", "repeated", where, "is there more than once; the first is kept")
                continue
            matrices[band, process, side] = values.T.copy() if transposed else values
            if rounding is not None:
                variance = rounding_variance(tokens).reshape(values.shape)
                rounding[band, process, side] = variance.T.copy() if transposed else variance
    if basis is None:
        raise UsageError(f"{name}: holds no visible or solar Klems matrix")
    return matrices, basis


def _band(data: ET.Element, findings: Findings) -> Band | None:
    label = text_of(data, "Wavelength")
    for band in READ_BANDS:
        if label.lower() == band.lower():
            if label != band:
                findings.add("warning", "label", f"Wavelength {label}", f"is usually written {band}")
            return band
    findings.add("note", "band", f"Wavelength {label[:40]!r}", "this band is not read")
    return None


def _direction(label: str, findings: Findings) -> tuple[Process, LightSide] | None:
    tidy = label.lower().replace("reflectance", "reflection").replace("transmittance", "transmission")
    words = set(_SHORT_LABELS.get(tidy, tidy).split())
    for process in PROCESSES:
        for side in SIDES:
            if words == {process.lower(), side.lower()}:
                if label != f"{process} {side}":
                    findings.add("warning", "label", label[:40], f"is usually written {process} {side}")
                return process, side
    known = tidy.startswith("absorbed")
    findings.add("note" if known else "warning", "direction", repr(label[:40]), "this block is not read")
    return None


def _block_basis(
    block: ET.Element, bases: dict[str, KlemsBasis], count: int, where: str, findings: Findings, name: str
) -> KlemsBasis:
    """The basis that the file itself defines; without one the usual basis of that name, if need be the older one that
    the number of values fits."""
    column, row = text_of(block, "ColumnAngleBasis"), text_of(block, "RowAngleBasis")
    if column != row:
        raise UsageError(f"{name}: {where} has different row and column bases ({row[:40]!r}, {column[:40]!r})")
    defined = next((basis for title, basis in bases.items() if title.lower() == column.lower()), None)
    if defined is not None:
        if column not in bases:
            findings.add("warning", "basis", where, f"{column[:40]!r} is written {defined.name[:40]!r} where defined")
        return defined
    if not column and len(bases) == 1:
        findings.add("warning", "basis", where, "names no angle basis; the only one defined is taken")
        return next(iter(bases.values()))
    known = _known_bases(column)
    if not known:
        raise UsageError(f"{name}: {where} uses the angle basis {column[:40]!r}, which the file does not define")
    chosen = next((basis for basis in known if basis.size**2 == count), known[0])
    findings.add("warning", "basis", where, f"{column[:40]!r} is not defined; {_described(chosen)} is taken")
    return chosen


def _described(basis: KlemsBasis) -> str:
    limits = ", ".join(f"{ring.upper_deg:g}" for ring in basis.rings)
    return f"{basis.name} of {basis.size} patches, rings up to {limits} degrees,"


def _tokens(element: ET.Element | None) -> list[str]:
    return re.split(r"[\s,;]+", ((element.text if element is not None else "") or "").strip(" \t\r\n,;"))


def _numbers(tokens: list[str], size: int, where: str, name: str) -> FloatArray:
    if len(tokens) != size * size:
        raise UsageError(f"{name}: {where} holds {len(tokens)} values, not {size} x {size}; is the file cut off?")
    try:
        values = np.array(tokens, dtype=np.float64)
    except ValueError as error:
        raise UsageError(f"{name}: {where} holds something that is no number ({str(error)[:60]})") from error
    if not np.all(np.isfinite(values)):
        raise UsageError(f"{name}: {where} holds values that are not finite")
    return values.reshape(size, size)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if np.isfinite(value) else None
