"""lambertian.py: the same radiance in all directions."""

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray
from gonio.model.analytic.family import Parameter, Process


class Lambertian:
    """BSDF = share / pi: J. H. Lambert, Photometria (1760); share is rho or tau."""

    name = "lambertian"
    source = "Lambert 1760: BSDF = share / pi"
    processes: tuple[Process, ...] = ("reflection", "transmission")
    parameters = (Parameter("share", "1", 0.0, 1.0, False, "hemispherical reflectance or transmittance"),)
    per_direction = True

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """See Family."""
        del incident, outgoing
        return np.asarray(values[which, 0] / np.pi)

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """See Family."""
        del incident
        return values[:, 0].copy()

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """None: it has no peak."""
        del values, incident
        return Features.none()

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family."""
        del mirror_bsdf
        return np.array([[min(np.pi * far_bsdf, 1.0)]])
