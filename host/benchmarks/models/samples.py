"""samples.py: scattering functions in closed form that models are judged by; each is a Scattering."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin

_MIRROR = np.array([-1.0, -1.0, 1.0])


def _angle_rad(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)))


class _FrontReflection(ABC):
    """What samples have in common that are known for reflection from the front, and there everywhere."""

    @abstractmethod
    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering."""
        absent = np.isnan(self.dsf_per_sr(incident, outgoing, which))
        return np.where(absent, Origin.ABSENT, Origin.MEASURED).astype(np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return incident_front and outgoing_front


@dataclass(frozen=True)
class RetroCoating(_FrontReflection):
    """DSF = 0.25/pi cos(theta_s) + 150 exp(-a^2/2/(1.2 deg)^2), a from retro, + 0.4 exp(-a^2/2/(12 deg)^2), a from
    mirror; front reflection only. Isotropic; integral about 0.25 + 0.413 + 0.10.

    With `tail_power` p the retro peak is 150 (1 + a^2/(2 p sigma^2))^-p instead, which no Gaussian fits."""

    diffuse: float = 0.25
    retro_per_sr: float = 150.0
    retro_sigma_deg: float = 1.2
    mirror_per_sr: float = 0.4
    mirror_sigma_deg: float = 12.0
    tail_power: float | None = None

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        own = incident[0] if which is None else incident[which]
        z = outgoing[:, 2]
        retro = _angle_rad(outgoing, own) / np.radians(self.retro_sigma_deg)
        mirror = _angle_rad(outgoing, own * _MIRROR) / np.radians(self.mirror_sigma_deg)
        p = self.tail_power
        shape = np.exp(-(retro**2) / 2) if p is None else (1.0 + retro**2 / (2.0 * p)) ** -p
        dsf = self.diffuse / np.pi * z + self.retro_per_sr * shape
        dsf += self.mirror_per_sr * np.exp(-(mirror**2) / 2)
        there = (z >= 0.0) & (np.broadcast_to(own[..., 2], z.shape) >= 0.0)
        return np.where(there, dsf, np.nan)

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        rows = np.flatnonzero(incident[:, 2] >= 0.0)
        return Features(incident[rows], np.full(len(rows), np.radians(self.retro_sigma_deg)), rows)


@dataclass(frozen=True)
class Facet:
    """Mirror facets tilted about the sample's x axis, blurred: a lobe about the mirror direction of the facet."""

    tilt_deg: float  # of the facet's normal towards +y
    peak_per_sr: float
    sigma_deg: float

    def centre(self, incident: FloatArray) -> FloatArray:
        """Unit vectors (k, 3) of the lobe for incident (k, 3)."""
        tilt = np.radians(self.tilt_deg)
        normal = np.array([0.0, np.sin(tilt), np.cos(tilt)])
        return np.asarray(2.0 * (incident @ normal)[:, None] * normal - incident)


@dataclass(frozen=True)
class TwoPeaked(_FrontReflection):
    """A strong lobe and a weak, wider one at 14 degrees from it, of facets tilted up and down unequally, over diffuse
    light: DSF = 0.2/pi cos(theta_s) + sum of peak exp(-a^2/2/sigma^2); front reflection only.

    Anisotropic and lopsided: left-right symmetric (bilateral), not up-down. Integral about 0.2 + 0.48 + 0.10.
    """

    diffuse: float = 0.2
    facets: tuple[Facet, ...] = (Facet(3.0, 40.0, 2.5), Facet(-4.0, 2.0, 5.0))

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        own = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        dsf = self.diffuse / np.pi * outgoing[:, 2]
        for facet in self.facets:
            angle = _angle_rad(outgoing, facet.centre(incident)[own]) / np.radians(facet.sigma_deg)
            dsf = dsf + facet.peak_per_sr * np.exp(-(angle**2) / 2)
        return np.where((outgoing[:, 2] >= 0.0) & (incident[own, 2] >= 0.0), dsf, np.nan)

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        rows = np.flatnonzero(incident[:, 2] >= 0.0)
        centre = np.concatenate([facet.centre(incident[rows]) for facet in self.facets])
        sigma = np.repeat([np.radians(facet.sigma_deg) for facet in self.facets], len(rows))
        return Features(centre, sigma, np.tile(rows, len(self.facets)))
