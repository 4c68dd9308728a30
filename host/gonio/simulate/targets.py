"""targets.py: what is to be simulated: the points of a measurement, one by one, or a grid for each incident
direction."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import MASKED, Dataset, Distribution, PointFlag
from gonio.geometry.cells import solid_angles_sr
from gonio.geometry.directions import fold_phi_deg, unit_from_angles_deg
from gonio.reduce.integrals.truth_beside import peak_points
from gonio.simulate.directions import BeamExtent, NamedPeak, grid
from gonio.simulate.readings import Job
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]
_INCIDENT_READ = ("incident_measured_theta_deg", "incident_measured_phi_deg", "incident_off_plan_deg")


@dataclass(frozen=True)
class Target:
    """One distribution to be: its directions (n, 3), flags and cells (n,), and which of its points lie about a peak.

    `traced_deg` is the incident direction that the axes read, where a measurement says it. `sought`: its peaks are
    wanted even if they hardly stand out."""

    channel: str
    band: str
    incident_deg: tuple[float, float]
    traced_deg: tuple[float, float]
    unit: FloatArray
    flags: NDArray[np.uint16]
    solid_angle_sr: FloatArray
    peaks: tuple[NamedPeak, ...]
    sought: bool
    integrals: dict[str, float] = field(default_factory=dict)  # as they are in the measurement

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which points get a value, (n,)."""
        return np.asarray(self.flags & MASKED == 0)

    def job(self, estimator: str, bandwidth: int) -> Job:
        """Its unmasked points, to be read."""
        directions = np.ascontiguousarray(self.unit[self.used])
        return Job(self.band, self.traced_deg, True, directions, estimator, bandwidth)


def targets_on_grid(
    bands: Sequence[str], incidents: Sequence[tuple[float, float]], step_deg: float, extent: BeamExtent
) -> list[Target]:
    """For each incident direction and, within it, each band."""
    found = []
    for theta_deg, phi_deg in incidents:
        incident = (theta_deg, float(fold_phi_deg(phi_deg)))
        unit, peaks = grid(incident, step_deg, extent)
        flags = np.full(len(unit), PointFlag.SIMULATED, dtype=np.uint16)
        omega = solid_angles_sr(unit)
        found += [Target(band, band, incident, incident, unit, flags, omega, peaks, sought=False) for band in bands]
    return found


def targets_like(measured: Dataset, bands: Sequence[str], source: str) -> list[Target]:
    """At exactly the points of a dataset, in its order. Masked points keep their flags, the others are marked
    simulated.

    A channel is simulated in the band of its name, or in the scenario's only one. Raises UsageError for another."""
    if not measured.distributions:
        raise UsageError(f"{source}: holds no distribution to follow")
    return [_like(d, _band_of(d.channel, bands, source)) for d in measured.distributions]


def _band_of(channel: str, bands: Sequence[str], source: str) -> str:
    if channel in bands:
        return channel
    if len(bands) == 1:
        return bands[0]
    raise UsageError(f'{source}: channel "{channel}" is none of the bands {", ".join(bands)}: name a [[band]] after it')


def _like(measured: Distribution, band: str) -> Target:
    incident = (measured.incident_theta_deg, measured.incident_phi_deg)
    carried = {name: measured.integrals[name] for name in _INCIDENT_READ if name in measured.integrals}
    read = tuple(carried.get(name, nominal) for name, nominal in zip(_INCIDENT_READ[:2], incident, strict=True))
    masked = measured.flags & MASKED
    return Target(
        channel=measured.channel,
        band=band,
        incident_deg=incident,
        traced_deg=(read[0], read[1]),
        unit=unit_from_angles_deg(measured.theta_deg, measured.phi_deg),
        flags=np.where(masked != 0, masked, np.uint16(PointFlag.SIMULATED)).astype(np.uint16),
        solid_angle_sr=measured.solid_angle_sr,
        peaks=tuple(NamedPeak(name, points) for name, points in peak_points(measured).items()),
        sought=True,
        integrals=carried,
    )
