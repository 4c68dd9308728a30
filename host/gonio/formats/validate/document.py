"""document.py: what a BSDF XML file says beside its values: schema, sides, fields of the material."""

import importlib.resources
import itertools
import xml.etree.ElementTree as ET
from functools import cache
from typing import Literal

import xmlschema

from gonio.formats import validity
from gonio.formats.findings import Findings
from gonio.formats.window.klems import BASES
from gonio.formats.window.read import WindowBsdf

Profile = Literal["window", "radiance"]
Grave = Literal["error", "note"]
_MOST_SCHEMA_ERRORS = 20
_NEEDED_NUMBERS = ("ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR")


def graver_for_window(profile: Profile) -> Grave:
    """What WINDOW cannot do without, Radiance does not need."""
    return "error" if profile == "window" else "note"


@cache
def _window_schema() -> xmlschema.XMLSchema:
    source = importlib.resources.files("gonio.formats") / "data" / "BSDF-v1.7.7.xsd"
    return xmlschema.XMLSchema(source.read_text(encoding="utf-8"))


def check_schema(root: ET.Element, findings: Findings, profile: Profile) -> None:
    """The public schema of WINDOW's files, version 1.7.7."""
    errors = _window_schema().iter_errors(root)
    for error in itertools.islice(errors, _MOST_SCHEMA_ERRORS):
        where = (error.path or "").rpartition("}")[2].rpartition("/")[2] or "document"
        findings.add(graver_for_window(profile), "schema", where, " ".join((error.reason or "not valid").split())[:200])


def note_sides(findings: Findings, comments: str) -> None:
    """Which side of the sample the file's Front is."""
    faces = validity.front_faces_of(comments)
    meaning = "Front is light from the exterior" + (
        "; the file does not say which side of the sample that is"
        if faces is None
        else f", where the sample's {'front' if faces == 'exterior' else 'back'} faces"
    )
    findings.add("note", "sides", "WavelengthDataDirection", meaning)


def note_copied(findings: Findings) -> None:
    """Of a file whose Solar values are the Visible ones."""
    findings.add("note", "copied", "Solar", "is the same as Visible: was one copied, or is the sample spectrally flat?")


def check_fields(content: WindowBsdf, profile: Profile) -> None:
    """What WINDOW's engine wants to know of the material, and whether reader and file mean the same basis."""
    findings = content.findings
    if profile == "window":
        _check_material(content)
        if content.basis.rings != BASES["klems-full"].rings:
            findings.add("warning", "basis", content.basis.name[:40], "WINDOW's engine takes Klems full only")
        return
    # Radiance looks a basis up by its name and never reads the rings of one that it knows.
    own = next((basis for basis in BASES.values() if basis.name.lower() == content.basis.name.lower()), None)
    if own is not None and own.rings != content.basis.rings:
        same = own.size == content.basis.size
        findings.add(
            "warning" if same else "error",
            "basis",
            content.basis.name[:40],
            f"is defined with {content.basis.size} patches of other rings; Radiance takes its own of that name, "
            f"{own.size} patches",
        )


def _check_material(content: WindowBsdf) -> None:
    findings = content.findings
    for name in ("Name", "Manufacturer"):
        if name not in content.text:
            findings.add("error", "field", name, "is missing or empty; WINDOW's engine needs it")
    if content.thickness_mm is None:
        findings.add("error", "field", "Thickness", "is missing; WINDOW's engine needs it")
    for name in _NEEDED_NUMBERS:
        value = content.numbers.get(name)
        if value is None:
            findings.add("error", "field", name, "is missing; WINDOW's engine needs it")
        elif name != "ThermalConductivity" and not 0 <= value <= 1:
            findings.add("error", "field", name, f"is {value:g}, not between 0 and 1")
