"""masks.py: directions that the instrument cannot measure, and why."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.units.instrument import Instrument

NAME = "masks"
WHAT = "points masked where the detector's head shades the source"


def shade_angle_deg(instrument: Instrument, beam: dict[str, Any]) -> float:
    """Angle between source and detector below which the head takes light from the beam.

    Half the head plus half the beam where they cross (its diameter, or what its divergence makes of it there), and half
    an aperture, seen from the centre. `beam` is the plan's: diameter_mm, divergence_deg (full width).
    """
    half_rad = np.radians(0.5 * float(beam.get("divergence_deg", 0.0)))
    spread_mm = 2.0 * instrument.arm_radius_mm * float(np.tan(half_rad))
    at_head_mm = max(float(beam.get("diameter_mm", 0.0)), spread_mm)
    reach_mm = 0.5 * (instrument.head_diameter_mm + at_head_mm + instrument.detector_aperture_mm)
    return float(np.degrees(np.arctan2(reach_mm, instrument.arm_radius_mm)))


def shadowed(cosine_from_source: NDArray[np.float64], shade_deg: float) -> NDArray[np.bool_]:
    """Which detector directions are nearer to the source than the shade angle, by the cosine of the angle between both;
    arrays (n,)."""
    return np.asarray(cosine_from_source > np.cos(np.radians(shade_deg)))
