"""seen.py: a bare model as the instrument sees it: through the free beam that was scanned."""

import numpy as np
from numpy.typing import NDArray

from gonio.compare.per_direction import PerDirection
from gonio.dataset.bsdf import Distribution
from gonio.dataset.scattering import Scattering
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.signature.forward import apply

FloatArray = NDArray[np.float64]


def seen_through(model: Scattering, beam: Distribution) -> PerDirection:
    """`model` averaged over the measured `beam` (reduce/signature/forward.py)."""

    def dsf_at(incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        incident_deg = (incident_theta_deg, incident_phi_deg)
        incident = unit_from_angles_deg([incident_theta_deg], [incident_phi_deg])
        return apply(beam, lambda v: model.dsf_per_sr(incident, v), outgoing, incident_deg)

    return PerDirection(dsf_at)
