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
_CONE_RADII = 2.0  # the fit's cone over the radius that holds the beam
_NARROWER = 0.8  # the other cone that is tried, over this one
_DEGREE, _OTHER_DEGREE = 4, 2  # of the ground's polynomial, and of the other one that is tried
_HELD = 0.05  # the beam's own sum over the points may miss 1 by this, or the points cannot tell
_LEAST_POINTS = 40
_ROUNDS = 4
_FOUND = 1e-4  # of the full width at half maximum: a smaller step needs no more rounds
# What moves or scales beam and sample alike does not change how much of the one is in the other.
_NOT_OF_SHAPE = ("p_i", "axis_second", "tilt_second")
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
    """Fits DSF = share * beam(x - x0, y - y0) + a ground, a polynomial of fourth degree in x and y, which follows a
    smooth lobe; the cells are the weights. None where the points lie too far apart for the beam, or masks leave too
    little of it.

    What a ground of second degree, or a cone 0.8 times as wide, would change, the larger of the two, is the effect
    `ground`: on a lobe about as narrow as the beam it is most of the uncertainty, as shape alone tells them
    apart. A regular part that is less than five standard uncertainties is not looked for off its ideal direction.

    P_i cancels between sample and beam; the noise of the beam scan is in the uncertainty, and of noise and residuals
    the larger. The beam's place is fitted, so an error of angle that all points share moves it and nothing else: to
    first order the fit's own slopes see to that, to second order the points' columns hold the curvature of a beam that
    stays where it is, and are left out.
    """
    reach = _CONE_RADII * profile.radius_rad
    x0, y0 = profile.centroid_rad
    axis = unit_from_angles_deg(*direction_of(distribution, about))
    near = np.flatnonzero((unit @ axis >= np.cos(reach + np.hypot(x0, y0))) & (side.cell_sr > 0.0))
    x, y = beam_places(unit[near], (distribution.incident_theta_deg, distribution.incident_phi_deg), about)
    radius = np.hypot(x - x0, y - y0)
    inside = radius <= reach
    near, x, y, radius = near[inside], x[inside], y[inside], radius[inside]
    if len(near) < _LEAST_POINTS:
        return None
    cell, dsf = side.cell_sr[near], distribution.dsf_per_sr[near]
    ground = _polynomial((x - x0) / reach, (y - y0) / reach)
    narrower = radius <= _NARROWER * reach
    off = np.zeros(2)
    for _ in range(_ROUNDS):
        here, along = _beam_and_slopes(profile, x - off[0], y - off[1])
        if abs(float(side.corrected_sr[near] @ here) - 1.0) > _HELD:
            return None
        design = np.concatenate((here[:, None], along, ground), axis=1)
        operator, residual = _fitted(design, cell, dsf)
        share = float(operator[0] @ dsf)
        lower = _fitted(design[:, : 3 + _terms(_OTHER_DEGREE)], cell, dsf)[0][0]
        within = _fitted(design[narrower], cell[narrower], dsf[narrower])[0][0]
        others = (float(lower @ dsf) - share, float(within @ dsf[narrower]) - share)
        of_ground = max(others, key=abs)
        noise = float(np.sqrt(operator[0] ** 2 @ distribution.variance_per_sr2[near]))
        scatter = float(np.linalg.norm(operator[0] * residual))
        significant = abs(share) > _SIGNIFICANT * float(np.linalg.norm([noise, scatter, of_ground]))
        shift = operator[1:3] @ dsf / share if significant else np.full(2, np.inf)
        if not np.hypot(*(off + shift)) <= profile.fwhm_rad:  # nothing there that could tell a direction
            if off.any():
                off = np.zeros(2)
                here, _ = _beam_and_slopes(profile, x, y)
                design[:, 0] = here
            operator, residual = _fitted(np.delete(design, (1, 2), axis=1), cell, dsf)
            scatter = float(np.linalg.norm(operator[0] * residual))
            break
        if np.hypot(*shift) < _FOUND * profile.fwhm_rad:
            break
        off = off + shift
    weight = np.zeros(len(unit))
    weight[near] = operator[0]
    beam_per_sr = np.zeros(len(unit))
    beam_per_sr[near] = here
    plain = weighted_sum(distribution, weight)
    effects = {key: change for key, change in plain.effects.items() if key.partition(" #")[0] not in _NOT_OF_SHAPE}
    independent = float(np.hypot(max(plain.independent, scatter), plain.value * profile.noise_rel))
    found = Uncertain(plain.value, independent, effects).with_effect("ground", of_ground)
    return Regular(found, weight, beam_per_sr, float(np.degrees(reach)), float(np.degrees(np.hypot(*off))))


def _beam_and_slopes(profile: BeamProfile, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The beam at places (n,), and what it changes by (n, 2) where it moves along x and y [1/(sr rad)]."""
    step = 0.02 * profile.fwhm_rad
    along_x = profile.at(x - step, y) - profile.at(x + step, y)
    along_y = profile.at(x, y - step) - profile.at(x, y + step)
    return profile.at(x, y), np.stack((along_x, along_y), axis=1) / (2.0 * step)


def _fitted(design: FloatArray, cell: FloatArray, dsf: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Change (3, n) of the first three coefficients per change of each value, by weighted least squares, and the
    residuals (n,)."""
    weighted = design * cell[:, None]
    scale = np.sqrt(np.einsum("ij,ij->j", design, weighted))
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv(design.T @ weighted / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    return inverse[:3] @ weighted.T, dsf - design @ (inverse @ (weighted.T @ dsf))


def _polynomial(u: FloatArray, v: FloatArray) -> FloatArray:
    """Terms (n, 15) by rising degree."""
    return np.stack([u ** (d - k) * v**k for d in range(_DEGREE + 1) for k in range(d + 1)], axis=1)


def _terms(degree: int) -> int:
    return (degree + 1) * (degree + 2) // 2


def _scattered(weight: FloatArray, regular: Regular) -> FloatArray:
    """Weights (n,) of the same sum over the DSF less the regular part."""
    return np.asarray(weight - float(weight @ regular.beam_per_sr) * regular.weight)


def _left(distribution: Distribution, side: Weights, regular: Regular) -> float:
    """|V - P1| of the scattered part."""
    used = distribution.measured
    return abs(float(_scattered(side.correction_sr, regular)[used] @ distribution.dsf_per_sr[used]))
