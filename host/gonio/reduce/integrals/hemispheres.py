"""hemispheres.py: what a distribution adds up to: reflectance, transmittance, and how much was measured."""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.integrals.cones import named_cones
from gonio.reduce.integrals.fill import fill_holes
from gonio.reduce.integrals.parts import parts
from gonio.reduce.integrals.quadrature import Weights, integral, left_u, side_weights
from gonio.reduce.integrals.results import Results, weighted_sum

FloatArray = NDArray[np.float64]

_BAND_DEG = 2.0


def integrals(distribution: Distribution, projected_sr: FloatArray | None = None) -> dict[str, float]:
    """The values of `evaluated` without budgets."""
    return evaluated(distribution, projected_sr).values


def evaluated(
    distribution: Distribution, projected_sr: FloatArray | None = None, beam: Distribution | None = None
) -> Results:
    """Integrals over the points' cells, with names as keys and budgets: of the DSF times solid angle, or, where the
    cells' projected solid angles (n,) are given, of the BSDF times those: better for cells so large that cos theta
    changes over them. NAME is rho for the hemisphere of the incident direction, tau for the other one.

    NAME_measured, NAME_u: over the measured cells, 2 V - P1 where the triangles are known (quadrature.py), and its
    combined standard uncertainty: noise, every effect, P_i, and `quadrature`, which is NAME_quadrature, |V - P1|. Its
    budget stands under NAME. NAME_voronoi: V alone. It is what the cells say: an outermost track owns directions up to
    its reach, 1.5 pitches, with its own values. Of a DSF that changes by s per rad across it that part is too low by
    about s times the square of the pitch for each rad of track, and no uncertainty tells (measured or estimate).
    NAME_filled, NAME_filled_u: what interpolation adds for masked and uncovered directions (fill.py), worth nothing
    where a peak is masked; the effect `coverage` is the interpolation's own. NAME_estimate, NAME_estimate_u: measured
    and filled together.
    NAME_measured_share: share of the cosine-weighted hemisphere that measured cells cover. For SIDE front and back:
    measured_share_SIDE: measured solid angle over 2 pi; measured_cosine_share_SIDE: the same weighted by cos theta,
    over pi; masked_sr_SIDE: of masked points; uncovered_sr_SIDE: 2 pi less all cells; unfilled_sr_SIDE: masked or
    uncovered and without a model, so in no estimate.
    "cone NAME 7" (cones.py); with the free beam given, regular and diffuse parts (parts.py).
    """
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    omega, measured, cosine = distribution.solid_angle_sr, distribution.measured, np.abs(unit[:, 2])
    projected = omega * cosine if projected_sr is None else projected_sr
    incident_up = distribution.incident_theta_deg <= 90.0
    up = distribution.theta_deg <= 90.0
    found = Results()
    sides: dict[bool, Weights] = {}
    for name, upper in (("rho", incident_up), ("tau", not incident_up)):
        side, of_side = up == upper, "front" if upper else "back"
        inside, outside = side & measured, side & ~measured
        if not omega[inside].any():
            continue  # nothing of this side was measured: no value, not a zero
        sides[upper] = weights = side_weights(distribution, unit, side, projected_sr)
        fill = fill_holes(distribution, unit, side)
        value = integral(distribution, weights)
        filled = weighted_sum(distribution, fill.weight)
        estimate = weighted_sum(distribution, weights.corrected_sr + fill.weight)
        found.put(f"{name}_measured", value)
        found.put(f"{name}_filled", filled.with_effect("coverage", fill.u))
        found.put(
            f"{name}_estimate",
            estimate.with_effect("quadrature", value.effects.get("quadrature", 0.0)).with_effect("coverage", fill.u),
        )
        # The uncertainty of NAME_measured keeps its short name.
        if f"{name}_measured_u" in found.values:
            found.values[f"{name}_u"] = found.values.pop(f"{name}_measured_u")
            found.budgets[name] = found.budgets.pop(f"{name}_measured")
        share = float(projected[inside].sum()) / np.pi
        found.values |= {
            f"{name}_voronoi": float(weights.cell_sr[inside] @ distribution.dsf_per_sr[inside]),
            f"{name}_measured_share": share,
            f"measured_share_{of_side}": float(omega[inside].sum()) / (2.0 * np.pi),
            f"measured_cosine_share_{of_side}": share,
            f"masked_sr_{of_side}": float(omega[outside].sum()),
            f"uncovered_sr_{of_side}": max(2.0 * np.pi - float(omega[side].sum()), 0.0),
            f"unfilled_sr_{of_side}": fill.unfilled_sr,
        }
        if weights.corrected:
            found.values[f"{name}_quadrature"] = left_u(distribution, weights)
    found.add(named_cones(distribution, unit, sides))
    if beam is not None:
        found.add(parts(distribution, unit, sides, beam))
    return found


def zero_forty_five(distribution: Distribution) -> float | None:
    """0:45 reflectance: pi times the mean BSDF within 2 degrees of theta = 45 degrees; None where that is not measured
    or incidence is not normal."""
    near = distribution.measured & (np.abs(distribution.theta_deg - 45.0) <= _BAND_DEG)
    if distribution.incident_theta_deg > 1.0 or not near.any():
        return None
    cosine = np.cos(np.radians(distribution.theta_deg[near]))
    return float(np.pi * np.mean(distribution.dsf_per_sr[near] / cosine))
