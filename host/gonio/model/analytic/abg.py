"""abg.py: the ABg family: a flat top that turns into a power law of the distance from the specular direction."""

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray
from gonio.model.analytic.family import Parameter, Process
from gonio.model.analytic.polar_rule import radial_integral

_NARROW = 0.25  # of a core in direction cosines: wider ones need no special care


def distance(incident: FloatArray, outgoing: FloatArray, which: IndexArray) -> FloatArray:
    """|beta - beta0| (m,): distance of the outgoing direction's (x, y) from that of the mirror or through direction."""
    apart = outgoing[:, :2] + incident[which, :2]
    return np.asarray(np.hypot(apart[:, 0], apart[:, 1]))


class ABg:
    """BSDF = A / (B + |beta - beta0|^g), beta the projection of a unit vector on the sample's plane, beta0 that of the
    mirror direction in reflection and of the straight-through direction in transmission (paper [2] eq. 1, after
    Freniere et al. 1999 and Harvey's transfer functions). g = 0 is Lambertian with pi A / (B + 1)."""

    name = "abg"
    source = "paper [2] eq. 1: BSDF = A / (B + |beta - beta0|^g)"
    processes: tuple[Process, ...] = ("reflection", "transmission")
    parameters = (
        Parameter("A", "1/sr", 0.0, 1e6, True, "scale; A / B is the BSDF in the specular direction"),
        Parameter("B", "1", 1e-14, 1e3, True, "B^(1/g) is where the flat top turns into the power law"),
        Parameter("g", "1", 0.0, 12.0, False, "slope of the power law"),
    )
    per_direction = True

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """See Family."""
        a, b, g = values[which].T
        return np.asarray(a / (b + distance(incident, outgoing, which) ** g))

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """See Family; to about 1e-12 of itself (polar_rule.radial_integral)."""
        a, b, g = (column[:, None] for column in values.T)
        return radial_integral(lambda r: a / (b + r**g), np.hypot(incident[:, 0], incident[:, 1]))

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """The core of radius B^(1/g) in direction cosines: its half width at half maximum across the plane of
        incidence, the narrower way."""
        radius = np.exp(np.log(values[:, 1]) / np.maximum(values[:, 2], 1e-3))
        rows = np.flatnonzero(radius < _NARROW)
        centre = incident[rows] * np.array([-1.0, -1.0, 1.0])
        return Features(centre, radius[rows] / np.sqrt(2.0 * np.log(2.0)), rows.astype(np.int64))

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family: tops of 0.3 to 15 degrees and three slopes, through both BSDF."""
        found = []
        for radius in (0.005, 0.02, 0.08, 0.3):
            for g in (1.0, 2.0, 3.5):
                b = radius**g
                found.append((max(mirror_bsdf * b, 1e-12), b, g))
        found.append((max(2.0 * far_bsdf, 1e-12), 1.0, 0.5))
        return np.array(found)
