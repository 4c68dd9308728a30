"""plane_profile.py: the scatter plane: points near the plane of incidence in narrow bins, with uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

_BANDS_DEG = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 4.0)  # half widths about the plane of incidence, tried in turn
_SHOWN_DEG, _ENOUGH = 3.0, 0.85  # a band shows enough with this share of the bins that the widest one fills
BIN_DEG = 0.1  # the step of comparisons along the scatter plane (CONVENTIONS.md)
_GAP_STEPS, _LEAST_GAP_DEG = 4.0, 0.6  # a step of more than so many usual ones is a gap


@dataclass(frozen=True)
class PlaneProfile:
    """Means of the measured points in bins along the plane of incidence, arrays (n,) by rising angle.

    `angle_deg` is the mean angle of a bin's points, signed: positive on the mirror side, over 90 behind.
    """

    angle_deg: FloatArray
    dsf_per_sr: FloatArray
    u_independent: FloatArray  # standard uncertainty of the mean, noise alone [1/sr]
    u_combined: FloatArray  # the same with all effects, fully correlated within the bin [1/sr]
    gap_before: NDArray[np.bool_]  # nothing measured, or masked points, between this bin and the one before
    masked_deg: FloatArray  # (m, 2) first and last angle of each run of masked points
    point: NDArray[np.int64]  # (k,) points in the bins, by rising angle
    bin_of_point: NDArray[np.int64]  # (k,)
    band_deg: float  # half width of the band about the plane

    def mean(self, values: FloatArray) -> FloatArray:
        """Means per bin (n,) of values (k,) given for `point`."""
        count = np.bincount(self.bin_of_point, minlength=len(self.angle_deg))
        return np.bincount(self.bin_of_point, values, len(self.angle_deg)) / count


def plane_profile(d: Distribution, bin_deg: float = BIN_DEG) -> PlaneProfile:
    """Profile of a distribution along its plane of incidence.

    The band about the plane is the narrowest that shows nearly as much of the plane as the widest one does.
    """
    angle, across = plane_angles_deg(d)
    distance = np.where(d.measured, np.abs(across), np.inf)

    def shown(band: float) -> int:
        return len(np.unique(np.floor(angle[distance <= band] / _SHOWN_DEG)))

    most = shown(_BANDS_DEG[-1])
    band = next(b for b in _BANDS_DEG if shown(b) >= _ENOUGH * most)
    point = np.flatnonzero(distance <= band)
    point = point[np.argsort(angle[point], kind="stable")]
    _, bin_of = np.unique(np.floor(angle[point] / bin_deg), return_inverse=True)
    count = np.maximum(np.bincount(bin_of), 1) if len(point) else np.zeros(0)

    def mean(values: FloatArray) -> FloatArray:
        return np.bincount(bin_of, values[point], len(count)) / count

    independent = mean(d.variance_per_sr2) / count
    systematic = np.zeros(len(count))
    for column in d.effects.values():
        systematic += mean(column) ** 2
    at = mean(angle)
    masked = np.sort(angle[~d.measured & (np.abs(across) <= band)])
    return PlaneProfile(
        at,
        mean(d.dsf_per_sr),
        np.sqrt(independent),
        np.sqrt(independent + systematic),
        _gaps(at, masked),
        _runs(masked, at),
        point,
        bin_of,
        band,
    )


def plane_angles_deg(d: Distribution) -> tuple[FloatArray, FloatArray]:
    """Signed angle of each point in the plane of incidence and its distance from that plane, (n,) [degrees]."""
    units = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    phi = np.radians(d.incident_phi_deg)
    towards_mirror = np.array([-np.cos(phi), -np.sin(phi), 0.0])
    across = np.degrees(np.arcsin(np.clip(units @ np.array([np.sin(phi), -np.cos(phi), 0.0]), -1, 1)))
    return np.degrees(np.arctan2(units @ towards_mirror, units[:, 2])), across


def plane_directions(d: Distribution, angle_deg: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) of signed angles in the plane of incidence."""
    return unit_from_angles_deg(angle_deg, d.incident_phi_deg + 180.0)


def folded_deg(angle_deg: FloatArray) -> FloatArray:
    """Signed angles from the nearer normal: 150 becomes 30, -150 becomes -30."""
    return np.where(np.abs(angle_deg) <= 90, angle_deg, np.sign(angle_deg) * (180.0 - np.abs(angle_deg)))


def _gaps(at: FloatArray, masked: FloatArray) -> NDArray[np.bool_]:
    """Where a line through the bins must break, (n,)."""
    if len(at) < 2:
        return np.zeros(len(at), dtype=np.bool_)
    step = np.diff(at)
    wide = step > max(_GAP_STEPS * float(np.median(step)), _LEAST_GAP_DEG)
    between = np.searchsorted(masked, at[1:]) > np.searchsorted(masked, at[:-1])
    return np.concatenate([[False], wide | (between & (step > 2 * BIN_DEG))])


def _runs(masked: FloatArray, measured: FloatArray) -> FloatArray:
    """First and last angle of masked points that no measured bin and no wide step parts, (m, 2)."""
    if not len(masked):
        return np.zeros((0, 2))
    part = np.searchsorted(measured, masked)
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(part) > 0) | (np.diff(masked) > 5.0)]))
    ends = np.concatenate([starts[1:], [len(masked)]]) - 1
    return np.stack((masked[starts], masked[ends]), axis=1)
