"""integrals.py: what a distribution adds up to: reflectance, transmittance, and how much of the sphere was measured."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.cells import hemisphere_solid_angles_sr, solid_angles_sr
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

# A masked direction takes the value of the measured one next to it, but not from farther than this.
FILL_REACH_DEG = 6.0


def cells_of(unit: FloatArray) -> FloatArray:
    """Solid angles (n,) of directions (n, 3): over the whole sphere, or cut at the horizon if all lie on one side."""
    one_side = len(unit) > 0 and (np.all(unit[:, 2] >= 0.0) or np.all(unit[:, 2] <= 0.0))
    return hemisphere_solid_angles_sr(unit) if one_side else solid_angles_sr(unit)


def integrals(distribution: Distribution) -> dict[str, float]:
    """Sums over the points' cells, plain solid angle, with names as keys.

    rho, tau: over the hemisphere of the incident direction and the other one; directions that are masked hold the
    value of their nearest measured neighbour within FILL_REACH_DEG (rho_filled, tau_filled is that part; the rest
    counts as 0). rho_u, tau_u: standard uncertainty from noise and P_i. measured_share_*: measured solid angle
    over 2 pi; measured_cosine_share_*: the same weighted by cos theta, over pi. masked_sr_*: solid angle of the masked
    points.
    """
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    omega, measured = distribution.solid_angle_sr, distribution.measured
    incident_up = distribution.incident_theta_deg <= 90.0
    same_side = (distribution.theta_deg <= 90.0) == incident_up
    value = np.where(measured, distribution.dsf_per_sr, 0.0)
    fill = fill_masked(unit, distribution.dsf_per_sr, measured)
    result: dict[str, float] = {}
    for name, of_side, side in (
        ("rho", "front" if incident_up else "back", same_side),
        ("tau", "back" if incident_up else "front", ~same_side),
    ):
        inside, outside = side & measured, side & ~measured
        own, filled = float(value[inside] @ omega[inside]), float(fill[outside] @ omega[outside])
        noise2 = float(distribution.variance_per_sr2[inside] @ omega[inside] ** 2)
        result[name] = own + filled
        result[f"{name}_filled"] = filled
        result[f"{name}_u"] = float(np.hypot(np.sqrt(noise2), distribution.p_i_u_rel * own))
        result[f"measured_share_{of_side}"] = float(omega[inside].sum()) / (2.0 * np.pi)
        result[f"measured_cosine_share_{of_side}"] = float(omega[inside] @ np.abs(unit[inside, 2])) / np.pi
        result[f"masked_sr_{of_side}"] = float(omega[outside].sum())
    return result


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
