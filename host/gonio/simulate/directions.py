"""directions.py: where a simulation looks if it follows no measurement: rings over the sphere, spirals about the
peaks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import (
    angle_between_deg,
    mirror,
    retro,
    tangent_frame,
    through,
    unit_from_angles_deg,
)
from gonio.geometry.kinematics import SOURCE_LAB

FloatArray = NDArray[np.float64]

# The free beam is first looked for out to here, on rings.
PROBE_DEG = 20.0
_PROBE_STEP_DEG = 0.25
_PROBE_AZIMUTHS = 16
_LIT = 1e-3  # of the brightest ring: what is fainter is stray light
_TURNS = 20.0  # of the reference spiral across the beam's full width at half maximum: P_i to 0.01 % (reduce.beam)
_PEAK_TURNS = 12.0
_BEYOND = 1.25  # radius of the reference spiral over that of the beam: its rim must be dark
_PEAK_BEYOND_DEG = 2.0
_MOST_TURN_RAD = 0.8  # between two points of a spiral


@dataclass(frozen=True)
class BeamExtent:
    """How far the free beam reaches from its axis, and its full width at half maximum, as the detector sees it."""

    radius_deg: float
    width_deg: float


@dataclass(frozen=True)
class NamedPeak:
    """A spiral about an ideal direction among the points of a grid."""

    name: str
    points: slice


def rings(step_deg: float) -> FloatArray:
    """Unit vectors (n, 3) some `step_deg` apart over the whole sphere. The rings lie half a step from the horizon on
    both sides, so that no cell crosses it."""
    count = max(2, round(90.0 / step_deg))
    theta_deg = (np.arange(2 * count) + 0.5) * 90.0 / count
    parts = []
    for theta in theta_deg:
        azimuths = max(4, round(360.0 * np.sin(np.radians(theta)) * count / 90.0))
        parts.append(unit_from_angles_deg(theta, np.arange(azimuths) * 360.0 / azimuths))
    return np.concatenate(parts)


def spiral(centre: FloatArray, radius_deg: float, pitch_deg: float) -> FloatArray:
    """Unit vectors (n, 3) along an Archimedean spiral about `centre` (3,), half a pitch apart, from the centre
    outwards."""
    turn_rad = [0.0]
    growth = pitch_deg / (2.0 * np.pi)
    while growth * turn_rad[-1] < radius_deg:
        turn_rad.append(turn_rad[-1] + min(_MOST_TURN_RAD, 0.5 * pitch_deg / max(growth * turn_rad[-1], 1e-9)))
    azimuth = np.array(turn_rad)
    frame = tangent_frame(centre)
    local = unit_from_angles_deg(growth * azimuth, np.degrees(azimuth))
    return np.asarray(local @ frame)


def grid(
    incident_deg: tuple[float, float], step_deg: float, extent: BeamExtent
) -> tuple[FloatArray, tuple[NamedPeak, ...]]:
    """Directions (n, 3) to read for one incident direction: rings, then a spiral each about mirror, straight-through
    and retro direction (at normal incidence mirror and retro are one)."""
    parts = [rings(step_deg)]
    found: list[NamedPeak] = []
    centres: list[FloatArray] = []
    first = len(parts[0])
    for name, about in (("mirror", mirror), ("through", through), ("retro", retro)):
        centre = unit_from_angles_deg(*about(*incident_deg))
        if any(angle_between_deg(centre, other) < 0.5 * extent.width_deg for other in centres):
            continue
        centres.append(centre)
        parts.append(spiral(centre, extent.radius_deg + _PEAK_BEYOND_DEG, extent.width_deg / _PEAK_TURNS))
        named = f"{name} {incident_deg[0]:g}/{incident_deg[1]:g}"
        found.append(NamedPeak(named, slice(first, first + len(parts[-1]))))
        first += len(parts[-1])
    return np.concatenate(parts), tuple(found)


def beam_probe() -> FloatArray:
    """Unit vectors (rings * 16, 3), lab frame, on rings about straight through, to find the beam's extent."""
    polar = np.repeat(np.arange(0.0, PROBE_DEG, _PROBE_STEP_DEG), _PROBE_AZIMUTHS)
    azimuth = np.tile(np.arange(_PROBE_AZIMUTHS) * 360.0 / _PROBE_AZIMUTHS, len(polar) // _PROBE_AZIMUTHS)
    return about_beam(polar, azimuth)


def beam_extent(probed_per_sr: FloatArray) -> BeamExtent | None:
    """Extent of the beam from the readings (rings * 16,) at beam_probe(); None where no light came."""
    ring = probed_per_sr.reshape(-1, _PROBE_AZIMUTHS).mean(axis=1)
    if not ring.max() > 0.0:
        return None
    lit = np.flatnonzero(ring > _LIT * ring.max())
    bright = np.flatnonzero(ring > 0.5 * ring.max())
    return BeamExtent(_PROBE_STEP_DEG * float(lit[-1] + 1), 2.0 * _PROBE_STEP_DEG * float(bright[-1] + 0.5))


def beam_spiral(extent: BeamExtent) -> FloatArray:
    """Unit vectors (n, 3), lab frame, of the reference spiral over the free beam."""
    return spiral(-SOURCE_LAB, _BEYOND * extent.radius_deg, extent.width_deg / _TURNS)


def about_beam(polar_deg: FloatArray, azimuth_deg: FloatArray) -> FloatArray:
    """Unit vectors (n, 3), lab frame, from the angles of a dataset's free beam: polar about straight through, azimuth
    from the lab's +X towards its +Y."""
    return unit_from_angles_deg(180.0 - polar_deg, azimuth_deg)
