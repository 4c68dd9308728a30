"""lobe.py: one Gaussian lobe of a distribution, in azimuthal equidistant coordinates about its centre."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.model.hemisphere import tangent_axes, tangent_from_unit

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Lobe:
    """DSF = peak exp(-u' C^-1 u / 2), u [rad] about `centre` along growing theta and growing phi (tangent_axes).

    centre (3,): unit vector, z >= 0; covariance_rad2 (2, 2): C.
    """

    centre: FloatArray
    covariance_rad2: FloatArray
    peak_per_sr: float

    def dsf_per_sr(self, unit: FloatArray) -> FloatArray:
        """DSF [1/sr] (m,) towards unit vectors (m, 3)."""
        u = tangent_from_unit(tangent_axes(self.centre), unit)
        return np.asarray(
            self.peak_per_sr * np.exp(-0.5 * np.einsum("ni,ij,nj->n", u, np.linalg.inv(self.covariance_rad2), u))
        )

    @property
    def sigma_rad(self) -> FloatArray:
        """Standard deviations (2,) along the principal axes, the smaller first."""
        return np.asarray(np.sqrt(np.linalg.eigvalsh(self.covariance_rad2)))

    @property
    def power(self) -> float:
        """Integral of the lobe over the plane [1]; the horizon is not taken off."""
        return float(2.0 * np.pi * self.peak_per_sr * np.sqrt(np.linalg.det(self.covariance_rad2)))
