"""hemispheres.py: directions of Radiance's frame in the sample's, by hemisphere, and what a scattering gives there."""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import FloatArray, IndexArray, Scattering
from gonio.formats.window.klems import LightSide, Process
from gonio.units.errors import UsageError

_MOST_AT_ONCE = 1_000_000  # directions in one call


@dataclass(frozen=True)
class Component:
    """One matrix's pair of hemispheres. Polar angles count from each hemisphere's own normal, azimuths are those of
    WINDOW's patches: of a column the source's plus 180 degrees."""

    scattering: Scattering
    process: Process
    side: LightSide
    front_faces: Side

    def __post_init__(self) -> None:
        if self.front_faces == "undeclared":
            raise UsageError(
                "it is not declared which way the sample's front faces: give --front exterior or --front interior"
            )

    @property
    def _turn(self) -> FloatArray:
        """Radiance's frame to the sample's: half a turn about y when the front faces the exterior."""
        return np.array([1.0, 1.0, 1.0]) if self.front_faces == "interior" else np.array([-1.0, 1.0, -1.0])

    @property
    def _incident_z(self) -> float:
        return -1.0 if self.side == "Front" else 1.0

    @property
    def _outgoing_z(self) -> float:
        return 1.0 if (self.side == "Front") == (self.process == "Transmission") else -1.0

    def covered(self) -> bool:
        """Whether the scattering has anything here."""
        turned = self._turn[2]
        return self.scattering.covers(
            incident_front=self._incident_z * turned > 0, outgoing_front=self._outgoing_z * turned > 0
        )

    def incident(self, polar_rad: FloatArray, azimuth_rad: FloatArray) -> FloatArray:
        """Unit vectors (n, 3) of ours towards the source of a column's directions."""
        across = np.sin(polar_rad)
        unit = np.stack(
            (
                -across * np.cos(azimuth_rad),
                -across * np.sin(azimuth_rad),
                self._incident_z * np.cos(polar_rad),
            ),
            axis=-1,
        )
        return np.asarray(unit * self._turn)

    def outgoing(self, polar_rad: FloatArray, azimuth_rad: FloatArray) -> FloatArray:
        """Unit vectors (n, 3) of ours of a row's directions."""
        across = np.sin(polar_rad)
        unit = np.stack(
            (across * np.cos(azimuth_rad), across * np.sin(azimuth_rad), self._outgoing_z * np.cos(polar_rad)), axis=-1
        )
        return np.asarray(unit * self._turn)

    def place_of_incident(self, unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Polar angle and column azimuth [rad] (n,) of unit vectors of ours (n, 3); polar over 90 degrees: the other
        side's light."""
        own = np.atleast_2d(unit) * self._turn
        polar = np.arccos(np.clip(own[:, 2] * self._incident_z, -1.0, 1.0))
        return polar, np.arctan2(-own[:, 1], -own[:, 0])

    def values(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray) -> FloatArray:
        """DSF (m,); where the scattering has nothing, 0. Always asked with all of `incident`: models remember it."""
        result = np.empty(len(outgoing))
        for first in range(0, len(outgoing), _MOST_AT_ONCE):
            part = slice(first, first + _MOST_AT_ONCE)
            result[part] = self.scattering.dsf_per_sr(incident, outgoing[part], which[part])
        return np.nan_to_num(result, copy=False)

    def peaks(self, incident: FloatArray) -> tuple[FloatArray, FloatArray, IndexArray]:
        """Narrow peaks (p,) of this hemisphere or near it: centres (p, 3), sigma [rad], row of the incident."""
        found = self.scattering.features(incident)
        z = found.centre[:, 2] * self._turn[2] * self._outgoing_z
        here = z > -5.0 * found.sigma_rad
        return found.centre[here], found.sigma_rad[here], found.incident[here]
