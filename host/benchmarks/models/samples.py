"""samples.py: scattering functions in closed form that models are judged by; each is a Scattering."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin

_MIRROR = np.array([-1.0, -1.0, 1.0])


def _angle_rad(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)))


@dataclass(frozen=True)
class RetroCoating:
    """DSF = 0.25/pi cos(theta_s) + 150 exp(-a^2/2/(1.2 deg)^2), a from retro, + 0.4 exp(-a^2/2/(12 deg)^2), a from
    mirror; front reflection only. Isotropic; integral about 0.25 + 0.413 + 0.10."""

    diffuse: float = 0.25
    retro_per_sr: float = 150.0
    retro_sigma_deg: float = 1.2
    mirror_per_sr: float = 0.4
    mirror_sigma_deg: float = 12.0

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        own = incident[0] if which is None else incident[which]
        z = outgoing[:, 2]
        retro = _angle_rad(outgoing, own) / np.radians(self.retro_sigma_deg)
        mirror = _angle_rad(outgoing, own * _MIRROR) / np.radians(self.mirror_sigma_deg)
        dsf = self.diffuse / np.pi * z + self.retro_per_sr * np.exp(-(retro**2) / 2)
        dsf += self.mirror_per_sr * np.exp(-(mirror**2) / 2)
        there = (z >= 0.0) & (np.broadcast_to(own[..., 2], z.shape) >= 0.0)
        return np.where(there, dsf, np.nan)

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering."""
        absent = np.isnan(self.dsf_per_sr(incident, outgoing, which))
        return np.where(absent, Origin.ABSENT, Origin.MEASURED).astype(np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return incident_front and outgoing_front

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        rows = np.flatnonzero(incident[:, 2] >= 0.0)
        return Features(incident[rows], np.full(len(rows), np.radians(self.retro_sigma_deg)), rows)
