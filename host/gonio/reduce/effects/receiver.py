"""receiver.py: effects on the solid angle that the receiver sees: what is left of distance and aperture.

With P_i = sum E Omega by the same receiver on the same arm neither counts to first order: E = I A / r^2, and the arm
carries the same A through the beam at the same r, so E / P_i does not change. What is left is a sample off the centre.
(In the form with r, A and a reference signal, reduce/integrals/reference_signal.py, both count in full.)
"""

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

# Nearer to grazing than this the beam's spot is longer than any sample, and its place means nothing.
_LEAST_COSINE = 0.05


def spot_per_offset(incident_theta_deg: float, incident_phi_deg: float) -> FloatArray:
    """Where the beam's axis, which runs through the axes' centre, meets a front face that lies off it along +z: vector
    (3,) per unit of the offset, sample frame."""
    incident = unit_from_angles_deg(incident_theta_deg, incident_phi_deg)
    cosine = float(incident[2])
    return np.asarray(incident / (np.copysign(max(abs(cosine), _LEAST_COSINE), cosine)))


def nearer_rel(unit: FloatArray, spot_mm: FloatArray, arm_radius_mm: float) -> FloatArray:
    """Relative rise (n,) of the light where the spot lies at `spot_mm` (3,) instead of in the centre: (r / r')^2 - 1 to
    first order, 2 (o . spot) / r for outgoing directions o (3, n). At normal incidence that is 2 h cos(theta) / r."""
    return np.asarray(2.0 * (spot_mm @ unit) / arm_radius_mm)


def shift_rad(unit: FloatArray, spot_mm: FloatArray, arm_radius_mm: float) -> FloatArray:
    """By how much (3, n) the direction from the spot to the receiver differs from the arm's, first order in 1/r."""
    return np.asarray(((spot_mm @ unit) * unit - spot_mm[:, None]) / arm_radius_mm)
