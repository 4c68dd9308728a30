"""seen.py: a bare model as the instrument sees it: through the free beam that was scanned."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.compare.field import Evaluable
from gonio.dataset.bsdf import Distribution
from gonio.reduce.signature.forward import apply

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SeenModel:
    """Evaluable: `model` averaged over the measured `beam` (reduce/signature/forward.py)."""

    model: Evaluable
    beam: Distribution

    def dsf_per_sr(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        """See Evaluable."""
        incident_deg = (incident_theta_deg, incident_phi_deg)
        return apply(self.beam, lambda v: self.model.dsf_per_sr(*incident_deg, v), outgoing, incident_deg)
