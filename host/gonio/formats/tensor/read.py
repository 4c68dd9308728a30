"""read.py: reads tensor tree XML as found in the wild: ours, genBSDF's, bsdf2ttree's; what is odd becomes a finding."""

import hashlib
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, Scattering
from gonio.formats import validity, xml_guard
from gonio.formats.findings import Findings
from gonio.formats.tensor.flat import FlatTree, parse
from gonio.formats.tensor.frame import COMPONENTS, Component
from gonio.formats.tensor.tree import TreeScattering, TristimulusTrees
from gonio.formats.validity import Validity
from gonio.formats.xml_guard import child, children, local, text_of
from gonio.units.errors import UsageError

MAX_BYTES = 256 * 2**20
_WAVELENGTHS = {name.lower(): name for name in ("Visible", "Solar", "NIR", "CIE-X", "CIE-Y", "CIE-Z", "CIE-u", "CIE-v")}
_LENGTH_MM = {"meter": 1000.0, "centimeter": 10.0, "millimeter": 1.0, "foot": 304.8, "inch": 25.4}
_HEAD_BYTES = 2**16
_BASIS = "LBNL/Shirley-Chiu"


@dataclass
class TensorFile:
    """Content of a tensor tree file: trees per wavelength and component."""

    path: Path
    dimensions: int
    trees: dict[str, dict[Component, FlatTree]]
    name: str
    manufacturer: str
    comments: str
    thickness_mm: float | None
    sha256: str
    findings: Findings


def is_tensor(path: Path) -> bool:
    """Whether a file looks like tensor tree XML, by what stands near its beginning. False where it cannot be read."""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except OSError:
        return False
    _, mark, rest = head.partition(b"IncidentDataStructure")
    return bool(mark) and b"tensortree" in rest[:100].lower()


def read_tensor(path: Path, front_faces: Side | None = None) -> tuple[Bsdf, Findings]:
    """A tensor tree file as a sample, with what is odd about the file.

    `front_faces`: where the sample's front faces; it goes before what a file of ours says; where nobody says it, the
    front faces the exterior, as WINDOW uses the word. Raises UsageError for anything that is no complete tensor tree.
    """
    file = read_file(path)
    said = validity.parse(file.comments)
    faces: Side = front_faces or validity.front_faces_of(file.comments) or "exterior"
    rests = None if said is None else said.seen_with(faces)
    if said is None and validity.MARK in file.comments:
        file.findings.add("warning", "validity", "Comments", "the line of the validity range is damaged; ignored")
    isotropic = file.dimensions == 3
    return (
        Bsdf(
            _channels(file, faces, rests),
            sample_name=file.name,
            manufacturer=file.manufacturer,
            front_faces=faces,
            symmetry="isotropic" if isotropic else "undeclared" if said is None else said.symmetry,
            thickness_mm=file.thickness_mm,
            validity=_sentences(file, rests),
            provenance={
                "imported": {
                    "file": path.name,
                    "sha256": file.sha256,
                    "format": f"tensor tree XML, {file.dimensions} dimensions",
                    "resolution": max(tree.resolution for own in file.trees.values() for tree in own.values()),
                    "values": "averages over cells",
                    "front": f"faces the {faces}",
                    "comments": file.comments,
                    "findings": file.findings.as_json()["findings"],
                }
            },
        ),
        file.findings,
    )


def read_file(path: Path) -> TensorFile:
    """Trees and texts of a file; UsageError when it is foreign, cut off or too large."""
    content = xml_guard.read_limited(path, MAX_BYTES)
    root, stray = xml_guard.parse(content, path.name)
    findings = Findings(path.name)
    if local(root) != "WindowElement":
        raise UsageError(f"{path.name}: its root is <{local(root)[:40]}>, not <WindowElement>: this is no BSDF file")
    if stray:
        findings.add("warning", "stray-bytes", "start of file", f"{stray} bytes before the XML begins were skipped")
    optical = child(root, "Optical")
    layers = [] if optical is None else children(optical, "Layer")
    if not layers:
        raise UsageError(f"{path.name}: no <Optical><Layer>: this is no BSDF file")
    if len(layers) > 1:
        findings.add("warning", "layers", "Optical", f"{len(layers)} layers; the first one is read")
    layer = layers[0]
    structure = text_of(child(layer, "DataDefinition"), "IncidentDataStructure")
    if structure.lower() not in ("tensortree3", "tensortree4"):
        raise UsageError(
            f"{path.name}: IncidentDataStructure is {structure[:20]!r}, no tensor tree of 3 or 4 dimensions"
        )
    dimensions = int(structure[-1])
    material = child(layer, "Material")
    trees = _trees(layer, dimensions, findings, path.name)
    return TensorFile(
        path,
        dimensions,
        trees,
        text_of(material, "Name"),
        text_of(material, "Manufacturer"),
        text_of(material, "Comments"),
        _thickness_mm(material, findings),
        hashlib.sha256(content).hexdigest(),
        findings,
    )


def _trees(layer: ET.Element, dimensions: int, findings: Findings, name: str) -> dict[str, dict[Component, FlatTree]]:
    result: dict[str, dict[Component, FlatTree]] = {}
    for data in children(layer, "WavelengthData"):
        label = text_of(data, "Wavelength")
        wavelength = _WAVELENGTHS.get(label.lower())
        if wavelength is None:
            findings.add("note", "band", f"Wavelength {label[:40]!r}", "this band is not read")
            continue
        if wavelength != label:
            findings.add("warning", "label", f"Wavelength {label[:40]}", f"is usually written {wavelength}")
        for block in children(data, "WavelengthDataBlock"):
            component = _component(text_of(block, "WavelengthDataDirection"), findings)
            if component is None:
                continue
            where = f"{wavelength} {component}"
            basis = text_of(block, "AngleBasis")
            if basis.lower() != _BASIS.lower():
                findings.add("warning", "basis", where, f"angle basis {basis[:40]!r}; read as {_BASIS}")
            if component in result.get(wavelength, {}):
                findings.add(
                    "warning", "repeated", where, "is there more than once; the last is kept, as Radiance does"
                )
            element = child(block, "ScatteringData")
            text = (element.text if element is not None else "") or ""
            tree, negative = parse(text, dimensions, f"{name}: {where}")
            if negative:
                findings.add("warning", "negative", where, f"{negative} negative values; read as 0, as Radiance does")
            result.setdefault(wavelength, {})[component] = tree
    if not result:
        raise UsageError(f"{name}: holds no tensor tree")
    return result


def _component(label: str, findings: Findings) -> Component | None:
    tidy = label.lower().replace("reflectance", "reflection").replace("transmittance", "transmission")
    for component in COMPONENTS:
        if tidy == str(component).lower():
            if label.lower() != tidy:
                findings.add("warning", "label", label[:40], f"is usually written {component}; Radiance leaves it out")
            return component
    findings.add("warning", "direction", repr(label[:40]), "this block is not read")
    return None


def _channels(file: TensorFile, faces: Side, rests: Validity | None) -> dict[str, Scattering]:
    trees = dict(file.trees)
    u, v = trees.pop("CIE-u", None), trees.pop("CIE-v", None)
    if "CIE-Y" in trees and "Visible" not in trees:
        trees["Visible"] = trees.pop("CIE-Y")
    channels: dict[str, Scattering] = {}
    for wavelength, own in trees.items():
        name = wavelength if wavelength.startswith("CIE-") else wavelength.lower()
        channels[name] = TreeScattering(own, name, faces, rests)
    y = channels.get("visible")
    if u is None and v is None:
        return channels
    if isinstance(y, TreeScattering) and u is not None and v is not None and y.trees.keys() == u.keys() == v.keys():
        channels.setdefault("CIE-X", TristimulusTrees(y, u, v, of_x=True))
        channels.setdefault("CIE-Z", TristimulusTrees(y, u, v, of_x=False))
    else:
        message = "CIE-u, CIE-v and Visible do not have the same parts; colour is not read"
        file.findings.add("warning", "colour", "Wavelength", message)
    if not channels:
        raise UsageError(f"{file.path.name}: holds colour but no Visible tree")
    return channels


def _sentences(file: TensorFile, rests: Validity | None) -> tuple[str, ...]:
    averages = f"Values are averages over the cells of a tensor tree of {file.dimensions} dimensions."
    return (averages, *(() if rests is None else rests.sentences()))


def _thickness_mm(material: ET.Element | None, findings: Findings) -> float | None:
    element = None if material is None else child(material, "Thickness")
    text = "" if element is None else (element.text or "").strip()
    if element is None or not text:
        return None
    unit = element.get("unit", "")
    if unit.lower() not in _LENGTH_MM:
        findings.add("warning", "unit", "Thickness", f"unit {unit[:20]!r}; read as metres, as Radiance does")
    try:
        value = float(text) * _LENGTH_MM.get(unit.lower(), 1000.0)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < 1e9:
        findings.add("warning", "number", "Thickness", "is no length")
        return None
    return value
