"""assembly.py: readings as distributions of a dataset: scaled by the free beam, with variance, flags, integrals,
peaks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.geometry.directions import angles_deg_from_unit
from gonio.reduce.integrals.beam import Beam, measure_beam
from gonio.reduce.integrals.hemispheres import integrals
from gonio.reduce.integrals.peaks import Peak, measure_peak
from gonio.simulate.directions import NamedPeak
from gonio.simulate.readings import Reading
from gonio.simulate.targets import Target
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

_MOST_COUNT = np.iinfo(np.int32).max
_LOW_SIGMA = 3.0  # as the reduction has it
# A peak that nobody named is one if it is narrower than its disc, higher than its ground and above its noise.
_WIDEST = 0.5
_LEAST_RISE = 0.2
_LEAST_SIGMA = 5.0
# The directions lie too far apart if their sum misses the photons' count by more than noise and this share of it.
_MISSED_SIGMA = 5.0
_MISSED_LEAST = 0.01


@dataclass(frozen=True)
class FreeBeam:
    """The free beam in one band: P_i as the reduction takes it, and its distribution."""

    beam: Beam
    distribution: Distribution


def free_beam(
    band: str, wavelength_nm: float | None, unit: FloatArray, used: NDArray[np.bool_], reading: Reading
) -> FreeBeam:
    """P_i from the readings (those of `used` directions) at directions (n, 3), lab frame, of a spiral over the beam.
    Raises UsageError where no light comes."""
    signal, variance, hits = np.zeros(len(unit)), np.zeros(len(unit)), np.zeros(len(unit), dtype=np.int32)
    signal[used], variance[used] = reading.signal_per_sr, reading.error_per_sr**2
    hits[used] = np.minimum(reading.hits, _MOST_COUNT)
    beam = measure_beam(unit, signal, variance, used)
    if not beam.p_i > 0.0:
        raise UsageError(f'P_i is {beam.p_i:g} in the band "{band}": no light comes straight through; check [beam]')
    distribution = Distribution(
        incident_theta_deg=0.0,
        incident_phi_deg=0.0,
        theta_deg=beam.polar_deg,
        phi_deg=beam.azimuth_deg,
        dsf_per_sr=np.where(used, signal / beam.p_i, np.nan),
        variance_per_sr2=np.where(used, variance / beam.p_i**2, np.nan),
        signal=signal,
        normalisation=np.ones(len(unit)),
        count=hits,
        flags=np.where(used, np.uint16(PointFlag.SIMULATED), np.uint16(PointFlag.NOT_MEASURED)).astype(np.uint16),
        solid_angle_sr=beam.solid_angle_sr,
        time_ns=np.zeros(len(unit), dtype=np.int64),
        channel=band,
        wavelength_nm=wavelength_nm,
        p_i=beam.p_i,
        p_i_u_rel=beam.p_i_u_rel,
        integrals={"centroid_x_deg": beam.centroid_x_deg, "centroid_y_deg": beam.centroid_y_deg},
    )
    return FreeBeam(beam, distribution)


def distribution_of(target: Target, reading: Reading, beam: FreeBeam) -> Distribution:
    """The target's points with the values read at its unmasked ones; masked points have NaN."""
    n, used = len(target.unit), target.used
    signal, error = np.full(n, np.nan), np.full(n, np.nan)
    signal[used], error[used] = reading.signal_per_sr, reading.error_per_sr
    count = np.zeros(n, dtype=np.int32)
    count[used] = np.minimum(reading.hits, _MOST_COUNT)
    p_i = beam.beam.p_i
    low = used & (np.nan_to_num(signal) < _LOW_SIGMA * np.nan_to_num(error))
    if reading.balance:
        low |= used & (count == 0)  # no photon came: the error of that is not known, and stands as 0
    theta_deg, phi_deg = angles_deg_from_unit(target.unit)
    result = Distribution(
        incident_theta_deg=target.incident_deg[0],
        incident_phi_deg=target.incident_deg[1],
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        dsf_per_sr=signal / p_i,
        variance_per_sr2=(error / p_i) ** 2,
        signal=signal,
        normalisation=np.ones(n),
        count=count,
        flags=target.flags | np.where(low, np.uint16(PointFlag.LOW_SIGNAL), np.uint16(0)),
        solid_angle_sr=target.solid_angle_sr,
        time_ns=np.zeros(n, dtype=np.int64),
        channel=target.channel,
        wavelength_nm=beam.distribution.wavelength_nm,
        p_i=p_i,
        p_i_u_rel=beam.beam.p_i_u_rel,
    )
    overlap = overlap_factor(reading.aperture_sr, target.solid_angle_sr)
    sums = replace(result, variance_per_sr2=result.variance_per_sr2 * overlap)
    result.integrals = integrals(sums) | _counted(target.incident_deg[0], reading.balance) | target.integrals
    for peak in target.peaks:
        result.integrals |= _peak(target, peak, sums)
    return result


def overlap_factor(aperture_sr: float, solid_angle_sr: FloatArray) -> FloatArray:
    """Factor (n,) on the variances of points when they are added: apertures larger than their points' cells overlap,
    and a photon that is in many is no more than one photon."""
    return np.maximum(1.0, aperture_sr / np.where(solid_angle_sr > 0.0, solid_angle_sr, np.inf))


def _counted(incident_theta_deg: float, balance: dict[str, int]) -> dict[str, float]:
    """rho_counted, tau_counted: what reached each hemisphere over what was emitted, every photon counted: free of the
    error of a sum over directions. rho_counted_u, tau_counted_u: standard uncertainties."""
    if not balance:
        return {}
    emitted, photons = balance["emitted"], balance["photons"]
    unit = emitted / photons  # whole weight of one photon
    front, back = balance["stored_front"], balance["stored"] - balance["stored_front"]
    sides = [("front", front), ("back", back)]
    result: dict[str, float] = {}
    for name, (side, stored) in zip(("rho", "tau"), sides if incident_theta_deg <= 90.0 else sides[::-1], strict=True):
        mean = stored / emitted
        mean_square = balance[f"{side}_square"] / unit / photons
        result[f"{name}_counted"] = mean
        result[f"{name}_counted_u"] = float(np.sqrt(max(mean_square - mean**2, 0.0) / photons))
    return result


def far_apart(distributions: Sequence[Distribution]) -> list[str]:
    """Where the sum over directions misses what was counted: one sentence each."""
    remarks = []
    for d in distributions:
        for name in ("rho", "tau"):
            counted, points = d.integrals.get(f"{name}_counted"), d.integrals.get(f"{name}_measured")
            if counted is None or points is None or not d.measured.all():
                continue
            noise = float(np.hypot(d.integrals[f"{name}_u"], d.integrals[f"{name}_counted_u"]))
            if abs(points - counted) > max(_MISSED_SIGMA * noise, _MISSED_LEAST * counted):
                remarks.append(
                    f"{d.channel}, incident ({d.incident_theta_deg:g}, {d.incident_phi_deg:g}): the directions that "
                    f"were read add up to {name} {points:.4f}, the photons to {counted:.4f}: trust the photons, or "
                    "read closer with [readings] step_deg"
                )
    return remarks


def _peak(target: Target, named: NamedPeak, distribution: Distribution) -> dict[str, float]:
    """Entries of a peak as the reduction writes them; none where there is no peak."""
    part, omega = named.points, distribution.solid_angle_sr[named.points]
    used = distribution.measured[part]
    found = measure_peak(target.unit[part], distribution.dsf_per_sr[part], used)
    if found is None:
        return {}
    noise = float(np.sqrt(np.sum(np.where(used, distribution.variance_per_sr2[part], 0.0) * omega**2)))
    if not target.sought and not _stands_out(found, noise):
        return {}
    start, stop = part.start, part.stop
    place = {f"peak {named.name} first_point": float(start), f"peak {named.name} points": float(stop - start)}
    return found.named(named.name) | place


def _stands_out(peak: Peak, noise: float) -> bool:
    radius_deg = np.degrees(np.arccos(max(1.0 - peak.solid_angle_sr / (2.0 * np.pi), -1.0)))
    narrow = peak.sigma_deg < _WIDEST * radius_deg
    return bool(
        narrow and peak.height_per_sr > _LEAST_RISE * peak.ground_per_sr and peak.integral > _LEAST_SIGMA * noise
    )
