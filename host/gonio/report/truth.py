"""truth.py: what the report needs from a known answer; gonio.simulate.closed_form.Truth has it."""

import re
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import mirror, retro, through

FloatArray = NDArray[np.float64]
_ABOUT = {"mirror": mirror, "retro": retro, "through": through}
_PEAK_KEY = re.compile(r"peak (?P<name>.+) (?P<field>\w+)")


class DsfTruth(Protocol):
    """A DSF known in closed form, convolved with beam and aperture."""

    scenario: Any  # .components: the sample's parts, mappings as in the scenario file

    def dsf_per_sr(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr], shape (n,), towards unit vectors (n, 3)."""
        ...

    def integrals(self, incident_theta_deg: float, incident_phi_deg: float) -> dict[str, float]:
        """rho and tau of the sample."""
        ...

    def peak_sigma_deg(self, sigma_deg: float) -> float:
        """Sigma of a lobe as the instrument sees it."""
        ...


@dataclass(frozen=True)
class ExpectedPeak:
    theta_deg: float
    phi_deg: float
    sigma_deg: float  # as the instrument sees it
    integral: float


def expected_peaks(truth: DsfTruth, incident_theta_deg: float, incident_phi_deg: float) -> dict[str, ExpectedPeak]:
    """Peaks of the truth by the direction they are named after; a direction with several lobes has no single answer."""
    found: dict[str, list[ExpectedPeak]] = {}
    for part in truth.scenario.components:
        if part["kind"] == "gaussian":
            name, sigma, integral = str(part["about"]), float(part["sigma_deg"]), float(part["integral"])
        elif part["kind"] == "straight-through":
            name, sigma, integral = "through", 0.0, float(part["transmittance"])
        else:
            continue
        theta, phi = _ABOUT[name](incident_theta_deg, incident_phi_deg)
        found.setdefault(name, []).append(ExpectedPeak(float(theta), float(phi), truth.peak_sigma_deg(sigma), integral))
    return {name: peaks[0] for name, peaks in found.items() if len(peaks) == 1}


def measured_peaks(d: Distribution) -> dict[str, dict[str, float]]:
    """Peaks of a distribution by name, from its integrals "peak NAME field"."""
    peaks: dict[str, dict[str, float]] = {}
    for key, value in d.integrals.items():
        match = _PEAK_KEY.fullmatch(key)
        if match:
            peaks.setdefault(match["name"], {})[match["field"]] = value
    return peaks
