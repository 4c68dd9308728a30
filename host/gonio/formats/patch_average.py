"""patch_average.py: averages of scattered points over Klems patches, in any azimuthal rotation.

A patch value is N / D with N = integral of DSF and D = integral of |cos theta| over the measured part of the patch.
Both are kept on a fine grid (ring, azimuth bin), so that a rotation is a shift. Points in small cells (a dense scan of
a peak) enter N whole, with their own solid angle: their energy is exact. Large cells that may cross a patch's border
are divided: a grid of directions takes the nearest point's value. D is counted on the grid.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.formats.klems import KlemsBasis
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

BINS = 1440  # 0.25 degrees: every border and centre of the three bases lies on a bin's edge
GRID_BINS = 2  # azimuth bins per grid direction
GRID_LEVELS = 16  # polar levels per ring, equal in projected solid angle
SMALL_CELL_DEG = 1.0  # cells that reach no farther than this from their point enter whole
FARTHEST_DEG = 15.0  # a direction farther than this from every point is not measured
LEAST_COVERAGE = 0.05  # a patch with less measured share is filled from the nearest points


@dataclass(frozen=True)
class PatchValues:
    """Values of one incident direction on all outgoing patches of one hemisphere, arrays of shape (patches,)."""

    bsdf_per_sr: FloatArray
    coverage: FloatArray  # measured share of the projected solid angle
    filled: NDArray[np.bool_]  # too little measured: value of the nearest points


@dataclass(frozen=True)
class HemisphereProfile:
    """Integrals over one hemisphere on (rings, BINS): of DSF and of |cos|, measured and nearest-point fill."""

    basis: KlemsBasis
    energy: FloatArray  # integral of DSF, measured part
    weight: FloatArray  # integral of |cos|, measured part [sr]
    fill_energy: FloatArray
    fill_weight: FloatArray
    variance: float  # of the hemisphere's integral, independent part
    outermost_deg: float  # largest polar angle of a measured point

    def shifted(self, azimuth_deg: float) -> "HemisphereProfile":
        """Rotated by a multiple of 0.25 degrees (nearest)."""
        return self._mapped(lambda a: np.roll(a, round(azimuth_deg * BINS / 360.0), axis=1))

    def smeared(self, width_deg: float) -> "HemisphereProfile":
        """Mean over rotations spread evenly over a width: what an isotropic sample does over an incident patch."""
        bins = round(width_deg * BINS / 360.0)
        kernel = np.zeros(BINS)
        kernel[np.arange(-(bins // 2), bins - bins // 2 + 1) % BINS] += 1.0
        kernel /= kernel.sum()
        spectrum = np.fft.rfft(kernel)
        return self._mapped(lambda a: np.fft.irfft(np.fft.rfft(a, axis=1) * spectrum, n=BINS, axis=1))

    def patches(self) -> PatchValues:
        """Averages over the basis's patches."""
        energy, weight = self._gather(self.energy), self._gather(self.weight)
        size = self.basis.projected_solid_angle_sr
        filled = weight < LEAST_COVERAGE * size
        all_energy, all_weight = energy + self._gather(self.fill_energy), weight + self._gather(self.fill_weight)
        value = np.where(filled, all_energy, energy) / np.where(filled, all_weight, weight)
        return PatchValues(value, np.minimum(weight / size, 1.0), filled)

    def _mapped(self, change: Callable[[FloatArray], FloatArray]) -> "HemisphereProfile":
        return HemisphereProfile(
            self.basis,
            change(self.energy),
            change(self.weight),
            change(self.fill_energy),
            change(self.fill_weight),
            self.variance,
            self.outermost_deg,
        )

    def _gather(self, fine: FloatArray) -> FloatArray:
        parts = []
        for ring, row in zip(self.basis.rings, fine, strict=True):
            width = BINS // ring.patches
            parts.append(np.roll(row, width // 2).reshape(ring.patches, width).sum(axis=1))
        return np.concatenate(parts)


def mean_profile(profiles: list[HemisphereProfile]) -> HemisphereProfile:
    """Equal mean of several incident directions in one incident patch."""
    first = profiles[0]
    n = len(profiles)
    return HemisphereProfile(
        first.basis,
        sum((p.energy for p in profiles), np.zeros_like(first.energy)) / n,
        sum((p.weight for p in profiles), np.zeros_like(first.energy)) / n,
        sum((p.fill_energy for p in profiles), np.zeros_like(first.energy)) / n,
        sum((p.fill_weight for p in profiles), np.zeros_like(first.energy)) / n,
        sum(p.variance for p in profiles) / n**2,
        min(p.outermost_deg for p in profiles),
    )


def hemisphere_profile(
    basis: KlemsBasis, points: Distribution, polar_deg: FloatArray, azimuth_deg: FloatArray
) -> HemisphereProfile | None:
    """Profile of the points of one hemisphere, None when none of them holds a value.

    `points` gives values, cells and flags; `polar_deg` (n,) is each point's angle from the wanted hemisphere's normal
    (over 90: the other hemisphere, left out), `azimuth_deg` (n,) its azimuth from the profile's zero.
    """
    here = polar_deg <= 90.0
    measured = points.measured[here]
    if not measured.any():
        return None
    polar, azimuth = polar_deg[here], azimuth_deg[here] % 360.0
    dsf, cell_sr = points.dsf_per_sr[here], points.solid_angle_sr[here]
    cosine = np.cos(np.radians(polar))
    units = unit_from_angles_deg(polar, azimuth)
    grid_units, grid_weight = _grid(basis)

    # Grid directions: nearest point of all, measured or masked.
    distance, nearest = cKDTree(units).query(grid_units)
    reach = min(2.0 * np.quantile(distance, 0.95), 2.0 * np.sin(np.radians(FARTHEST_DEG / 2)))
    covered = measured[nearest] & (distance <= reach)
    fill_nearest = np.flatnonzero(measured)[cKDTree(units[measured]).query(grid_units)[1]]
    used = np.where(covered, nearest, fill_nearest)
    bsdf = _cell_bsdf(dsf, cosine, used, grid_units[:, 2], grid_weight)

    extent = np.zeros(len(dsf))
    np.maximum.at(extent, nearest, distance)
    small = measured & (cell_sr > 0) & (cell_sr < np.radians(SMALL_CELL_DEG) ** 2)
    small &= extent < np.radians(SMALL_CELL_DEG)
    divided = covered & ~small[nearest]
    energy, weight, fill_energy, fill_weight = (np.zeros((len(basis.rings), BINS)) for _ in range(4))
    per_row = BINS // GRID_BINS
    product = grid_weight * bsdf[used]
    for target, share in (
        (energy, np.where(divided, product, 0.0)),
        (weight, np.where(covered, grid_weight, 0.0)),
        (fill_energy, np.where(covered, 0.0, product)),
        (fill_weight, np.where(covered, 0.0, grid_weight)),
    ):
        per_cell = share.reshape(len(basis.rings), GRID_LEVELS, per_row).sum(axis=1)
        np.add(target, np.repeat(per_cell / GRID_BINS, GRID_BINS, axis=1), out=target)
    place = (basis.ring_of(polar[small]), np.floor(azimuth[small] * BINS / 360.0).astype(np.int64) % BINS)
    np.add.at(energy, place, dsf[small] * cell_sr[small])
    variance = float(np.sum(cell_sr[measured] ** 2 * np.nan_to_num(points.variance_per_sr2[here][measured])))
    outermost = float(polar[measured].max())
    return HemisphereProfile(basis, energy, weight, fill_energy, fill_weight, variance, outermost)


def _grid(basis: KlemsBasis) -> tuple[FloatArray, FloatArray]:
    """Grid directions: units (m, 3), projected solid angle each (m,); ring by ring, level by level."""
    per_row = BINS // GRID_BINS
    azimuth = (np.arange(per_row) + 0.5) * 360.0 / per_row
    units, weights = [], []
    for ring in basis.rings:
        lower, upper = np.sin(np.radians([ring.lower_deg, ring.upper_deg])) ** 2
        levels = lower + (upper - lower) * (np.arange(GRID_LEVELS) + 0.5) / GRID_LEVELS
        polar = np.degrees(np.arcsin(np.sqrt(levels)))
        p, a = np.meshgrid(polar, azimuth, indexing="ij")
        units.append(unit_from_angles_deg(p.ravel(), a.ravel()))
        count = GRID_LEVELS * per_row
        weights.append(np.full(count, ring.projected_solid_angle_sr * ring.patches / count))
    return np.concatenate(units), np.concatenate(weights)


def _cell_bsdf(
    dsf: FloatArray, cosine: FloatArray, used: NDArray[np.int64], grid_cosine: FloatArray, grid_weight: FloatArray
) -> FloatArray:
    """BSDF of each point's cell (n,): DSF / cos; at the horizon a quarter of the mean cosine bounds it."""
    plain = np.bincount(used, grid_weight / grid_cosine, minlength=len(dsf))
    projected = np.bincount(used, grid_weight, minlength=len(dsf))
    mean_cosine = np.divide(projected, plain, out=np.zeros_like(projected), where=plain > 0)
    return np.asarray(dsf / np.maximum(np.maximum(cosine, mean_cosine / 4), 1e-6), dtype=np.float64)
