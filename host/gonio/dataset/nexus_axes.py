"""nexus_axes.py: the instrument's axes as NXtransformations, so that a NeXus reader can place sample and detector."""

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.units.errors import UsageError
from gonio.units.instrument import parse_instrument

# Lab frame (+Z towards the source, +Y up) to NeXus' (McStas: z along the beam, y up): half a turn about y.
_NEXUS_FROM_LAB = np.diag([-1.0, 1.0, -1.0])


def write_axes(
    instrument_group: h5py.Group, sample_group: h5py.Group, distribution: Distribution, provenance: dict[str, Any]
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
    outgoing = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    try:
        q1, q2 = kinematics.sample_axes_for_incident(distribution.incident_theta_deg, distribution.incident_phi_deg)
        arm_deg = kinematics.arm_for_outgoing(q1, q2, outgoing)
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
            depends_on = _write_axis(transformations, axis.name, axis.vector, reading_deg, depends_on)
        if carries == "detector":
            arm = np.array([0.0, 0.0, 1.0]) @ _NEXUS_FROM_LAB
            _write_translation(transformations, "arm radius", arm, instrument.arm_radius_mm, depends_on)
            depends_on = f"{transformations.name}/arm_radius"
        group["depends_on"] = depends_on
    detector["aperture"] = instrument.detector_aperture_mm
    detector["aperture"].attrs["units"] = "mm"


def _write_axis(
    group: h5py.Group, name: str, vector: tuple[float, float, float], reading_deg: Any, depends_on: str
) -> str:
    stored = name.replace(" ", "_")
    values: NDArray[np.float64] = np.asarray(reading_deg, dtype=np.float64)
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if values.size > 2048 else {}
    group.create_dataset(stored, data=values, **packed)
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
