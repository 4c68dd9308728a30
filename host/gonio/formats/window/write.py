"""write.py: writes WINDOW XML with Klems matrices, a dataset's or a model's; reading is in read.py."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Polarisation, Side, Symmetry
from gonio.formats import atomic
from gonio.formats.validity import FRONT_SENTENCE
from gonio.formats.window import patch_table
from gonio.formats.window.klems import KlemsBasis, LightSide, Process
from gonio.formats.window.matrices import PROCESSES, SIDES, Band, Fill, KlemsMatrices, build

NAMESPACE = "http://windows.lbl.gov"


@dataclass(frozen=True)
class ThermalValues:
    """What WINDOW wants to know beside the optics. A goniophotometer does not measure it: the file says "assumed"."""

    conductivity_w_per_m_k: float = 1.0
    emissivity_front: float = 0.84
    emissivity_back: float = 0.84
    infrared_transmittance: float = 0.0
    thickness_mm: float = 1.0  # where the dataset has none


def write(
    dataset: Dataset,
    path: Path,
    *,
    basis: str = "klems-full",
    front: Side | None = None,
    fill: Fill = "none",
    assume_flat: bool = False,
    channel: str | None = None,
    thermal: ThermalValues | None = None,
    uncertainty: Path | None = None,
) -> KlemsMatrices:
    """Writes a dataset as WINDOW XML, whole or not at all; returns the matrices with their remarks.

    Values are BSDF [1/sr], a row per outgoing and a column per incident patch. Options as in `matrices.build`.
    `uncertainty` is a second file, of every patch's uncertainty (patch_table.py); both are written or none.
    Raises UsageError where something is undeclared or cannot be written, CheckFailed where energy exceeds 1.
    """
    built = build(dataset, basis=basis, front=front, fill=fill, assume_flat=assume_flat, channel=channel)
    files = {path: render(dataset, built, thermal or ThermalValues())}
    if uncertainty is not None:
        files[uncertainty] = patch_table.render(built)
    atomic.write_set(files)
    return built


class Described(Protocol):
    """What a file says of the sample: a Dataset or a Bsdf."""

    sample_name: str
    manufacturer: str
    thickness_mm: float | None
    polarisation: Polarisation
    symmetry: Symmetry


def render(dataset: Described, built: KlemsMatrices, thermal: ThermalValues) -> bytes:
    """The XML document of matrices already built, UTF-8."""
    root = ET.Element("WindowElement")
    root.set("xmlns", NAMESPACE)
    root.set("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance")
    root.set("xsi:schemaLocation", f"{NAMESPACE} BSDF-v1.7.7.xsd")
    _leaf(root, "WindowElementType", "System")
    _leaf(root, "FileType", "BSDF")
    layer = ET.SubElement(ET.SubElement(root, "Optical"), "Layer")
    _material(layer, dataset, built, thermal)
    definition = ET.SubElement(layer, "DataDefinition")
    _leaf(definition, "IncidentDataStructure", "Columns")
    _angle_basis(definition, built.basis)
    for band in built.bands:
        for side in SIDES:
            for process in PROCESSES:
                _matrix(layer, band, process, side, basis=built.basis, values=built.bands[band].matrices[process, side])
    ET.indent(root, space="  ")
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _material(layer: ET.Element, dataset: Described, built: KlemsMatrices, thermal: ThermalValues) -> None:
    material = ET.SubElement(layer, "Material")
    _leaf(material, "Name", dataset.sample_name or "unnamed sample")
    _leaf(material, "Manufacturer", dataset.manufacturer or "not stated")
    thickness = thermal.thickness_mm if dataset.thickness_mm is None else dataset.thickness_mm
    _leaf(material, "Thickness", f"{thickness:g}").set("unit", "Millimeter")
    _leaf(material, "DeviceType", "Other")
    _leaf(material, "ThermalConductivity", f"{thermal.conductivity_w_per_m_k:g}")
    _leaf(material, "EmissivityFront", f"{thermal.emissivity_front:g}")
    _leaf(material, "EmissivityBack", f"{thermal.emissivity_back:g}")
    _leaf(material, "TIR", f"{thermal.infrared_transmittance:g}")
    _leaf(material, "Comments", " ".join(_comments(dataset, built)))


def _comments(dataset: Described, built: KlemsMatrices) -> Iterator[str]:
    source = "a simulation" if built.simulated else built.source or "gonio-photometric points"
    yield f"Written by gonio from {source}."
    yield f"{FRONT_SENTENCE}{_face(built.front_faces)}."
    yield f"Polarisation {dataset.polarisation}; symmetry {dataset.symmetry} (as declared)."
    for band, name in built.channel_of.items():
        if name.lower() != band.lower():
            yield f"{band} holds channel {name}."
    yield from built.remarks()
    if dataset.thickness_mm is None:
        yield "Thickness assumed."
    yield "ThermalConductivity, emissivities and TIR assumed, not measured."


def _face(front_faces: Side) -> str:
    return "front" if front_faces == "exterior" else "back"


def _angle_basis(definition: ET.Element, basis: KlemsBasis) -> None:
    element = ET.SubElement(definition, "AngleBasis")
    _leaf(element, "AngleBasisName", basis.name)
    for ring in basis.rings:
        block = ET.SubElement(element, "AngleBasisBlock")
        _leaf(block, "Theta", f"{ring.nominal_theta_deg:g}")
        bounds = ET.SubElement(block, "ThetaBounds")
        _leaf(bounds, "LowerTheta", f"{ring.lower_deg:g}")
        _leaf(bounds, "UpperTheta", f"{ring.upper_deg:g}")
        _leaf(block, "nPhis", str(ring.patches))


def _matrix(
    layer: ET.Element, band: Band, process: Process, side: LightSide, *, basis: KlemsBasis, values: NDArray[np.float64]
) -> None:
    data = ET.SubElement(layer, "WavelengthData")
    _leaf(data, "LayerNumber", "System")
    _leaf(data, "Wavelength", band).set("unit", "Integral")
    block = ET.SubElement(data, "WavelengthDataBlock")
    _leaf(block, "WavelengthDataDirection", f"{process} {side}")
    _leaf(block, "ColumnAngleBasis", basis.name)
    _leaf(block, "RowAngleBasis", basis.name)
    _leaf(block, "ScatteringDataType", "BTDF")
    rows = (", ".join(f"{value:.7g}" for value in row) for row in values)
    _leaf(block, "ScatteringData", "\n" + ",\n".join(rows) + "\n")


def _leaf(parent: ET.Element, tag: str, text: str) -> ET.Element:
    element = ET.SubElement(parent, tag)
    # XML has no way to hold control characters: they become blanks.
    element.text = "".join(c if c.isprintable() or c == "\n" else " " for c in text)
    return element
