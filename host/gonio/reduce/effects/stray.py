"""stray.py: light that the room adds everywhere."""

import numpy as np
from numpy.typing import NDArray

from gonio.units.calibration import Calibration

FloatArray = NDArray[np.float64]


def stray_columns(dsf_per_sr: FloatArray, calibration: Calibration) -> dict[str, FloatArray]:
    """Column (n,) [1/sr per standard deviation]: the same DSF at every point; NaN where there is no value."""
    return {"stray_light": np.where(np.isnan(dsf_per_sr), np.nan, calibration.stray_light_u_per_sr)}
