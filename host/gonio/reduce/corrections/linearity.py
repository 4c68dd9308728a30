"""linearity.py: the receiver's departure from proportion to the light."""

import numpy as np
from numpy.typing import NDArray

from gonio.reduce.corrections.light import Gains

FloatArray = NDArray[np.float64]

NAME = "linearity"
WHAT = "light = signal (1 + c signal / full scale), either gain alike"


def linearised(
    signal: FloatArray, high_weight: FloatArray, gains: Gains, coefficient: float
) -> tuple[FloatArray, FloatArray]:
    """Light (n,) in counts of the low gain, and its derivative (n,) by the signal, by which noise grows."""
    bend = coefficient * gains.level(signal, high_weight)
    return signal * (1.0 + bend), 1.0 + 2.0 * bend
