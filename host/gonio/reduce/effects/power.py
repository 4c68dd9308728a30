"""power.py: the reference beam as the effects need it: how well P_i is known, and at what level it was measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import MASKED
from gonio.reduce.effects.signal import Level, level_of
from gonio.reduce.points import Points
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ReferenceBeam:
    """P_i [signal sr], its relative standard uncertainty, and the mean level of the light in it, shape (1,)."""

    p_i: float
    p_i_u_rel: float
    level: Level


def reference_beam(
    points: Points, solid_angle_sr: FloatArray, p_i_u_rel: float, instrument: Instrument
) -> ReferenceBeam:
    """From the points of the reference scan, their cells (n,), and the relative u of P_i from noise, skirt and
    quadrature; the offset of its own dark is added here, as one error that all its points share.

    It is not taken to be the error of the sample's dark: other stretches with the shutter closed give that one.
    """
    used = points.flags & MASKED == 0
    omega = solid_angle_sr[used] / points.normalisation[used]
    light = points.signal[used] * omega
    p_i = float(light.sum())
    level = level_of(points.signal[used], points.high_weight[used], instrument)
    mean = Level(np.array([level.high_share @ light / p_i]), np.array([level.of_full_scale @ light / p_i]))
    dark_u = float(points.dark_u_counts[used] @ omega)
    return ReferenceBeam(p_i, float(np.hypot(p_i_u_rel, dark_u / p_i)), mean)


def power_columns(dsf_per_sr: FloatArray, beam: ReferenceBeam) -> dict[str, FloatArray]:
    """Column (n,) of P_i [1/sr per standard deviation]: DSF = E / P_i falls as P_i rises."""
    return {"p_i": -dsf_per_sr * beam.p_i_u_rel}
