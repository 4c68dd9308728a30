"""validity.py: sentences that travel with a model: what was measured, what is extrapolated and by which rule."""

from typing import Any

import numpy as np

from gonio.geometry.directions import angles_deg_from_unit
from gonio.model.between.mesh import LARGEST_GAP_DEG, Triangles
from gonio.model.channel import Fitted, FittedComponent
from gonio.model.nodes.points import Component

RULE = (
    "Beyond the measured incident directions everything is held in the coordinates in which it moves: a lobe's offset "
    "from the ideal direction that it follows, its widths and its peak as at the nearest measured directions, the "
    "ground as there; the hemispherical integral does not exceed theirs."
)


def sentences(channels: dict[str, Fitted], record: dict[str, Any]) -> tuple[str, ...]:
    """For Bsdf.validity: per channel and component what was measured and (provenance["model"]["channels"]) which lobes
    were carried over to where no point sees them, then the rules."""
    result = [
        f"{name}, {component.name}: {_measured(component, model)}"
        for name, fitted in channels.items()
        for component, model in fitted.components.items()
    ]
    result += [
        f"{name}, {component}: {_carried(found)}"
        for name, components in record.items()
        for component, found in components.items()
        if _carried(found)
    ]
    return (*result, RULE)


def _carried(component: dict[str, Any]) -> str:
    places = [
        f"{lobe['theta_deg']:.4g}, {lobe['phi_deg'] % 359.995:.4g} at theta_i {node['theta_deg']:.4g}, "
        f"phi_i {node['phi_deg']:.4g}"
        for node in component["nodes"]
        for lobe in node["lobes"]
        if lobe["carried_over"]
    ]
    return (
        f"no point sees the top of the lobes at {'; '.join(places)}: as their neighbours have them." if places else ""
    )


def _measured(component: Component, model: FittedComponent) -> str:
    nodes = model.resolver.nodes
    theta, phi = angles_deg_from_unit(np.array([node.incident for node in nodes]))
    if not component.incident_front:
        theta = 180.0 - theta
    directions = f"{len(nodes)} incident direction{'' if len(nodes) == 1 else 's'}"
    low, high = f"{np.min(theta):.4g}", f"{np.max(theta):.4g}"
    span = f"theta_i {low}" if low == high else f"theta_i {low} to {high}"
    if model.resolver.images.isotropic:
        text = f"measured for {directions}, {span} degrees, isotropic as declared"
        least = float(np.min(theta) if component.incident_front else 180.0 - np.max(theta))
        inner = f"less than {least:.4g} or " if 2.0 * least > LARGEST_GAP_DEG else ""
        most = float(np.max(theta) if component.incident_front else 180.0 - np.min(theta))
        return f"{text}; {inner}more than {most:.4g} degrees from the normal extrapolated."
    azimuths = f"phi_i {np.min(phi):.4g} to {np.max(phi):.4g}" if np.ptp(phi) > 0.05 else f"phi_i {phi[0]:.4g}"
    text = f"measured for {directions}, {span}, {azimuths} degrees, symmetry {model.resolver.images.symmetry} declared"
    mesh = model.resolver.mesh
    if isinstance(mesh, Triangles) and len(mesh.triangles) == 0:
        return f"{text}; everything beside these directions and the lines between them is extrapolated."
    return f"{text}; beyond what they and their images surround extrapolated."
