"""per_direction.py: a function of one incident direction (a closed form) as a Scattering."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin
from gonio.geometry.directions import angles_deg_from_unit


@dataclass(frozen=True)
class PerDirection:
    """`dsf_at(incident theta [deg], incident phi [deg], outgoing (n, 3))` gives the DSF [1/sr] (n,), NaN where it has
    none; it is called once per incident row, as closed forms that are convolved with a beam must be."""

    dsf_at: Callable[[float, float, FloatArray], FloatArray]

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        theta_deg, phi_deg = angles_deg_from_unit(incident)
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        result = np.full(len(outgoing), np.nan)
        for row in np.unique(rows).tolist():
            own = rows == row
            result[own] = self.dsf_at(float(theta_deg[row]), float(phi_deg[row]), outgoing[own])
        return result

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering. What is known everywhere is not interpolated."""
        absent = np.isnan(self.dsf_per_sr(incident, outgoing, which))
        return np.where(absent, Origin.ABSENT, Origin.MEASURED).astype(np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        del incident_front, outgoing_front
        return True

    def features(self, incident: FloatArray) -> Features:
        """See Scattering; none are known of a function."""
        del incident
        return Features.none()
