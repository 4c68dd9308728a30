"""seam.py: the seam between two sets that meet without overlapping: both continued to the border and compared there."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain, linear_result
from gonio.geometry.directions import angles_deg_from_unit, tangent_frame
from gonio.geometry.pitch import path_pitch_rad
from gonio.merge.neighbourhoods import thinned
from gonio.merge.points import measured_points, path_numbers, units

FloatArray = NDArray[np.float64]
_Continued = tuple[float, FloatArray]
_Pair = tuple[_Continued, _Continued]

_MOST_CANDIDATES = 400
_MOST_PLACES = 72  # along the border, evenly
_LEAST_PLACES = 3
_LEAST_POINTS = 6  # of a local fit on one side
_PITCHES = 2.5  # beyond the nearest point: radius of a local fit, in pitches of its own side's tracks
_ROUNDS = 20
_SETTLED = 1e-6
_FOR_PARABOLA = 12
_MOST_WRONG = 0.15  # of the points that lie on the other set's side of a border
_GAP_PITCHES = 2.0  # sets farther apart than so many pitches do not meet


@dataclass(frozen=True)
class Seam:
    """Values of set `one` against those of `other` on their border; log ratios where both are positive.

    `step_in_u`: the mean difference in units of its own uncertainty, what both share left out.
    """

    one: str
    other: str
    places: int
    mean_log_ratio: float
    mean_log_ratio_u: float
    rms_log_ratio: float
    mean_difference_per_sr: float
    mean_difference_u_per_sr: float
    rms_in_u: float  # of the places' differences, each in units of its uncertainty
    step_in_u: float

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)

    def is_step(self, limit: float) -> bool:
        """Whether there is a step that the uncertainties do not explain: an artefact, as the sample knows no seam."""
        return abs(self.step_in_u) > limit


def seam(one: tuple[str, Distribution], other: tuple[str, Distribution]) -> Seam | None:
    """The seam of two sets (name, distribution with cells of its own; effects under common keys); None where they do
    not meet.

    The border is where points of one set have their nearest neighbour in the other, halfway between. At up to 72 places
    along it each side's own points around are fitted and continued to the border; there the value is, to first order,
    a weighted sum of the points, so that noise and effects are followed through.
    """
    sides = [measured_points(distribution) for _, distribution in (one, other)]
    if any(len(side.theta_deg) < _LEAST_POINTS for side in sides):
        return None
    directions = [units(side) for side in sides]
    pitches = [path_pitch_rad(d, path_numbers(side)) for d, side in zip(directions, sides, strict=True)]
    trees = [cKDTree(d) for d in directions]
    both: list[_Pair] = []
    for place in _border(directions, trees, pitches):
        found = [_continued(place, k, directions, trees, pitches, sides) for k in (0, 1)]
        if found[0] is not None and found[1] is not None:
            both.append((found[0], found[1]))
    if len(both) < _LEAST_PLACES:
        return None
    differences = [_changed(a[0] - b[0], sides, a[1], b[1]) for a, b in both]
    mean_weights = [np.mean([pair[k][1] for pair in both], axis=0) for k in (0, 1)]
    step = _changed(float(np.mean([d.value for d in differences])), sides, *mean_weights)
    log_ratio, rms_log = _logarithmic(sides, both)
    in_u = [d.value / d.u for d in differences if d.u > 0.0]
    return Seam(
        one=one[0],
        other=other[0],
        places=len(both),
        mean_log_ratio=log_ratio.value,
        mean_log_ratio_u=log_ratio.u,
        rms_log_ratio=rms_log,
        mean_difference_per_sr=step.value,
        mean_difference_u_per_sr=step.u,
        rms_in_u=float(np.sqrt(np.mean(np.square(in_u)))) if in_u else 0.0,
        step_in_u=step.value / step.u if step.u > 0.0 else 0.0,
    )


def _border(directions: list[FloatArray], trees: list[cKDTree], pitches: list[FloatArray]) -> FloatArray:
    """Places (m, 3) halfway between points that are each other's nearest in the other set, evenly thinned."""
    distance, partner = trees[1].query(directions[0])
    back = trees[0].query(directions[1])[1]
    width = np.maximum(pitches[0], pitches[1][partner])
    meets = np.flatnonzero((back[partner] == np.arange(len(partner))) & (distance < _GAP_PITCHES * width))
    middle = directions[0][meets] + directions[1][partner[meets]]
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    width = width[meets]
    chosen = thinned(*angles_deg_from_unit(middle), _MOST_CANDIDATES)
    middle, width = middle[chosen], width[chosen]
    beside = np.array(
        [
            _beside(*(directions[k][trees[k].query_ball_point(m, _PITCHES * w)] for k in (0, 1)))
            for m, w in zip(middle, width, strict=True)
        ],
        dtype=bool,
    )
    middle = middle[beside]
    return np.asarray(middle[thinned(*angles_deg_from_unit(middle), _MOST_PLACES)])


def _beside(one: FloatArray, other: FloatArray) -> bool:
    """Whether two clouds of points (n, 3) lie beside each other rather than through each other: split halfway between
    their means, few points are on the wrong side."""
    if not len(one) or not len(other):
        return False
    means = one.mean(axis=0), other.mean(axis=0)
    across = means[0] - means[1]
    half = 0.5 * (means[0] + means[1]) @ across
    wrong = np.count_nonzero(one @ across < half) / len(one), np.count_nonzero(other @ across > half) / len(other)
    return bool(max(wrong) < _MOST_WRONG)


def _continued(
    place: FloatArray,
    k: int,
    directions: list[FloatArray],
    trees: list[cKDTree],
    pitches: list[FloatArray],
    sides: list[Distribution],
) -> _Continued | None:
    """Value that side k, continued, has at `place` (3,), and its change with each of the side's points, weights (n,);
    None where too few points are near.

    The logarithm of the DSF is a parabola in the two tangent coordinates (a plane where few points are near), fitted by
    least squares, near points counting most, of relative deviations from the fit itself, so that noise, negative
    readings too, has no bias. A lobe is a parabola in the logarithm; where the fit finds nothing positive the DSF
    itself is taken for a parabola.
    """
    distance, nearest = trees[k].query(place)
    radius = distance + _PITCHES * pitches[k][nearest]
    near = trees[k].query_ball_point(place, radius)
    if len(near) < _LEAST_POINTS:
        return None
    e1, e2, _ = tangent_frame(place)
    x, y = directions[k][near] @ e1, directions[k][near] @ e2
    scale = np.sqrt(np.mean(x**2 + y**2))
    x, y = x / scale, y / scale
    terms = [np.ones(len(near)), x, y]
    if len(near) >= _FOR_PARABOLA:
        terms += [x**2, x * y, y**2]
    design = np.stack(terms, axis=1)
    nearness = np.maximum(1.0 - (x**2 + y**2) * (scale / radius) ** 2, 0.0)
    inverse = np.linalg.pinv(design * nearness[:, None], rcond=1e-8) * nearness
    dsf = sides[k].dsf_per_sr[near]
    weight = np.zeros(len(directions[k]))
    mean = float(dsf.mean())
    if mean > 0.0:
        log_fit = np.zeros(design.shape[1])
        log_fit[0] = np.log(mean)
        for _ in range(_ROUNDS):
            model = np.exp(design @ log_fit)
            change = inverse @ (dsf / model - 1.0)
            log_fit += np.clip(change, -1.0, 1.0)
            if np.abs(change).max() < _SETTLED:
                value = float(np.exp(log_fit[0]))
                weight[near] = value * inverse[0] / model
                return value, weight
    weight[near] = inverse[0]
    return float(inverse[0] @ dsf), weight


def _changed(value: float, sides: list[Distribution], one: FloatArray, other: FloatArray) -> Uncertain:
    """`value`, of which the points' weights `one` and minus `other` tell how it changes with them."""
    change = linear_result(sides[0], one).minus(linear_result(sides[1], other))
    return Uncertain(value, change.independent, change.effects)


def _logarithmic(sides: list[Distribution], both: list[_Pair]) -> tuple[Uncertain, float]:
    """Mean and root mean square of log ratios over places; d log f = df / f (GUM, JCGM 100:2008, 5.1.2)."""
    positive = [(a, b) for a, b in both if a[0] > 0.0 and b[0] > 0.0]
    if not positive:
        return Uncertain(0.0), 0.0
    values = np.array([np.log(a[0] / b[0]) for a, b in positive])
    weights = [np.mean([pair[k][1] / pair[k][0] for pair in positive], axis=0) for k in (0, 1)]
    return _changed(float(values.mean()), sides, *weights), float(np.sqrt(np.mean(values**2)))
