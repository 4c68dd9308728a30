"""retro.py: a scan through the beam splitters as the distribution about the retro direction (paper [0], 2.3, 2.5)."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution, Polarisation
from gonio.dataset.effects import effect_of
from gonio.dataset.uncertainty import Uncertain, linear_result
from gonio.geometry.cells import cells
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, tangent_frame
from gonio.geometry.pitch import reach_rad
from gonio.merge.join import incident_unit
from gonio.merge.points import path_numbers, taken, units
from gonio.merge.splitter_view import REFERENCE_LAB, lab_from_sample, seen_in_splitter
from gonio.reduce.coverage import cells_of_paths
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

_SECTORS = 24  # of azimuth about the retro direction, in each of which the scan must reach out
_LEAST_REFERENCE = 20  # points over the reference beam
_TOP = 0.5  # of the maximum: what stands above that places the peak


@dataclass(frozen=True)
class Plate:
    """Reflectance and transmittance of one splitter at 45 degrees, for s and p polarised light."""

    reflectance_s: float
    reflectance_p: float
    transmittance_s: float
    transmittance_p: float

    def step(self, polarisation: Polarisation) -> float:
        """What a sample that depolarises completely reads too high by: <T><R> over <T R>, the means over the light's
        polarisation before and after the sample (slip S12 of paper [0])."""
        s = {"s": 1.0, "p": 0.0}.get(polarisation, 0.5)
        p = 1.0 - s
        arriving = s * self.transmittance_s + p * self.transmittance_p
        leaving = 0.5 * (self.reflectance_s + self.reflectance_p)
        reference = s * self.transmittance_s * self.reflectance_s + p * self.transmittance_p * self.reflectance_p
        return arriving * leaving / reference


@dataclass(frozen=True)
class RetroOptions:
    """The rig. Distances with standard uncertainty (k = 1); `radius_deg`: what is kept about the retro direction;
    `reference_deg`: how far out from (90, 180) the reference beam is summed.

    `plate` None: the splitters' polarisation is not corrected for. `depolarisation`: share of the light that leaves
    the sample depolarised; where it is not known, any share is as likely as any other: 1/2 with 1/sqrt(12).
    """

    arm_radius_mm: float = 1020.0
    sample_distance_mm: float = 105.0
    sample_distance_u_mm: float = 0.5
    radius_deg: float = 7.5
    reference_deg: float = 7.5
    plate: Plate | None = None
    depolarisation: float = 0.5
    depolarisation_u: float = 1.0 / np.sqrt(12.0)
    align: bool = False


@dataclass
class Retro:
    """The distribution about the retro direction, how far out it goes, and facts for the provenance."""

    distribution: Distribution
    radius_deg: float
    facts: dict[str, Any] = field(default_factory=dict)


def retro_distribution(
    rig: Distribution, reference: Distribution, polarisation: Polarisation, options: RetroOptions
) -> Retro:
    """The rig's points about the lab's (90, 0) as the sample's distribution about the retro direction.

    `reference` holds points about the lab's (90, 180): the rig's own ones (the source's light goes that way with the
    sample in place, too) or a scan without sample. The sample's light has gone through the splitter and been reflected,
    the reference's been reflected and gone through: T R against R T, so both cancel for s and for p light. P_i of the
    two datasets plays no part. Raises UsageError where points are missing.
    """
    power, reference_facts = _reference_power(reference, options.reference_deg)
    theta_deg, phi_deg = angles_deg_from_unit(incident_unit(rig))
    turn = lab_from_sample(float(theta_deg), float(phi_deg))
    ideal = turn[2]  # the source's direction in the sample frame
    lab = units(rig) @ turn.T
    view = seen_in_splitter(lab, options.arm_radius_mm, options.sample_distance_mm)
    outgoing = view.outgoing @ turn
    seen = angle_between_deg(outgoing, ideal) <= 2.0 * options.radius_deg
    if not (seen & rig.measured).any():
        raise UsageError(
            f"retro rig, incident ({rig.incident_theta_deg:g}, {rig.incident_phi_deg:g}): no point was measured about "
            "the lab's (90, 0): is this a scan through the beam splitters?"
        )
    found = _scaled(taken(rig, seen), view.dsf_factor[seen], power)
    _distance_effect(found, view.distance_mm[seen], outgoing[seen] @ ideal, options.sample_distance_u_mm)
    step = _depolarised(found, polarisation, options)
    unit = outgoing[seen]
    turned_deg = 0.0
    if options.align:
        unit, turned_deg = _aligned(unit, found, ideal, options.radius_deg)
    away_deg = angle_between_deg(unit, ideal)
    radius_deg = min(options.radius_deg, _covered_deg(unit[found.measured], ideal, rig))
    found.theta_deg, found.phi_deg = angles_deg_from_unit(unit)
    found = taken(found, away_deg <= radius_deg)
    unit = units(found)
    own = cells_of_paths(unit, path_numbers(found))
    found.solid_angle_sr, found.linear_solid_angle_sr = own.solid_angle_sr, own.linear_sr
    facts = {
        **reference_facts,
        "radius_deg": radius_deg,
        "way_longer_factor": float(np.median(view.dsf_factor[seen])),
        "points": len(found.theta_deg),
        "polarisation_step": step,
        "turned_deg": turned_deg,
    }
    return Retro(found, radius_deg, facts)


def beyond(distribution: Distribution, radius_deg: float) -> tuple[Distribution, int]:
    """The points farther than `radius_deg` from the retro direction, and how many others there were: the complementary
    filter on the scan without splitters."""
    far = angle_between_deg(units(distribution), incident_unit(distribution)) > radius_deg
    return taken(distribution, far), int((~far).sum())


def _reference_power(reference: Distribution, radius_deg: float) -> tuple[Uncertain, dict[str, Any]]:
    """sum E Omega over the reference beam, in signal sr, with what moves it besides P_i."""
    turn = lab_from_sample(*(float(v) for v in angles_deg_from_unit(incident_unit(reference))))
    near = reference.measured & (angle_between_deg(units(reference) @ turn.T, REFERENCE_LAB) <= radius_deg)
    if near.sum() < _LEAST_REFERENCE:
        raise UsageError(
            f"retro rig: {int(near.sum())} points within {radius_deg:g} degrees of the lab's (90, 180), where the "
            "reference beam arrives: scan it, or name a dataset that has it with --reference"
        )
    beam = _irradiance(taken(reference, near))
    unit = units(beam)
    area = cells(unit, reach_rad=reach_rad(unit, path_numbers(beam)), cut_at_horizon=False)
    # Cells are high on a peak, linear interpolation twice as high (CONVENTIONS.md): the difference is what is left.
    power = linear_result(beam, 2.0 * area.solid_angle_sr - area.linear_sr)
    quadrature = abs(float((area.solid_angle_sr - area.linear_sr) @ beam.dsf_per_sr))
    if not power.value > 0.0:
        raise UsageError("retro rig: the reference beam at the lab's (90, 180) adds up to nothing: check the scan")
    facts = {
        "reference_points": len(unit),
        "reference_power": power.value,
        "reference_quadrature_rel": quadrature / power.value,
        "reference_u_rel": float(np.hypot(power.u, quadrature)) / power.value,
    }
    return Uncertain(power.value, float(np.hypot(power.independent, quadrature)), power.effects), facts


def _irradiance(distribution: Distribution) -> Distribution:
    """With the DSF's columns times P_i: what the detector read over the monitor, which knows no error of P_i."""
    p_i = distribution.p_i
    effects = {k: p_i * c for k, c in distribution.effects.items() if effect_of(k).name != "p_i"}
    return replace(
        distribution,
        dsf_per_sr=p_i * distribution.dsf_per_sr,
        variance_per_sr2=p_i**2 * distribution.variance_per_sr2,
        effects=effects,
    )


def _scaled(rig: Distribution, factor: FloatArray, power: Uncertain) -> Distribution:
    """DSF = factor E / power, with the uncertainty of the power: what moves both alike cancels."""
    read = _irradiance(rig)
    by = factor / power.value
    dsf = by * read.dsf_per_sr
    effects = {key: by * column for key, column in read.effects.items()}
    for key, change in power.effects.items():
        effects[key] = effects.get(key, np.where(rig.measured, 0.0, np.nan)) - dsf * (change / power.value)
    effects["p_i rig"] = -dsf * (power.independent / power.value)
    return replace(
        rig,
        dsf_per_sr=dsf,
        variance_per_sr2=by**2 * read.variance_per_sr2,
        signal=rig.signal * factor,
        p_i=power.value,
        p_i_u_rel=0.0,
        effects=effects,
        integrals={name: value for name, value in rig.integrals.items() if name.startswith("incident_")},
        budgets={},
        linear_solid_angle_sr=np.zeros(0),
    )


def _distance_effect(found: Distribution, distance_mm: FloatArray, along: FloatArray, u_mm: float) -> None:
    """The factor goes with the square of the way, and the way grows with the sample's distance."""
    found.effects["distance rig"] = found.dsf_per_sr * 2.0 * along * u_mm / distance_mm


def _depolarised(found: Distribution, polarisation: Polarisation, options: RetroOptions) -> float:
    """Takes out what a depolarising sample reads too high by, and says what remains uncertain; the step's factor."""
    if options.plate is None:
        return 1.0
    excess = options.plate.step(polarisation) - 1.0
    factor = 1.0 + options.depolarisation * excess
    found.dsf_per_sr /= factor
    found.signal /= factor
    found.variance_per_sr2 /= factor**2
    found.effects = {key: column / factor for key, column in found.effects.items()}
    found.effects["p_i polarisation"] = -found.dsf_per_sr * (excess * options.depolarisation_u / factor)
    return factor


def _aligned(unit: FloatArray, found: Distribution, ideal: FloatArray, radius_deg: float) -> tuple[FloatArray, float]:
    """Directions turned so that the maximum, the centroid of what stands above half of it, lies in the ideal direction;
    degrees turned. Raises UsageError where the turn would be more than half the radius: then something else is off."""
    dsf = np.where(found.measured & (angle_between_deg(unit, ideal) <= radius_deg), found.dsf_per_sr, -np.inf)
    above = np.maximum(dsf - _TOP * dsf.max(), 0.0)
    area = cells(unit, cut_at_horizon=False).solid_angle_sr
    peak = (above * area) @ unit
    peak /= np.linalg.norm(peak)
    turned_deg = float(angle_between_deg(peak, ideal))
    if turned_deg > 0.5 * radius_deg:
        theta, phi = angles_deg_from_unit(peak)
        raise UsageError(
            f"retro rig: the maximum is at ({theta:.2f}, {phi:.2f}), {turned_deg:.2f} degrees off the retro direction: "
            "too far for an alignment; check the rig, or leave out --align"
        )
    return unit @ _rotation(peak, ideal).T, turned_deg


def _rotation(start: FloatArray, end: FloatArray) -> FloatArray:
    """The shortest rotation (3, 3) of unit vector `start` (3,) to `end` (Rodrigues' formula)."""
    v, c = np.cross(start, end), float(start @ end)
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + c))


def _covered_deg(unit: FloatArray, ideal: FloatArray, rig: Distribution) -> float:
    """How far out the points (n, 3) reach on all sides of the ideal direction. Raises UsageError where a side is
    empty."""
    e1, e2, _ = tangent_frame(ideal)
    sector = ((np.arctan2(unit @ e2, unit @ e1) / (2.0 * np.pi) % 1.0) * _SECTORS).astype(np.intp) % _SECTORS
    farthest = np.zeros(_SECTORS)
    np.maximum.at(farthest, sector, angle_between_deg(unit, ideal))
    if not farthest.all():
        raise UsageError(
            f"retro rig, incident ({rig.incident_theta_deg:g}, {rig.incident_phi_deg:g}): the scan does not surround "
            "the retro direction, the lab's (90, 0)"
        )
    return float(farthest.min())
