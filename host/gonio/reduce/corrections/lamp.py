"""lamp.py: how bright the lamp was at each sample, by its monitor."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NAME = "lamp"
WHAT = "normalisation by the lamp monitor relative to its mean over the reference scan; without: a constant lamp"


def normalisation(monitor_counts: FloatArray, reference_counts: float) -> FloatArray:
    """Lamp (n,) relative to the reference scan, kept beside the signal, which is divided by it at the very end."""
    return monitor_counts / reference_counts
