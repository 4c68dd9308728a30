"""shadow.py: where the detector's head stands in the beam: flown all the same, masked by the reduction."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.geometry.directions import angle_between_deg
from gonio.plan.schema import BeamPlan
from gonio.units.instrument import Instrument


def shading_angle_deg(instrument: Instrument, beam: BeamPlan) -> float:
    """Angle from the source within which the head takes light from the beam: half the head, half the beam there (its
    diameter, or what its divergence makes of it) and half an aperture, seen from the centre."""
    spread_mm = 2.0 * instrument.arm_radius_mm * float(np.tan(np.radians(0.5 * beam.divergence_deg)))
    at_head_mm = max(beam.diameter_mm, spread_mm)
    reach_mm = 0.5 * (instrument.head_diameter_mm + at_head_mm + instrument.detector_aperture_mm)
    return float(np.degrees(np.arctan2(reach_mm, instrument.arm_radius_mm)))


def shaded(incident: ArrayLike, outgoing: ArrayLike, angle_deg: float) -> NDArray[np.bool_]:
    """Which outgoing unit vectors (n, 3) lie within the shading angle of the incident ones (3,) or (n, 3)."""
    return np.asarray(angle_between_deg(incident, outgoing) < angle_deg)
