"""parts.py: regular and diffuse parts: what passes or is mirrored without scattering, and what is scattered."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.integrals.cones import cone_weights, direction_of
from gonio.reduce.integrals.quadrature import Weights
from gonio.reduce.integrals.results import Results, weighted_ratio, weighted_sum
from gonio.reduce.signature.profile import About, BeamProfile, beam_places

FloatArray = NDArray[np.float64]

NORMAL_DEG = 1.0  # incidence within this of the normal is normal
HAZE_HALF_ANGLE_DEG = 2.5  # ASTM D1003
HAZE_LEAST_SHARE = 0.9  # of the cosine-weighted hemisphere, that must be measured
_CONE_RADII = 1.6  # the fit's cone over the radius that holds the beam
_HELD = 0.05  # the beam's own sum over the points may miss 1 by this, or the points cannot tell
_LEAST_POINTS = 40
_ROUNDS = 4
_SIGNIFICANT = 5.0  # a regular part of so many standard uncertainties tells where it lies


@dataclass(frozen=True)
class Regular:
    """`weight` (n,): the regular part's share of the incident light is sum weight DSF. `beam_per_sr` (n,): the profile
    of unit integral where it was found. `half_angle_deg`: of the cone of the fit."""

    share: Uncertain
    weight: FloatArray
    beam_per_sr: FloatArray
    half_angle_deg: float
    off_deg: float  # from the ideal direction


def parts(distribution: Distribution, unit: FloatArray, sides: dict[bool, Weights], beam: Distribution) -> Results:
    """Results where the points suffice; `unit` (n, 3), `sides`: weights of the hemispheres by whether z >= 0.

    rho_direct, tau_direct (direct-direct): share of the incident light that leaves as the beam itself, mirrored or
    straight through: the amplitude of the measured free-beam profile, turned to that direction, beside a smooth ground,
    by least squares over a cone (NAME_direct_half_angle_deg). Scatter narrower than the beam counts as regular: no
    instrument of this beam tells them apart.
    rho_diffuse, tau_diffuse: hemispherical less regular, over the measured cells.
    openness: tau_direct at normal incidence: the share of light that passes a screen without scattering. Light that
    threads scatter forward is not in it.
    haze (ASTM D1003): share of the transmitted light that is scattered by more than 2.5 degrees, at normal incidence.
    The regular part is subtracted with the beam's own shape, so a beam wider than 2.5 degrees makes no haze.
    """
    found = Results()
    profile = BeamProfile.of(beam)
    named: tuple[tuple[str, About], ...] = (("tau", "through"), ("rho", "mirror"))
    for name, about in named:
        axis = unit_from_angles_deg(*direction_of(distribution, about))
        side = sides.get(bool(axis[2] >= 0.0))
        regular = None if side is None else regular_part(distribution, unit, side, profile, about)
        if side is None or regular is None:
            continue
        found.put(f"{name}_direct", regular.share)
        found.values[f"{name}_direct_half_angle_deg"] = regular.half_angle_deg
        found.values[f"{name}_direct_off_deg"] = regular.off_deg
        scattered = _scattered(side.corrected_sr, regular)
        left = _left(distribution, side, regular)
        found.put(f"{name}_diffuse", weighted_sum(distribution, scattered).with_effect("quadrature", left))
        if about != "through" or abs(90.0 - abs(90.0 - distribution.incident_theta_deg)) > NORMAL_DEG:
            continue
        found.put("openness", regular.share)
        cosine_share = float(np.abs(unit[:, 2]) @ side.cell_sr) / np.pi
        if cosine_share >= HAZE_LEAST_SHARE:
            near = cone_weights(distribution, unit, axis, HAZE_HALF_ANGLE_DEG, side)
            outside = _scattered(side.corrected_sr - near.corrected_sr, regular)
            try:
                haze = weighted_ratio(distribution, outside, side.corrected_sr)
            except ZeroDivisionError:
                continue
            whole = float(side.corrected_sr[distribution.measured] @ distribution.dsf_per_sr[distribution.measured])
            found.put("haze", haze.with_effect("quadrature", left / whole))
    return found


def regular_part(
    distribution: Distribution, unit: FloatArray, side: Weights, profile: BeamProfile, about: About
) -> Regular | None:
    """Fits DSF = share * beam(x - x0, y - y0) + a quadratic in x and y; the cells are the weights, so that the fit
    keeps the integral. None where the points lie too far apart for the beam, or masks leave too little of it.

    P_i cancels between sample and beam; the noise of the beam scan is in the uncertainty, and of noise and residuals
    the larger.
    """
    x, y = beam_places(unit, (distribution.incident_theta_deg, distribution.incident_phi_deg), about)
    reach = _CONE_RADII * profile.radius_rad
    x0, y0 = profile.centroid_rad
    near = np.flatnonzero((np.hypot(x - x0, y - y0) <= reach) & (side.cell_sr > 0.0))
    if len(near) < _LEAST_POINTS:
        return None
    x, y, cell, dsf = x[near], y[near], side.cell_sr[near], distribution.dsf_per_sr[near]
    root = np.sqrt(cell)
    u, v = (x - x0) / reach, (y - y0) / reach
    ground = np.stack((np.ones_like(u), u, v, u * u, u * v, v * v), axis=1)
    step = 0.02 * profile.fwhm_rad
    off = np.zeros(2)
    moving = True
    for _ in range(_ROUNDS):
        here = profile.at(x - off[0], y - off[1])
        held = float((side.corrected_sr[near]) @ here)
        if abs(held - 1.0) > _HELD:
            return None
        columns = [here[:, None], ground]
        if moving:
            px, py = x - off[0], y - off[1]
            along_x = profile.at(px - step, py) - profile.at(px + step, py)
            along_y = profile.at(px, py - step) - profile.at(px, py + step)
            columns.append(np.stack((along_x, along_y), axis=1) / (2.0 * step))
        design = np.concatenate(columns, axis=1)
        scale = np.linalg.norm(design * root[:, None], axis=0)
        operator = np.linalg.pinv(design * (root[:, None] / scale)) * root / scale[:, None]
        fitted = operator @ dsf
        noise = float(np.sqrt(operator[0] ** 2 @ distribution.variance_per_sr2[near]))
        scatter = float(np.linalg.norm(operator[0] * (dsf - design @ fitted)))
        if not moving:
            break
        shift = fitted[-2:] / fitted[0] if fitted[0] != 0.0 else np.full(2, np.inf)
        if abs(fitted[0]) < _SIGNIFICANT * np.hypot(noise, scatter) or np.hypot(*(off + shift)) > profile.fwhm_rad:
            off, moving = np.zeros(2), False  # nothing there that could tell a direction
        else:
            off = off + shift
    weight = np.zeros(len(unit))
    weight[near] = operator[0]
    beam_per_sr = np.zeros(len(unit))
    beam_per_sr[near] = here
    plain = weighted_sum(distribution, weight)
    effects = {key: change for key, change in plain.effects.items() if key.partition(" #")[0] != "p_i"}
    independent = float(np.hypot(max(noise, scatter), plain.value * profile.noise_rel))
    share = Uncertain(plain.value, independent, effects)
    return Regular(share, weight, beam_per_sr, float(np.degrees(reach)), float(np.degrees(np.hypot(*off))))


def _scattered(weight: FloatArray, regular: Regular) -> FloatArray:
    """Weights (n,) of the same sum over the DSF less the regular part."""
    return np.asarray(weight - float(weight @ regular.beam_per_sr) * regular.weight)


def _left(distribution: Distribution, side: Weights, regular: Regular) -> float:
    """|V - P1| of the scattered part."""
    used = distribution.measured
    return abs(float(_scattered(side.correction_sr, regular)[used] @ distribution.dsf_per_sr[used]))
