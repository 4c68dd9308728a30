"""tie.py: hemispherical values that a component is held to at every incident polar angle."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from gonio.dataset.scattering import FloatArray


def smooth_in_theta(theta_deg: FloatArray, values: FloatArray, at_deg: FloatArray) -> FloatArray:
    """Values (k, p) at `at_deg` (k,) of a smooth even function of theta through values (n, p) at ascending
    `theta_deg` (n,); beyond the last node the last value, below the first the mirror image about the normal.

    Monotone cubic pieces (Fritsch and Carlson 1980): no overshoot between nodes.
    """
    if len(theta_deg) == 1:
        return np.repeat(values, len(at_deg), axis=0)
    mirrored = theta_deg > 1e-6
    nodes = np.concatenate((-theta_deg[mirrored][::-1], theta_deg))
    through = np.concatenate((values[mirrored][::-1], values))
    return np.asarray(PchipInterpolator(nodes, through, axis=0)(np.clip(np.abs(at_deg), 0.0, theta_deg[-1])))


@dataclass(frozen=True)
class Tie:
    """rho or tau as a function of theta_i, smooth between `theta_deg` (n,), ascending; constant beyond the last."""

    theta_deg: FloatArray
    value: FloatArray
    source: str

    def at(self, theta_deg: FloatArray) -> FloatArray:
        """Value (k,) at angles (k,)."""
        return smooth_in_theta(self.theta_deg, self.value[:, None], theta_deg)[:, 0]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"theta_deg": self.theta_deg.tolist(), "value": self.value.tolist(), "source": self.source}

    @staticmethod
    def from_json(stored: dict[str, Any]) -> "Tie":
        """Inverse of `to_json`."""
        return Tie(np.array(stored["theta_deg"]), np.array(stored["value"]), str(stored["source"]))
