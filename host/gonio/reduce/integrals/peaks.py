"""peaks.py: direction, width and integral of a peak from the spiral flown about it, with their uncertainties."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.cells import cells
from gonio.geometry.directions import angles_deg_from_unit, tangent_frame, unit_from_angles_deg
from gonio.geometry.pitch import reach_rad
from gonio.reduce.integrals.peak_fit import Fit, fit_peak, ground_of_rim
from gonio.reduce.integrals.quadrature import left_of_peak_u
from gonio.reduce.integrals.results import Results, weighted_sum

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LEAST_TURNS = 10.0  # per full width at half maximum; with fewer a peak is under-sampled
FWHM_PER_SIGMA = 2.0 * np.sqrt(2.0 * np.log(2.0))

_LEAST_POINTS = 50
_MASKED_MOST = 0.1  # of the disc: with more masked, width and integral would be guesses
_MISFIT_MOST = 0.1  # of the peak: with more the peak is no Gaussian, and its fit's ground makes up for the shape
FIELDS = ("theta_deg", "phi_deg", "height_per_sr", "sigma_deg", "fwhm_deg", "integral", "ground_per_sr")


@dataclass(frozen=True)
class Peak:
    """A Gaussian on a plane ground, fitted by least squares with solid angles as weights; what beam and aperture add to
    its width is still in it."""

    theta_deg: float
    phi_deg: float
    height_per_sr: float  # above the ground
    sigma_deg: float
    integral: float  # of DSF - ground over the disc, 2 V - P1; of a peak that is no Gaussian: ground of the rim
    ground_per_sr: float  # at the peak
    solid_angle_sr: float  # of the disc
    masked_share: float
    turns: float  # of the path across the peak's full width at half maximum; nan: of points that no path flew
    # Weights (n,) of the disc's points in each of FIELDS, to first order, and the misfit's share of their deviation.
    weights: dict[str, FloatArray]
    scatter: dict[str, float]
    quadrature_u: float  # of the integral

    @property
    def fwhm_deg(self) -> float:
        """Full width at half maximum of the Gaussian."""
        return float(FWHM_PER_SIGMA * self.sigma_deg)

    def named(self, name: str) -> dict[str, float]:
        """As entries of Distribution.integrals: "peak NAME theta_deg" and so on."""
        result = {f"peak {name} {field}": float(getattr(self, field)) for field in (*FIELDS, "masked_share")}
        if np.isfinite(self.turns):
            result |= {
                f"peak {name} turns": self.turns,
                f"peak {name} undersampled": float(self.turns < LEAST_TURNS),
            }
        return result


def measure_peak(
    unit: FloatArray,
    dsf_per_sr: FloatArray,
    used: BoolArray,
    solid_angle_sr: FloatArray | None = None,
    linear_sr: FloatArray | None = None,
) -> Peak | None:
    """The peak in a spiral's points in the order they were flown: directions (n, 3), DSF (n,), which count (n,).

    `solid_angle_sr`, `linear_sr` (n,): cells and triangle weights; without them the points' own. None where too few
    points are usable or nothing stands above the ground.
    """
    if len(unit) < _LEAST_POINTS:
        return None
    if solid_angle_sr is None:
        own = cells(unit, reach_rad=reach_rad(unit, np.zeros(len(unit), dtype=np.int64)))
        solid_angle_sr, linear_sr = own.solid_angle_sr, own.linear_sr
    pole = unit.sum(axis=0)
    return _measured(unit, dsf_per_sr, used, (solid_angle_sr, linear_sr), pole / np.linalg.norm(pole), unit)


def evaluated_peak(
    distribution: Distribution, part: slice, name: str, unit: FloatArray | None = None
) -> tuple[Peak | None, Results]:
    """The peak that the path of the points `part` was flown about, from all points of the distribution within that
    path's disc, each with its own cell, and its entries with uncertainties and budgets: "peak NAME FIELD", FIELD_u,
    "peak NAME direction_u_deg" (root of the sum of squares along both tangents), "peak NAME turns" and "peak NAME
    undersampled" (1: fewer than LEAST_TURNS). `unit` (n, 3): the points' directions, where they are at hand.
    """
    if unit is None:
        unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    path = unit[part]
    if len(path) < _LEAST_POINTS:
        return None, Results()
    pole = path.sum(axis=0)
    pole /= np.linalg.norm(pole)
    disc = np.flatnonzero(unit @ pole >= (path @ pole).min())
    linear = distribution.linear_solid_angle_sr
    whole = (distribution.solid_angle_sr[disc], linear[disc] if len(linear) else None)
    peak = _measured(unit[disc], distribution.dsf_per_sr[disc], distribution.measured[disc], whole, pole, path)
    results = Results()
    if peak is None:
        return None, results
    found = {}
    for field in FIELDS:
        weight = np.zeros(len(unit))
        weight[disc] = peak.weights[field]
        change = weighted_sum(distribution, weight)
        independent = max(change.independent, peak.scatter[field])
        value = Uncertain(float(getattr(peak, field)), independent, change.effects)
        if field == "integral":
            value = value.with_effect("quadrature", peak.quadrature_u)
        results.put(f"peak {name} {field}", value)
        found[field] = value
    results.values |= peak.named(name)
    sine = np.sin(np.radians(peak.theta_deg))
    results.values[f"peak {name} direction_u_deg"] = float(np.hypot(found["theta_deg"].u, sine * found["phi_deg"].u))
    return peak, results


def undersampled_note(name: str, peak: Peak) -> list[str]:
    """One sentence for the user about a peak with too few turns."""
    if not peak.turns < LEAST_TURNS:
        return []
    return [
        f"peak {name} is under-sampled: {peak.turns:.1f} turns per full width at half maximum ({peak.fwhm_deg:.2g} "
        f"deg), fewer than {LEAST_TURNS:g}: plan its spiral with a pitch of {peak.fwhm_deg / LEAST_TURNS:.2g} deg"
    ]


def _measured(
    unit: FloatArray,
    dsf_per_sr: FloatArray,
    used: BoolArray,
    areas: tuple[FloatArray, FloatArray | None],
    pole: FloatArray,
    path: FloatArray,
) -> Peak | None:
    """From a disc's points (n, 3) with cells and triangle weights (n,); `path` (m, 3): the spiral among them."""
    omega, linear = areas
    whole = float(omega.sum())
    counts = used & (omega > 0.0)
    if not whole > 0.0:
        return None
    masked_share = float(omega[~used].sum() / whole)
    if counts.sum() < _LEAST_POINTS or masked_share > _MASKED_MOST:
        return None
    frame = tangent_frame(pole)
    x, y = _equidistant(unit[counts], frame)
    dsf, weight = dsf_per_sr[counts], omega[counts]
    fit = fit_peak(x, y, dsf, weight)
    if fit is None:
        return None
    rim, rim_operator = ground_of_rim(x, y, dsf, weight)
    ground_terms = np.stack((np.ones_like(x), x, y), axis=1)
    plane, plane_operator = fit.plane, fit.operator[4:]
    misfit = np.abs(fit.residual) @ weight
    if misfit > _MISFIT_MOST * (np.abs(dsf - ground_terms @ rim) @ weight):
        plane, plane_operator = rim, rim_operator
    above = dsf - ground_terms @ plane
    # The disc's border cuts cells and triangles differently; above the ground nothing is left there to be counted.
    corrected = weight if linear is None else 2.0 * weight - linear[counts]
    removed = 0.0 if linear is None else float((weight - linear[counts]) @ above)
    integral = float(corrected @ above)
    direction, angles, slopes = _top(fit, frame)
    at_peak = np.array([1.0, fit.x0, fit.y0])
    of_ground = at_peak @ plane_operator + plane[1] * fit.operator[1] + plane[2] * fit.operator[2]
    operators = {
        "theta_deg": slopes[0] @ fit.operator[1:3],
        "phi_deg": slopes[1] @ fit.operator[1:3],
        "height_per_sr": fit.operator[0],
        "sigma_deg": np.degrees(fit.operator[3]),
        "fwhm_deg": np.degrees(fit.operator[3]) * FWHM_PER_SIGMA,
        "integral": corrected - (corrected @ ground_terms) @ plane_operator,
        "ground_per_sr": of_ground,
    }
    width = FWHM_PER_SIGMA * fit.sigma
    return Peak(
        theta_deg=angles[0],
        phi_deg=angles[1],
        height_per_sr=fit.height,
        sigma_deg=float(np.degrees(fit.sigma)),
        integral=integral,
        ground_per_sr=float(at_peak @ plane),
        solid_angle_sr=whole,
        masked_share=masked_share,
        turns=_turns(unit, omega, path, direction, width),
        weights={field: _spread(counts, operator) for field, operator in operators.items()},
        scatter={field: float(np.linalg.norm(operator * fit.residual)) for field, operator in operators.items()},
        quadrature_u=left_of_peak_u(integral, removed, 0.0),
    )


def _turns(unit: FloatArray, omega: FloatArray, path: FloatArray, direction: FloatArray, width: float) -> float:
    """Of the path (m, 3) across the width [rad] about a direction (3,)."""
    chord = 2.0 * np.sin(0.25 * min(width, np.pi))
    near = np.linalg.norm(path - direction, axis=1) <= chord
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    steps = np.append(0.5 * steps, 0.0) + np.append(0.0, 0.5 * steps)
    length = float(steps[near].sum())
    area = float(omega[np.linalg.norm(unit - direction, axis=1) <= chord].sum())
    return width * length / area if length > 0.0 and area > 0.0 else float("nan")


def _top(fit: Fit, frame: FloatArray) -> tuple[FloatArray, tuple[float, float], FloatArray]:
    """The peak's direction (3,), its angles in degrees, and their change in degrees per rad of x0 and y0, (2, 2)."""

    def direction(x0: float, y0: float) -> FloatArray:
        radius = float(np.hypot(x0, y0))
        across = np.sin(radius) / radius if radius > 0.0 else 1.0
        return np.asarray(across * (x0 * frame[0] + y0 * frame[1]) + np.cos(radius) * frame[2])

    top = direction(fit.x0, fit.y0)
    theta_deg, phi_deg = (float(angle) for angle in angles_deg_from_unit(top))
    along_x = direction(fit.x0 + 1e-6, fit.y0) - top
    along_y = direction(fit.x0, fit.y0 + 1e-6) - top
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    e_theta = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    e_phi = np.array([-np.sin(phi), np.cos(phi), 0.0])
    sine = max(float(np.sin(theta)), 1e-3)  # at the normal phi has no meaning, and no bound
    steps = np.stack((along_x, along_y), axis=1) / 1e-6
    return top, (theta_deg, phi_deg), np.degrees(np.stack((e_theta @ steps, e_phi @ steps / sine)))


def _spread(chosen: BoolArray, values: FloatArray) -> FloatArray:
    result = np.zeros(len(chosen))
    result[chosen] = values
    return result


def _equidistant(unit: FloatArray, frame: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane coordinates in radians whose length is the angle from the frame's pole (azimuthal equidistant map)."""
    a, b = unit @ frame[0], unit @ frame[1]
    across = np.hypot(a, b)
    scale = np.where(across > 1e-12, np.arctan2(across, unit @ frame[2]) / np.maximum(across, 1e-12), 1.0)
    return a * scale, b * scale
