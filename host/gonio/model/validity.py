"""validity.py: sentences that travel with a model: what was measured, what is extrapolated and by which rule."""

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


def sentences(channels: dict[str, Fitted]) -> tuple[str, ...]:
    """For Bsdf.validity: per channel and component what was measured, then the rules."""
    result = [
        f"{name}, {component.name}: {_measured(component, model)}"
        for name, fitted in channels.items()
        for component, model in fitted.components.items()
    ]
    return (*result, RULE)


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
