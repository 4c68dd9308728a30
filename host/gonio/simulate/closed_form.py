"""closed_form.py: what an ideal instrument would read from a scenario's sample, seen through beam and aperture.

The convolution is a plain quadrature over both discs, written apart from the twin's optics: the two check each other.
"""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

from gonio.geometry.directions import angle_between_deg, mirror, retro, tangent_frame, through, unit_from_angles_deg
from gonio.simulate.scenario import Scenario, load_scenario

FloatArray = NDArray[np.float64]
Zonal = Callable[[FloatArray], FloatArray]  # of the angle to an axis, in radians

_ABOUT = {"mirror": mirror, "retro": retro, "through": through}
_LOBE_REACH_SIGMA = 9.0


def beam_profile(scenario: Scenario) -> Zonal:
    """Radiance of the beam over angle from its axis, 1 in the middle: a top hat with a raised-cosine edge."""
    radius, edge = np.radians(0.5 * scenario.divergence_deg), np.radians(scenario.edge_deg)

    def profile(angle_rad: FloatArray) -> FloatArray:
        if edge == 0.0:
            return np.asarray(np.where(angle_rad <= radius, 1.0, 0.0))
        inwards = np.clip((radius - angle_rad) / edge + 0.5, 0.0, 1.0)
        return np.asarray(0.5 * (1.0 - np.cos(np.pi * inwards)))

    return profile


def disc_average(function: Zonal, weight: Zonal, radius_rad: float, angle_rad: FloatArray) -> FloatArray:
    """Average (n,) of a zonal function over discs about directions at `angle_rad` (n,) from its axis, weighted over the
    angle from each disc's centre; product quadrature: Gauss-Legendre over the radius, midpoints over azimuth."""
    node, share = np.polynomial.legendre.leggauss(48)
    beta = 0.5 * radius_rad * (node + 1.0)
    share = share * np.sin(beta) * weight(beta)
    azimuth = (np.arange(96) + 0.5) * np.pi / 96  # the other half mirrors this one
    result = np.empty(len(angle_rad))
    for index, angle in enumerate(angle_rad):
        haversine = np.sin(0.5 * (angle - beta[:, None])) ** 2
        haversine = haversine + np.sin(angle) * np.sin(beta[:, None]) * np.sin(0.5 * azimuth) ** 2
        apart = 2.0 * np.arcsin(np.sqrt(np.minimum(haversine, 1.0)))
        result[index] = share @ function(apart).mean(axis=1)
    return np.asarray(result / share.sum())


class Truth:
    """Closed-form DSF of a scenario's sample, bare and as the instrument sees it."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        instrument = scenario.instrument
        self._aperture_rad = float(np.arctan2(0.5 * instrument.detector_aperture_mm, instrument.arm_radius_mm))
        self._beam_rad = float(np.radians(0.5 * (scenario.divergence_deg + scenario.edge_deg)))
        self._lobes: dict[float, Zonal] = {}

    @classmethod
    def from_scenario(cls, path: Path) -> "Truth":
        """Raises UsageError for a scenario that cannot be read."""
        return cls(load_scenario(path))

    def dsf_per_sr(
        self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray, *, convolved: bool = True
    ) -> FloatArray:
        """DSF [1/sr], shape (n,), towards unit vectors (n, 3) of the sample frame; bare, the straight-through beam is
        left out (it is no function). Shading by the detector's head is not in it."""
        vectors = np.atleast_2d(np.asarray(outgoing, dtype=np.float64))
        incident_up = np.cos(np.radians(incident_theta_deg)) >= 0.0
        from_normal = np.arccos(np.clip(vectors[:, 2] if incident_up else -vectors[:, 2], -1.0, 1.0))
        cosine = self._convolved_cosine if convolved else _cosine
        total = np.zeros(len(vectors))
        for part in self.scenario.components:
            if part["kind"] == "lambertian":
                total += part.get("reflectance", 0.0) / np.pi * cosine(from_normal)
                total += part.get("transmittance", 0.0) / np.pi * cosine(np.pi - from_normal)
            elif part["kind"] == "gaussian":
                axis = _axis(part, incident_theta_deg, incident_phi_deg)
                apart = np.radians(angle_between_deg(vectors, axis))
                sigma = np.radians(part["sigma_deg"])
                total += part.get("integral", 1.0) * (self._convolved_lobe(sigma) if convolved else _lobe(sigma))(apart)
            elif convolved:
                axis = unit_from_angles_deg(*through(incident_theta_deg, incident_phi_deg))
                apart = np.radians(angle_between_deg(vectors, axis))
                total += part.get("transmittance", 1.0) * self._convolved_beam(apart)
        return total

    def beam_per_sr(self, angle_deg: FloatArray) -> FloatArray:
        """The free beam seen through the aperture, of unit integral [1/sr], at angles (n,) from its axis."""
        return self._convolved_beam(np.radians(np.asarray(angle_deg, dtype=np.float64)))

    def integrals(self, incident_theta_deg: float, incident_phi_deg: float) -> dict[str, float]:
        """rho (hemisphere of the incident direction) and tau (the other one) of the bare sample."""
        up = 1.0 if np.cos(np.radians(incident_theta_deg)) >= 0.0 else -1.0
        rho = tau = 0.0
        for part in self.scenario.components:
            if part["kind"] == "gaussian":
                axis = _axis(part, incident_theta_deg, incident_phi_deg)
                same = _share_above(_lobe(np.radians(part["sigma_deg"])), np.radians(part["sigma_deg"]), up * axis)
                rho += part.get("integral", 1.0) * same
                tau += part.get("integral", 1.0) * (1.0 - same)
            elif part["kind"] == "straight-through":
                tau += part.get("transmittance", 1.0)
            else:
                rho += part.get("reflectance", 0.0)
                tau += part.get("transmittance", 0.0)
        return {"rho": float(rho), "tau": float(tau)}

    def peak_sigma_deg(self, sigma_deg: float) -> float:
        """Standard deviation per axis, from second moments in the small-angle limit, of a lobe seen through beam and
        aperture: the variances of the three add up."""
        profile = beam_profile(self.scenario)

        def moment(power: int) -> float:
            return float(quad(lambda a: a**power * float(profile(np.array(a))), 0.0, self._beam_rad, limit=200)[0])

        variance = np.radians(sigma_deg) ** 2 + 0.25 * self._aperture_rad**2 + 0.5 * moment(3) / moment(1)
        return float(np.degrees(np.sqrt(variance)))

    def _seen(self, function: Zonal, angle_rad: FloatArray) -> Zonal:
        """The zonal function averaged over aperture and beam, as a spline through `angle_rad` (n,)."""
        everywhere: Zonal = np.ones_like
        over_aperture = CubicSpline(angle_rad, disc_average(function, everywhere, self._aperture_rad, angle_rad))
        end = angle_rad[-1]

        def held(angle: FloatArray) -> FloatArray:
            return np.asarray(over_aperture(np.clip(angle, 0.0, end)))

        seen = CubicSpline(angle_rad, disc_average(held, beam_profile(self.scenario), self._beam_rad, angle_rad))
        return lambda angle: np.asarray(np.where(angle <= end, seen(np.minimum(angle, end)), 0.0))

    def _convolved_lobe(self, sigma_rad: float) -> Zonal:
        if sigma_rad not in self._lobes:
            end = min(np.pi, _LOBE_REACH_SIGMA * sigma_rad + self._beam_rad + self._aperture_rad)
            grid = np.linspace(0.0, end, max(300, int(20 * end / sigma_rad)))
            self._lobes[sigma_rad] = self._seen(_lobe(sigma_rad), grid)
        return self._lobes[sigma_rad]

    @cached_property
    def _convolved_cosine(self) -> Zonal:
        reach = 1.2 * (self._beam_rad + self._aperture_rad)
        horizon = 0.5 * np.pi + np.linspace(-reach, reach, 201)
        grid = np.concatenate((np.linspace(0.0, horizon[0], 60)[:-1], horizon, [np.pi - 0.5, np.pi]))
        return self._seen(_cosine, grid)

    @cached_property
    def _convolved_beam(self) -> Zonal:
        profile, everywhere = beam_profile(self.scenario), np.ones_like
        end = self._beam_rad + self._aperture_rad
        grid = np.linspace(0.0, end, 400)
        norm = quad(lambda a: 2.0 * np.pi * np.sin(a) * float(profile(np.array(a))), 0.0, self._beam_rad, limit=200)[0]
        seen = CubicSpline(grid, disc_average(profile, everywhere, self._aperture_rad, grid) / norm)
        return lambda angle: np.asarray(np.where(angle <= end, seen(np.minimum(angle, end)), 0.0))


class BareTruth:
    """The DSF of a truth's sample itself, as no instrument sees it; the straight-through beam, no function, is not in
    it."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth

    def dsf_per_sr(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr] (n,) towards unit vectors (n, 3)."""
        return self._truth.dsf_per_sr(incident_theta_deg, incident_phi_deg, outgoing, convolved=False)


def _cosine(angle_rad: FloatArray) -> FloatArray:
    return np.maximum(np.cos(angle_rad), 0.0)


def _lobe(sigma_rad: float) -> Zonal:
    """Gaussian of the angle with unit integral over the sphere [1/sr]."""
    end = min(np.pi, _LOBE_REACH_SIGMA * sigma_rad)

    def over_ring(angle: float) -> float:
        return float(2.0 * np.pi * np.sin(angle) * np.exp(-0.5 * (angle / sigma_rad) ** 2))

    norm = quad(over_ring, 0.0, end, limit=200)[0]
    return lambda angle: np.asarray(np.exp(-0.5 * (angle / sigma_rad) ** 2) / norm)


def _axis(part: dict[str, Any], incident_theta_deg: float, incident_phi_deg: float) -> FloatArray:
    return unit_from_angles_deg(*_ABOUT[part["about"]](incident_theta_deg, incident_phi_deg))


def _share_above(lobe: Zonal, sigma_rad: float, axis: FloatArray) -> float:
    """Share of a lobe of unit integral about a unit vector (3,) that lies in the hemisphere z > 0."""
    e1, e2, pole = tangent_frame(axis)
    end = min(np.pi, _LOBE_REACH_SIGMA * sigma_rad)
    node, weight = np.polynomial.legendre.leggauss(200)
    angle = 0.5 * end * (node + 1.0)
    ring = 0.5 * end * weight * np.sin(angle) * lobe(angle)
    # On the circle at that angle z = cos(angle) pole_z + sin(angle) slant cos(azimuth): the arc above 0 in closed form.
    slant = np.sin(angle) * np.hypot(e1[2], e2[2])
    level = np.clip(np.cos(angle) * pole[2] / np.maximum(slant, 1e-300), -1.0, 1.0)
    return float(ring @ (2.0 * np.pi - 2.0 * np.arccos(level)))
