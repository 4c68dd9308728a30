"""truth_beside.py: what the same sums and fits give for a known truth, beside those of the measurement."""

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.reduce.coverage import cells_of_scattered
from gonio.reduce.integrals.peaks import FIELDS, Peak, evaluated_peak
from gonio.reduce.integrals.quadrature import side_weights
from gonio.reduce.integrals.results import weighted_sum

FloatArray = NDArray[np.float64]


class KnownTruth(Protocol):
    """A DSF in closed form; gonio.simulate.closed_form.Truth is one."""

    def dsf_per_sr(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr], shape (n,), towards unit vectors (n, 3), as seen through beam and aperture."""
        ...

    def integrals(self, incident_theta_deg: float, incident_phi_deg: float) -> dict[str, float]:
        """rho and tau of the sample itself."""
        ...


def beside(distribution: Distribution, truth: KnownTruth) -> dict[str, float]:
    """The truth's values for one measured distribution, by the names of distribution.integrals with an ending:

    rho_truth, tau_truth: of the sample itself, over its whole hemisphere; compare with rho_estimate.
    rho_truth_measured, tau_truth_measured: the same sum over the convolved DSF at exactly the measured, unmasked
    points; compare with rho_measured, tau_measured. A lobe behind the detector's head is missing in both.
    "peak NAME FIELD_truth" for each "peak NAME FIELD" in distribution.integrals, FIELD one of theta_deg, phi_deg,
    height_per_sr, sigma_deg, fwhm_deg, integral, ground_per_sr: the fit of the convolved DSF at the same directions
    with the same cells and masks. What a Gaussian on a plane makes of a lobe that is none is in both, and drops out.
    "peak NAME direction_error_deg": angle between the fitted direction and that of the truth's fit.

    The truth is asked for the incident direction that the axes read (incident_measured_theta_deg and _phi_deg in
    distribution.integrals), or for the nominal one where there is none. No entry for a peak that has no fit.
    """
    found = distribution.integrals
    incident = (
        found.get("incident_measured_theta_deg", distribution.incident_theta_deg),
        found.get("incident_measured_phi_deg", distribution.incident_phi_deg),
    )
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    known = replace(distribution, dsf_per_sr=truth.dsf_per_sr(*incident, unit), effects={})
    same_side = (distribution.theta_deg <= 90.0) == (distribution.incident_theta_deg <= 90.0)
    projected_sr = _projected_sr(distribution, unit)
    result: dict[str, float] = {}
    whole = truth.integrals(*incident)
    for name, side in (("rho", same_side), ("tau", ~same_side)):
        result[f"{name}_truth"] = whole[name]
        weights = side_weights(known, unit, side, projected_sr)
        result[f"{name}_truth_measured"] = weighted_sum(known, weights.corrected_sr).value
    for name, part in peak_points(distribution).items():
        peak, _ = evaluated_peak(known, part, name, unit)
        if peak is not None:
            result |= _named(name, peak, found)
    return result


def _projected_sr(distribution: Distribution, unit: FloatArray) -> FloatArray | None:
    """Projected solid angles (n,) of the cells of imported points, which were summed with them (reduce/imported.py);
    None for points of a path, and where the cells have another reach."""
    if len(distribution.path):
        return None
    found = cells_of_scattered(unit)
    same = np.allclose(found.solid_angle_sr, distribution.solid_angle_sr, rtol=1e-6, atol=1e-12)
    return np.abs(found.moment[:, 2]) if same else None


def peak_points(distribution: Distribution) -> dict[str, slice]:
    """Which points were flown about each fitted peak, by the peak's name."""
    ending = " first_point"
    names = [key[len("peak ") : -len(ending)] for key in distribution.integrals if key.endswith(ending)]
    found = {}
    for name in names:
        first = int(distribution.integrals[f"peak {name} first_point"])
        found[name] = slice(first, first + int(distribution.integrals[f"peak {name} points"]))
    return found


def _named(name: str, peak: Peak, found: dict[str, float]) -> dict[str, float]:
    result = {f"peak {name} {field}_truth": float(getattr(peak, field)) for field in FIELDS}
    measured = unit_from_angles_deg(found[f"peak {name} theta_deg"], found[f"peak {name} phi_deg"])
    known = unit_from_angles_deg(peak.theta_deg, peak.phi_deg)
    result[f"peak {name} direction_error_deg"] = float(angle_between_deg(measured, known))
    return result
