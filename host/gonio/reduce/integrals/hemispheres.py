"""integrals.py: what a distribution adds up to: reflectance, transmittance, and how much of the sphere was measured."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

# A masked direction takes the value of the measured one next to it, but not from farther than this.
FILL_REACH_DEG = 6.0
_BAND_DEG = 2.0
_GRAZING = 1e-6  # cosine below which a BSDF means nothing


def integrals(distribution: Distribution, projected_sr: FloatArray | None = None) -> dict[str, float]:
    """Sums over the points' cells, with names as keys: DSF times solid angle, or, where the cells' projected solid
    angles (n,) are given, BSDF times those: better for cells so large that cos theta changes over them.

    rho_measured, tau_measured: over the measured cells of the hemisphere of the incident direction and of the other
    one. rho_u, tau_u: their standard uncertainty from noise and P_i. rho_filled, tau_filled: what masked directions
    would add if they held the value of their nearest measured neighbour within FILL_REACH_DEG: a guess, good where the
    distribution is smooth, and worth nothing where a peak is masked; rho_estimate, tau_estimate: with it.
    rho_measured_share, tau_measured_share: share of the cosine-weighted hemisphere that measured cells cover.
    measured_share_*: measured solid angle over 2 pi; measured_cosine_share_*: the same weighted by cos theta, over pi.
    masked_sr_*: solid angle of the masked points.
    """
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    omega, measured, cosine = distribution.solid_angle_sr, distribution.measured, np.abs(unit[:, 2])
    projected = omega * cosine if projected_sr is None else projected_sr
    weight = omega if projected_sr is None else projected_sr / np.maximum(cosine, _GRAZING)
    incident_up = distribution.incident_theta_deg <= 90.0
    same_side = (distribution.theta_deg <= 90.0) == incident_up
    fill = fill_masked(unit, distribution.dsf_per_sr, measured)
    result: dict[str, float] = {}
    for name, of_side, side in (
        ("rho", "front" if incident_up else "back", same_side),
        ("tau", "back" if incident_up else "front", ~same_side),
    ):
        inside, outside = side & measured, side & ~measured
        if not omega[inside].any():
            continue  # nothing of this side was measured: no value, not a zero
        own, filled = float(distribution.dsf_per_sr[inside] @ weight[inside]), float(fill[outside] @ weight[outside])
        noise2 = float(distribution.variance_per_sr2[inside] @ weight[inside] ** 2)
        share = float(projected[inside].sum()) / np.pi
        result[f"{name}_estimate"] = own + filled
        result[f"{name}_measured"] = own
        result[f"{name}_filled"] = filled
        result[f"{name}_u"] = float(np.hypot(np.sqrt(noise2), distribution.p_i_u_rel * own))
        result[f"{name}_measured_share"] = share
        result[f"measured_share_{of_side}"] = float(omega[inside].sum()) / (2.0 * np.pi)
        result[f"measured_cosine_share_{of_side}"] = share
        result[f"masked_sr_{of_side}"] = float(omega[outside].sum())
    return result


def zero_forty_five(distribution: Distribution) -> float | None:
    """0:45 reflectance: pi times the mean BSDF within 2 degrees of theta = 45 degrees; None where that is not measured
    or incidence is not normal."""
    near = distribution.measured & (np.abs(distribution.theta_deg - 45.0) <= _BAND_DEG)
    if distribution.incident_theta_deg > 1.0 or not near.any():
        return None
    cosine = np.cos(np.radians(distribution.theta_deg[near]))
    return float(np.pi * np.mean(distribution.dsf_per_sr[near] / cosine))


def fill_masked(unit: FloatArray, dsf_per_sr: FloatArray, measured: NDArray[np.bool_]) -> FloatArray:
    """DSF (n,) at masked directions from the nearest measured one within FILL_REACH_DEG, 0 where there is none and at
    measured ones."""
    filled = np.zeros(len(unit))
    masked = np.flatnonzero(~measured)
    if not len(masked) or not measured.any():
        return filled
    reach = 2.0 * np.sin(np.radians(0.5 * FILL_REACH_DEG))
    distance, neighbour = cKDTree(unit[measured]).query(unit[masked], distance_upper_bound=reach)
    near = np.isfinite(distance)
    filled[masked[near]] = dsf_per_sr[measured][neighbour[near]]
    return filled
