"""patch_average.py: averages of scattered points over Klems patches, in any azimuthal rotation, with uncertainty.

A patch value is N / D with N = integral of DSF and D = integral of |cos theta| over the measured part of the patch.
Both are kept on a fine grid (ring, azimuth bin), so that a rotation is a shift. Points in small cells (a dense scan of
a peak) enter N whole, with their own solid angle: their energy is exact. Long cells that may cross a patch's border
are divided: a grid of directions takes the nearest point's value. D is counted on the grid.

N is linear in the points' DSF. So the change of a patch by a systematic effect is N of the effect's column over D, and
the independent variance is the sum of squares of the same weights times the points' variance (patch_noise.py).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.formats.window.klems import KlemsBasis
from gonio.formats.window.patch_noise import PatchNoise, joined, of_cells
from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

BINS = 1440  # 0.25 degrees: every border and centre of the three bases lies on a bin's edge
GRID_BINS = 2  # azimuth bins per grid direction
GRID_LEVELS = 16  # polar levels per ring, equal in projected solid angle
SMALL_CELL_DEG = 1.0  # cells that reach no farther than this from their point enter whole
FARTHEST_DEG = 15.0  # a direction farther than this from every point is not measured
LEAST_COVERAGE = 0.05  # a patch with less measured share is filled from the nearest points
_PER_ROW = BINS // GRID_BINS


@dataclass(frozen=True)
class PatchValues:
    """Values of one incident direction on all outgoing patches of one hemisphere, arrays of shape (patches,)."""

    bsdf_per_sr: FloatArray
    coverage: FloatArray  # measured share of the projected solid angle
    filled: NDArray[np.bool_]  # too little measured: value of the nearest points
    variance_per_sr2: FloatArray  # independent part; NaN where filled
    effects: dict[str, FloatArray]  # change per systematic effect [1/sr], signed; of the nearest points where filled
    total_variance: float  # of the hemisphere's energy sum_o B_o L_o, independent part of what was measured


@dataclass(frozen=True)
class HemisphereProfile:
    """Integrals over one hemisphere on (rings, BINS): of DSF and of |cos|, measured and nearest-point fill.

    Of the DSF and of every effect's column there is one layer: (1 + effects, rings, BINS). `kernel` (BINS,) is the
    rotation that the patches see: weights of shifts in azimuth, with sum 1.
    """

    basis: KlemsBasis
    effects: tuple[str, ...]
    energy: FloatArray  # (1 + effects, rings, BINS) integral, measured part
    weight: FloatArray  # (rings, BINS) integral of |cos|, measured part [sr]
    fill_energy: FloatArray  # (1 + effects, rings, BINS)
    fill_weight: FloatArray  # (rings, BINS)
    noise: PatchNoise
    kernel: FloatArray
    outermost_deg: float  # largest polar angle of a measured point

    def shifted(self, azimuth_deg: float) -> "HemisphereProfile":
        """Rotated by a multiple of 0.25 degrees (nearest)."""
        return replace(self, kernel=np.roll(self.kernel, round(azimuth_deg * BINS / 360.0)))

    def smeared(self, width_deg: float) -> "HemisphereProfile":
        """Mean over rotations spread evenly over a width: what an isotropic sample does over an incident patch."""
        bins = round(width_deg * BINS / 360.0)
        box = np.zeros(BINS)
        box[np.arange(-(bins // 2), bins - bins // 2 + 1) % BINS] += 1.0
        spectrum = np.fft.rfft(box / box.sum()) * np.fft.rfft(self.kernel)
        return replace(self, kernel=np.fft.irfft(spectrum, n=BINS))

    def patches(self) -> PatchValues:
        """Averages over the basis's patches."""
        size = self.basis.projected_solid_angle_sr
        seen = [self._seen(ring) for ring in range(len(self.basis.rings))]
        energy = np.concatenate([k @ self.energy[:, r].T for r, k in enumerate(seen)]).T
        weight = np.concatenate([k @ self.weight[r] for r, k in enumerate(seen)])
        filled = weight < LEAST_COVERAGE * size
        divisor = weight.copy()
        if filled.any():
            fill = np.concatenate([k @ self.fill_energy[:, r].T for r, k in enumerate(seen)]).T
            energy = np.where(filled, energy + fill, energy)
            divisor[filled] += np.concatenate([k @ self.fill_weight[r] for r, k in enumerate(seen)])[filled]
        values = energy / divisor
        variance = np.concatenate([self.noise.variance_of(r, k) for r, k in enumerate(seen)])
        share = np.where(filled, 0.0, size / divisor)
        starts = self.basis.ring_start[1:-1]
        of_total = np.stack([s @ k for s, k in zip(np.split(share, starts), seen, strict=True)])
        return PatchValues(
            values[0],
            np.minimum(weight / size, 1.0),
            filled,
            np.where(filled, np.nan, variance / divisor**2),
            dict(zip(self.effects, values[1:], strict=True)),
            self.noise.total_variance(of_total),
        )

    def _seen(self, ring: int) -> FloatArray:
        """How much of each bin every patch of a ring holds, shape (patches, BINS)."""
        patches = self.basis.rings[ring].patches
        width = BINS // patches
        box = np.zeros(BINS)
        box[np.arange(-(width // 2), width - width // 2) % BINS] = 1.0
        turns = np.flatnonzero(self.kernel)
        if len(turns) == 1:
            first = np.roll(box, -int(turns[0])) * self.kernel[turns[0]]
        else:
            first = np.fft.irfft(np.fft.rfft(box) * np.conj(np.fft.rfft(self.kernel)), n=BINS)
        return np.asarray(first[(np.arange(BINS) - width * np.arange(patches)[:, None]) % BINS])


def mean_profile(profiles: list[HemisphereProfile]) -> HemisphereProfile:
    """Equal mean of several incident directions in one incident patch; none of them rotated yet."""
    if len(profiles) == 1:
        return profiles[0]
    n = len(profiles)
    names = tuple(dict.fromkeys(name for p in profiles for name in p.effects))

    def layers(p: HemisphereProfile, own: FloatArray) -> FloatArray:
        """With a layer of zeros for an effect that only the others have."""
        place = [p.effects.index(name) + 1 if name in p.effects else None for name in names]
        return np.stack([own[0], *(np.zeros_like(own[0]) if k is None else own[k] for k in place)])

    return replace(
        profiles[0],
        effects=names,
        energy=np.mean([layers(p, p.energy) for p in profiles], axis=0),
        weight=np.mean([p.weight for p in profiles], axis=0),
        fill_energy=np.mean([layers(p, p.fill_energy) for p in profiles], axis=0),
        fill_weight=np.mean([p.fill_weight for p in profiles], axis=0),
        noise=joined([p.noise for p in profiles], 1.0 / n),
        outermost_deg=min(p.outermost_deg for p in profiles),
    )


def effects_of(points: Distribution) -> dict[str, FloatArray]:
    """Effect columns (n,) of a distribution; where none speaks of P_i, its stated uncertainty is one."""
    if "p_i" in points.effects or not points.p_i_u_rel > 0.0:
        return points.effects
    return {**points.effects, "p_i": points.p_i_u_rel * points.dsf_per_sr}


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
    cell_sr = points.solid_angle_sr[here]
    cosine = np.cos(np.radians(polar))
    units = unit_from_angles_deg(polar, azimuth)
    grid_units, grid_weight = _grid(basis)

    # Grid directions: nearest point of all, measured or masked.
    tree = cKDTree(units)
    distance, nearest = tree.query(grid_units)
    reach = min(2.0 * np.quantile(distance, 0.95), 2.0 * np.sin(np.radians(FARTHEST_DEG / 2)))
    covered = measured[nearest] & (distance <= reach)
    used = nearest.copy()
    if not covered.all():
        used[~covered] = np.flatnonzero(measured)[cKDTree(units[measured]).query(grid_units[~covered])[1]]
    factor = _bsdf_factor(cosine, used, grid_units[:, 2], grid_weight)

    small = measured & (cell_sr > 0.0) & (cell_sr < np.radians(SMALL_CELL_DEG) ** 2)
    small &= _half_length_rad(tree, units, cell_sr) < np.radians(SMALL_CELL_DEG)
    divided = covered & ~small[nearest]
    share = grid_weight * factor[used]
    place = basis.ring_of(polar[small]) * BINS + np.floor(azimuth[small] * BINS / 360.0).astype(np.int64) % BINS
    layers, fill_layers = [], []
    effects = effects_of(points)
    for column in (points.dsf_per_sr, *effects.values()):
        values = column[here]
        product = share * values[used]
        whole = np.bincount(place, values[small] * cell_sr[small], minlength=len(basis.rings) * BINS)
        layers.append(_binned(basis, np.where(divided, product, 0.0)) + whole.reshape(-1, BINS))
        fill_layers.append(_binned(basis, np.where(covered, 0.0, product)))
    sigma = np.sqrt(np.nan_to_num(points.variance_per_sr2[here]))
    small_variance = np.bincount(place, (sigma[small] * cell_sr[small]) ** 2, minlength=len(basis.rings) * BINS)
    grid_bin = np.arange(len(grid_weight))
    grid_bin = grid_bin // (GRID_LEVELS * _PER_ROW) * _PER_ROW + grid_bin % _PER_ROW
    return HemisphereProfile(
        basis,
        tuple(effects),
        np.stack(layers),
        _binned(basis, np.where(covered, grid_weight, 0.0)),
        np.stack(fill_layers),
        _binned(basis, np.where(covered, 0.0, grid_weight)),
        of_cells(
            np.asarray(small_variance.reshape(-1, BINS), dtype=np.float64),
            grid_bin[divided],
            nearest[divided],
            share[divided] * sigma[nearest[divided]],
            rings=len(basis.rings),
            per_row=_PER_ROW,
        ),
        np.eye(1, BINS)[0],
        float(polar[measured].max()),
    )


def _half_length_rad(tree: cKDTree, units: FloatArray, cell_sr: FloatArray) -> FloatArray:
    """How far (n,) about cells reach from their points: of samples dense along a track they are strips, as wide as the
    samples are apart and as long as the tracks are. Judged by the points alone: if grid directions had a say, cells
    that hold none would pass as small, and their area would count twice."""
    if len(units) < 2:
        return np.full(len(units), np.inf)
    apart = tree.query(units, k=2)[0][:, 1]
    return np.asarray(np.divide(0.5 * cell_sr, apart, out=np.full(len(units), np.inf), where=apart > 0.0))


def _binned(basis: KlemsBasis, share: FloatArray) -> FloatArray:
    """Sums over the grid's levels on (rings, BINS); a grid direction is spread evenly over its GRID_BINS."""
    per_cell = share.reshape(len(basis.rings), GRID_LEVELS, _PER_ROW).sum(axis=1)
    return np.repeat(per_cell / GRID_BINS, GRID_BINS, axis=1)


def _grid(basis: KlemsBasis) -> tuple[FloatArray, FloatArray]:
    """Grid directions: units (m, 3), projected solid angle each (m,); ring by ring, level by level."""
    azimuth = (np.arange(_PER_ROW) + 0.5) * 360.0 / _PER_ROW
    units, weights = [], []
    for ring in basis.rings:
        lower, upper = np.sin(np.radians([ring.lower_deg, ring.upper_deg])) ** 2
        levels = lower + (upper - lower) * (np.arange(GRID_LEVELS) + 0.5) / GRID_LEVELS
        polar = np.degrees(np.arcsin(np.sqrt(levels)))
        p, a = np.meshgrid(polar, azimuth, indexing="ij")
        units.append(unit_from_angles_deg(p.ravel(), a.ravel()))
        count = GRID_LEVELS * _PER_ROW
        weights.append(np.full(count, ring.projected_solid_angle_sr * ring.patches / count))
    return np.concatenate(units), np.concatenate(weights)


def _bsdf_factor(
    cosine: FloatArray, used: NDArray[np.int64], grid_cosine: FloatArray, grid_weight: FloatArray
) -> FloatArray:
    """BSDF over DSF of each point's cell (n,): 1 / cos; at the horizon a quarter of the mean cosine bounds it."""
    plain = np.bincount(used, grid_weight / grid_cosine, minlength=len(cosine))
    projected = np.bincount(used, grid_weight, minlength=len(cosine))
    mean_cosine = np.divide(projected, plain, out=np.zeros_like(projected), where=plain > 0)
    return np.asarray(1.0 / np.maximum(np.maximum(cosine, mean_cosine / 4), 1e-6), dtype=np.float64)
