"""overlap.py: two passes over one region compared: mean ratio and difference with uncertainty, chi-square; outliers."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain, linear_result
from gonio.geometry.interpolate import Interpolation
from gonio.geometry.pitch import reach_rad
from gonio.merge.points import effect_column, measured_points, path_numbers, taken, units

FloatArray = NDArray[np.float64]

_LEAST_POINTS = 20
# Where the corners of a triangle differ by more than this of their mean, and that is no noise, a straight line between
# them says too little.
_STEEP = 0.25
_NOISE_SIGMA = 6.0


@dataclass(frozen=True)
class Overlap:
    """Pass `one` against pass `other`, where both measured: uncertainties hold noise and what the passes do not share;
    chi-squares are per degree of freedom."""

    one: str
    other: str
    points: int
    steep: int  # points left out because the DSF is too steep there to be interpolated
    ratio: float
    ratio_u: float
    difference_per_sr: float
    difference_u_per_sr: float
    offset_in_u: float  # mean difference over its uncertainty
    chi2_per_dof: float  # of the points' differences against all of their uncertainty
    noise_chi2_per_dof: float  # of what is left when the mean ratio is taken out, against noise alone

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def overlap(one: tuple[str, Distribution], other: tuple[str, Distribution], reach: float) -> Overlap | None:
    """Compares two passes (name, distribution; effects under common keys); None where they have no region in common.

    The pass with fewer points in the common region is compared at its own points with the other one, interpolated
    linearly there. Means are over solid angle. Noise that several interpolated values have in common is followed
    through; the chi-squares take the points as independent.
    """
    sets = [measured_points(distribution) for _, distribution in (one, other)]
    if any(len(points.theta_deg) < _LEAST_POINTS for points in sets):
        return None
    directions = [units(points) for points in sets]
    seen = [_seen(sets[1], directions[1], directions[0], reach), _seen(sets[0], directions[0], directions[1], reach)]
    sparse = 0 if len(seen[0][0]) <= len(seen[1][0]) else 1
    use, index, weight = seen[sparse]
    a, b = taken(sets[sparse], use), sets[1 - sparse]
    corners = b.dsf_per_sr[index]
    noise_sigma = np.sqrt(b.variance_per_sr2[index].max(axis=1, initial=0.0))
    steep = np.ptp(corners, axis=1) > _STEEP * np.abs(corners.mean(axis=1)) + _NOISE_SIGMA * noise_sigma
    if (~steep).sum() < _LEAST_POINTS:
        return None
    a, index, weight = taken(a, ~steep), index[~steep], weight[~steep]
    mean_a, mean_b = _means(a, b, index, weight)
    if mean_a.value == 0.0 or mean_b.value == 0.0:
        return None
    ratio = mean_a.over(mean_b)
    difference = mean_a.minus(mean_b)
    b_there = np.sum(weight * b.dsf_per_sr[index], axis=1)
    b_noise2 = np.sum(weight**2 * b.variance_per_sr2[index], axis=1)
    systematic2 = np.zeros(len(b_there))
    for key in {*a.effects, *b.effects}:
        theirs = np.sum(weight * effect_column(b, key)[index], axis=1)
        systematic2 += (effect_column(a, key) - theirs) ** 2
    apart = a.dsf_per_sr - b_there
    rest = a.dsf_per_sr - ratio.value * b_there
    sign = 1.0 if sparse == 0 else -1.0
    if sparse == 1:
        ratio = mean_b.over(mean_a)
    all_noise2 = a.variance_per_sr2 + b_noise2
    return Overlap(
        one=one[0],
        other=other[0],
        points=len(b_there),
        steep=int(steep.sum()),
        ratio=ratio.value,
        ratio_u=ratio.u,
        difference_per_sr=sign * difference.value,
        difference_u_per_sr=difference.u,
        offset_in_u=sign * _over(difference.value, difference.u),
        chi2_per_dof=_mean_square(apart, all_noise2 + systematic2, len(apart)),
        noise_chi2_per_dof=_mean_square(rest, all_noise2, len(apart) - 1),
    )


def _seen(
    points: Distribution, unit: FloatArray, at: FloatArray, reach: float
) -> tuple[NDArray[np.intp], NDArray[np.int64], FloatArray]:
    """Which of the directions `at` (m, 3) lie among the points at `unit` (n, 3), as indices (k,), and the points (k, 3)
    and weights (k, 3) that interpolate there. Among: all three corners of the triangle are within the points' reach;
    triangles that close the sphere outside a set's border have a corner far away."""
    reach_of = reach_rad(unit, path_numbers(points), reach)
    found = Interpolation(unit, reach_rad=reach_of).at(at)
    distance = np.linalg.norm(unit[found.index] - at[:, None], axis=2)
    use = np.flatnonzero(found.inside & np.all(distance <= reach_of[found.index], axis=1))
    return use, found.index[use], found.weight[use]


def _means(
    a: Distribution, b: Distribution, index: NDArray[np.int64], weight: FloatArray
) -> tuple[Uncertain, Uncertain]:
    """Means over the solid angle of a's points of a itself and of b, interpolated there with weights (m, 3)."""
    area = np.where(a.solid_angle_sr > 0.0, a.solid_angle_sr, 0.0)
    area = area / area.sum() if area.any() else np.full(len(area), 1.0 / len(area))
    summed = np.bincount(index.ravel(), (area[:, None] * weight).ravel(), len(b.theta_deg))
    return linear_result(a, area), linear_result(b, np.asarray(summed, dtype=np.float64))


def _over(value: float, u: float) -> float:
    """In units of uncertainty; what is exact and differs does so without bounds."""
    if u > 0.0:
        return value / u
    return 0.0 if value == 0.0 else float(np.copysign(1e9, value))


def _mean_square(difference: FloatArray, variance: FloatArray, dof: int) -> float:
    """Chi-square per degree of freedom over the points that state a variance."""
    known = variance > 0.0
    if not known.any():
        return 0.0
    return float(np.sum(difference[known] ** 2 / variance[known])) / max(dof - int((~known).sum()), 1)


def outliers(overlaps: Sequence[Overlap], limit: float) -> dict[str, list[str]]:
    """Passes whose offset exceeds `limit` combined uncertainties against more than half of the passes that they overlap
    with, of which there must be two: name, and those it disagrees with. Of two passes alone none can be told wrong."""
    against: dict[str, dict[str, float]] = {}
    for found in overlaps:
        against.setdefault(found.one, {})[found.other] = found.offset_in_u
        against.setdefault(found.other, {})[found.one] = found.offset_in_u
    return {
        name: [other for other, offset in others.items() if abs(offset) > limit]
        for name, others in against.items()
        if len(others) > 1 and _share(others, limit) > 0.5
    }


def disagreeing(overlaps: Sequence[Overlap], limit: float) -> list[Overlap]:
    """Pairs whose offset exceeds `limit` combined uncertainties."""
    return [found for found in overlaps if abs(found.offset_in_u) > limit]


def _share(offsets: Mapping[str, float], limit: float) -> float:
    return sum(abs(offset) > limit for offset in offsets.values()) / len(offsets)
