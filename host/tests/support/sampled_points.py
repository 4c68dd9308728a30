"""sampled_points.py: small datasets of known functions, for tests of several folders."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg

FloatArray = NDArray[np.float64]


def spread(number: int) -> FloatArray:
    """Unit vectors (n, 3) over the upper hemisphere, equal areas, on Fibonacci's spiral."""
    k = np.arange(number) + 0.5
    z, phi = 1.0 - k / number, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)


def distribution(
    theta_i: float, phi_i: float, unit: FloatArray, dsf: FloatArray, variance: FloatArray | None = None
) -> Distribution:
    """Of points that share the hemisphere equally."""
    number = len(unit)
    theta, phi = angles_deg_from_unit(unit)
    return Distribution(
        incident_theta_deg=theta_i,
        incident_phi_deg=phi_i,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=dsf,
        variance_per_sr2=np.zeros(number) if variance is None else variance,
        signal=dsf,
        normalisation=np.ones(number),
        count=np.ones(number, dtype=np.int32),
        flags=np.zeros(number, dtype=np.uint16),
        solid_angle_sr=np.full(number, 2.0 * np.pi / number),
        time_ns=np.zeros(number, dtype=np.int64),
    )


def two_lobes(thetas_deg: Sequence[float], number: int = 3000) -> Dataset:
    """Isotropic, not declared so: retro lobe 5/sr of 6 degrees, mirror lobe 1/sr of 15 degrees, diffuse 0.3."""
    unit, parts = spread(number), []
    for theta in thetas_deg:
        retro = angle_between_deg(unit, unit_from_angles_deg(theta, 0.0)) / 6.0
        mirror = angle_between_deg(unit, unit_from_angles_deg(theta, 180.0)) / 15.0
        dsf = 0.3 / np.pi * unit[:, 2] + 5.0 * np.exp(-0.5 * retro**2) + np.exp(-0.5 * mirror**2)
        parts.append(distribution(theta, 0.0, unit, dsf))
    return Dataset(parts, sample_name="two lobes")
