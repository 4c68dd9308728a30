"""metrics.py: how near a distribution comes to the truth: in the scatter plane, at the peak, as an integral."""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.geometry.directions import unit_from_angles_deg

PLANE_DEG = np.arange(-850, 851) / 10.0  # signed polar angle, positive on the incident side (CONVENTIONS.md)
FLOOR_PER_SR = 1e-3  # shares are of points with a truth above it; those under it are counted apart
SHARES_PERCENT = (5, 10, 20)


@dataclass(frozen=True)
class Judged:
    """One incident direction. Shares in percent of the points above the floor; peak and width kept in percent."""

    cv: float
    within: tuple[float, float, float]  # SHARES_PERCENT
    under_floor: int
    absent: int  # points of the plane without a value: counted, not judged
    peak_kept: float
    width_kept: float
    integral_error: float | None = None  # percent of the true hemispherical integral


def plane(incident_phi_deg: float) -> FloatArray:
    """Unit vectors (1701, 3) of the scatter plane's reflection half: PLANE_DEG, positive towards the source."""
    phi = np.where(PLANE_DEG >= 0.0, incident_phi_deg, incident_phi_deg + 180.0)
    return unit_from_angles_deg(np.abs(PLANE_DEG), phi)


def judged(truth: FloatArray, found: FloatArray, integral_error: float | None = None) -> Judged:
    """Both DSF [1/sr] (1701,) on `plane`. Raises ValueError where nothing was found."""
    there = np.isfinite(found) & np.isfinite(truth)
    if not there.any():
        raise ValueError("no point of the scatter plane has a value")
    t, f = truth[there], found[there]
    above = t > FLOOR_PER_SR
    relative = np.abs(f[above] / t[above] - 1.0)
    within = tuple(float(100.0 * np.mean(relative <= share / 100.0)) for share in SHARES_PERCENT)
    return Judged(
        cv=float(np.sqrt(np.mean((f - t) ** 2)) / np.mean(t)),
        within=(within[0], within[1], within[2]),
        under_floor=int(np.count_nonzero(~above)),
        absent=int(np.count_nonzero(~there)),
        peak_kept=_peak_kept(truth, found),
        width_kept=100.0 * half_width_deg(found) / half_width_deg(truth),
        integral_error=integral_error,
    )


def _peak_kept(truth: FloatArray, found: FloatArray) -> float:
    """Highest found value within 5 degrees of the true peak, in percent of the true one."""
    near = np.abs(PLANE_DEG - PLANE_DEG[np.nanargmax(truth)]) <= 5.0
    return float(100.0 * np.nanmax(np.where(near, found, -np.inf)) / np.nanmax(truth))


def half_width_deg(dsf: FloatArray) -> float:
    """Full width at half of the highest value over the plane [deg], edges interpolated linearly."""
    values = np.where(np.isfinite(dsf), dsf, 0.0)
    top = int(np.argmax(values))
    half = values[top] / 2.0

    def edge(step: int) -> float:
        at = top
        while 0 <= at + step < len(values) and values[at + step] > half:
            at += step
        beyond = at + step
        if not 0 <= beyond < len(values):
            return float(PLANE_DEG[at])
        part = (values[at] - half) / (values[at] - values[beyond])
        return float(PLANE_DEG[at] + part * (PLANE_DEG[beyond] - PLANE_DEG[at]))

    return edge(1) - edge(-1)


def hemisphere() -> tuple[FloatArray, FloatArray]:
    """Unit vectors (n, 3), z > 0, and weights [sr] (n,): midpoints of a grid of half degrees.

    A Gaussian lobe of sigma 1.2 degrees is integrated to 1e-9 (exp(-2 pi^2 sigma^2 / h^2)), smooth light to 1e-5.
    """
    step = np.radians(0.5)
    theta, phi = (np.arange(180) + 0.5) * step, (np.arange(720) + 0.5) * step
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    unit = np.column_stack((np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)))
    return unit, np.sin(t) * 2.0 * np.sin(step / 2.0) * step


@dataclass(frozen=True)
class Field:
    """Judgement over all directions of a hemisphere, weighted by solid angle."""

    cv: float
    within: tuple[float, float, float]  # percent of the solid angle above the floor, SHARES_PERCENT
    peak_kept: float  # highest value over highest true value, percent
    integral_error: float  # percent
    absent: int


def field(truth: FloatArray, found: FloatArray, weight_sr: FloatArray) -> Field:
    """All (m,), DSF [1/sr]. Raises ValueError where nothing was found."""
    there = np.isfinite(found) & np.isfinite(truth)
    if not there.any():
        raise ValueError("no point of the hemisphere has a value")
    t, f, w = truth[there], found[there], weight_sr[there]
    mean = np.sum(w * t) / np.sum(w)
    above = t > FLOOR_PER_SR
    relative = np.abs(f[above] / t[above] - 1.0)
    shares = [float(100.0 * np.sum(w[above] * (relative <= s / 100.0)) / np.sum(w[above])) for s in SHARES_PERCENT]
    return Field(
        cv=float(np.sqrt(np.sum(w * (f - t) ** 2) / np.sum(w)) / mean),
        within=(shares[0], shares[1], shares[2]),
        peak_kept=float(100.0 * np.max(f) / np.max(t)),
        integral_error=float(100.0 * (np.sum(w * f) / np.sum(w * t) - 1.0)),
        absent=int(np.count_nonzero(~there)),
    )
