"""nexus_axes.py: the instrument's axes as NXtransformations, so that a NeXus reader can place sample and detector."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.nexus_points import PointWriter
from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.units.errors import UsageError
from gonio.units.instrument import parse_instrument

_CHUNK = 1 << 14  # points at a time: what they need stays in the processor's cache
_WORKERS = 2
# Lab frame (+Z towards the source, +Y up) to NeXus' (McStas: z along the beam, y up): half a turn about y.
_NEXUS_FROM_LAB = np.diag([-1.0, 1.0, -1.0])


def write_axes(
    instrument_group: h5py.Group,
    sample_group: h5py.Group,
    distribution: Distribution,
    provenance: dict[str, Any],
    writer: PointWriter,
) -> None:
    """Write the chains of sample and detector; nothing where the provenance holds no instrument (imported data) or one
    whose readings do not follow from the directions alone.

    Sample readings are those of the incident direction. Detector readings, shape (n,), are computed from the points'
    directions; the readings that were measured are in the raw log.
    """
    text = provenance.get("instrument_text")
    if not text:
        return
    instrument = parse_instrument(text, "instrument file in the dataset")
    kinematics = Kinematics(instrument.axes)
    try:
        q1, q2 = kinematics.sample_axes_for_incident(distribution.incident_theta_deg, distribution.incident_phi_deg)
        arm_deg = _arm_deg(kinematics, (q1, q2), distribution)
    except UsageError:
        return
    detector = instrument_group["detector"]
    chains: dict[str, tuple[h5py.Group, list[Any]]] = {
        "sample": (sample_group, [q1, q2]),
        "detector": (detector, [arm_deg[:, 0], arm_deg[:, 1]]),
    }
    for carries, (group, readings) in chains.items():
        axes = [axis for axis in instrument.axes if axis.carries == carries]
        transformations = group.create_group("transformations")
        transformations.attrs["NX_class"] = "NXtransformations"
        depends_on = "."
        for axis, reading_deg in zip(axes, readings, strict=True):
            depends_on = _write_axis(writer, transformations, axis.name, axis.vector, reading_deg, depends_on)
        if carries == "detector":
            arm = np.array([0.0, 0.0, 1.0]) @ _NEXUS_FROM_LAB
            _write_translation(transformations, "arm radius", arm, instrument.arm_radius_mm, depends_on)
            depends_on = f"{transformations.name}/arm_radius"
        group["depends_on"] = depends_on
    detector["aperture"] = instrument.detector_aperture_mm
    detector["aperture"].attrs["units"] = "mm"


def _arm_deg(
    kinematics: Kinematics, sample_deg: tuple[float, float], distribution: Distribution
) -> NDArray[np.float64]:
    """Readings (n, 2) of the detector's axes."""
    theta_deg, phi_deg = distribution.theta_deg, distribution.phi_deg

    def of_part(begin: int) -> NDArray[np.float64]:
        part = slice(begin, begin + _CHUNK)
        return kinematics.arm_for_outgoing(*sample_deg, unit_from_angles_deg(theta_deg[part], phi_deg[part]))

    with ThreadPoolExecutor(_WORKERS) as workers:
        return np.concatenate([np.zeros((0, 2)), *workers.map(of_part, range(0, len(theta_deg), _CHUNK))])


def _write_axis(
    writer: PointWriter,
    group: h5py.Group,
    name: str,
    vector: tuple[float, float, float],
    reading_deg: Any,
    depends_on: str,
) -> str:
    stored = name.replace(" ", "_")
    values: NDArray[np.float64] = np.asarray(reading_deg, dtype=np.float64)
    if values.ndim:
        writer.add(group, stored, values)
    else:
        group[stored] = values
    _describe(group[stored], "rotation", np.asarray(vector) @ _NEXUS_FROM_LAB, "deg", depends_on)
    return f"{group.name}/{stored}"


def _write_translation(
    group: h5py.Group, name: str, vector: NDArray[np.float64], distance_mm: float, depends_on: str
) -> None:
    stored = name.replace(" ", "_")
    group[stored] = distance_mm
    _describe(group[stored], "translation", vector, "mm", depends_on)


def _describe(node: h5py.Dataset, kind: str, vector: NDArray[np.float64], units: str, depends_on: str) -> None:
    node.attrs["transformation_type"] = kind
    node.attrs["vector"] = vector
    node.attrs["units"] = units
    node.attrs["depends_on"] = depends_on
