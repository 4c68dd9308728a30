"""stray_light.py: light that the room adds in every direction."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NAME = "stray_light"
WHAT = "a constant DSF of the dark room subtracted, as signal: stray light times P_i times normalisation"


def without_stray(signal: FloatArray, normalisation: FloatArray, p_i: float, stray_per_sr: float) -> FloatArray:
    """Signal (n,) less what the room adds to it."""
    return signal - stray_per_sr * p_i * normalisation
