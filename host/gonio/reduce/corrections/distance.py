"""distance.py: a front face that lies off the centre of the axes: the receiver's true distance and direction."""

import numpy as np
from numpy.typing import NDArray

from gonio.reduce.effects.receiver import spot_per_offset

FloatArray = NDArray[np.float64]

NAME = "distance"
WHAT = "light to the arm's radius, and directions as seen from where the beam meets the front face, off the centre"


def seen_from_spot(
    unit: FloatArray, incident_deg: tuple[float, float], offset_mm: float, arm_radius_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Directions (n, 3) from the spot to the receiver for the arm's own (n, 3), sample frame, and the factor (n,) that
    light falls by less at the arm's radius r: (r' / r)^2, r' being the receiver's distance from the spot.

    The beam's axis passes through the centre, so it meets a face at z = `offset_mm` beside it too: at
    offset / cos(theta_i) along the incident direction.
    """
    spot = spot_per_offset(*incident_deg) * (offset_mm / arm_radius_mm)
    towards = unit - spot
    squared = np.einsum("ij,ij->i", towards, towards)
    return towards / np.sqrt(squared)[:, None], squared
