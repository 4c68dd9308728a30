"""spiral.py: Archimedean spiral around a direction on the sphere, by arc length, with exact derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gonio.geometry.directions import tangent_frame
from gonio.plan.knots import FloatArray

_STEP_RAD = 0.03  # of the spiral's own angle between samples: a sixth-order join is exact to 1e-9 of the radius


@dataclass(frozen=True)
class SphereTrack:
    """Unit vectors (n, 3) along a track and their derivatives by its length on the sphere, `length_deg` (n,) from 0."""

    length_deg: FloatArray
    unit: FloatArray
    d_unit: FloatArray  # per degree of length
    dd_unit: FloatArray  # per degree squared


def spiral(centre: ArrayLike, radius_deg: float, pitch_deg: float) -> SphereTrack:
    """Spiral from a unit vector (3,) out to `radius_deg`; neighbouring turns are `pitch_deg` apart.

    Every direction up to half a pitch inside the radius is within half a pitch of the track.

    With w the spiral's angle the polar angle from the centre is rho = pitch w / (2 pi); the length follows from
    ds/dw = sqrt(rho'^2 + sin(rho)^2).
    """
    growth = np.radians(pitch_deg) / (2.0 * np.pi)
    turns_rad = np.radians(radius_deg) / growth
    w = np.linspace(0.0, turns_rad, max(64, int(np.ceil(turns_rad / _STEP_RAD)) + 1))
    rho = growth * w
    sin_rho, cos_rho = np.sin(rho), np.cos(rho)
    speed = np.sqrt(growth**2 + sin_rho**2)  # ds/dw
    d_speed = growth * sin_rho * cos_rho / speed

    e1, e2, pole = tangent_frame(centre)
    outwards = np.cos(w)[:, None] * e1 + np.sin(w)[:, None] * e2
    around = -np.sin(w)[:, None] * e1 + np.cos(w)[:, None] * e2
    s, c = sin_rho[:, None], cos_rho[:, None]
    unit = c * pole + s * outwards
    by_w = growth * (c * outwards - s * pole) + s * around
    by_w_w = -(growth**2) * unit + 2.0 * growth * c * around - s * outwards

    # The trapezoid rule with its end correction has an error of order step^4.
    step = np.diff(w)
    steps = 0.5 * step * (speed[:-1] + speed[1:]) + step**2 / 12.0 * (d_speed[:-1] - d_speed[1:])
    length_rad = np.concatenate(([0.0], np.cumsum(steps)))
    per_deg = np.radians(1.0)
    d_unit = by_w / speed[:, None]
    dd_unit = by_w_w / speed[:, None] ** 2 - by_w * (d_speed / speed**3)[:, None]
    return SphereTrack(np.degrees(length_rad), unit, d_unit * per_deg, dd_unit * per_deg**2)
