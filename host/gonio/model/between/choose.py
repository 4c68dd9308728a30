"""choose.py: the way to interpolate, chosen by leave-one-out on the data at hand.

Each inner measured direction is left out and predicted from the others, without fitting them again. The figure that
decides is the squared difference of sqrt(DSF), integrated over solid angle, over the integral of the DSF: it does not
lose a weak lobe beside a strong one as a squared difference of the DSF does. Points of large uncertainty count less.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Origin
from gonio.model.between.resolve import Resolver
from gonio.model.between.scheme import Scheme
from gonio.model.evaluate import evaluate
from gonio.model.nodes.node import Node
from gonio.model.nodes.points import Points

FloatArray = NDArray[np.float64]

_MOST_POINTS = 4000  # of a direction, those near peaks twice as many as elsewhere
_MOST_LEFT_OUT = 16
_CALM_U_REL = 0.1  # relative uncertainty at which a point counts half
_CLEARLY = 0.85  # a later scheme must be this much better by the figure, put no fewer points within 10 %,
_FAR = 0.6  # or be this much better: near the noise the figure alone says little,
_NO_WORSE = 1.1  # and have no more than so many times the CV(RMSD): not buy a better ground by a misplaced peak


@dataclass(frozen=True)
class Prediction:
    """How well one scheme predicts one direction that was left out: hellinger (see above), cv_rmsd over solid angle,
    share within 10 % (weighted by solid angle), and the model's integral over the measured one, over these points."""

    hellinger: float
    cv_rmsd: float
    within_10: float
    integral_ratio: float


@dataclass(frozen=True)
class Held:
    """Points of one direction that predictions are compared with; weight (n,): solid angles for whole integrals."""

    node: int
    points: Points
    weight: FloatArray


def held_out(points: list[Points], nodes: list[Node], resolver: Resolver) -> list[Held]:
    """Directions that lie between others, evenly chosen if there are many, thinned out."""
    inner = []
    for number, node in enumerate(nodes):
        others = resolver.without(number)
        if len(others.mesh.edges) and others.origin(node.incident[None])[0] == Origin.INTERPOLATED:
            inner.append(number)
    if len(inner) > _MOST_LEFT_OUT:
        inner = [inner[k] for k in np.unique(np.linspace(0, len(inner) - 1, _MOST_LEFT_OUT).round().astype(int))]
    return [_thinned(number, points[number], nodes[number]) for number in inner]


def _thinned(number: int, points: Points, node: Node) -> Held:
    """Points near peaks are kept in greater number, and count for those that are not."""
    total = len(points.unit)
    if total <= _MOST_POINTS:
        return Held(number, points, points.solid_angle_sr)
    near = np.zeros(total, dtype=bool)
    for centre, sigma in zip(node.centre, node.sigma_rad, strict=True):
        if sigma[1] < np.radians(10.0):
            near |= points.unit @ centre > np.cos(4.0 * sigma[1])
    random = np.random.default_rng(0)  # the same points in every run
    kept, weight = [], []
    for group, most in ((np.flatnonzero(near), _MOST_POINTS // 2), (np.flatnonzero(~near), _MOST_POINTS // 2)):
        chosen = group if len(group) <= most else np.sort(random.choice(group, most, replace=False))
        kept.append(chosen)
        share = points.solid_angle_sr[group].sum() / max(points.solid_angle_sr[chosen].sum(), 1e-300)
        weight.append(points.solid_angle_sr[chosen] * share)
    return Held(number, points.some(np.concatenate(kept)), np.concatenate(weight))


def predict(resolver: Resolver, held: Held) -> Prediction:
    """From the nodes that the resolver connects."""
    p = held.points
    model = evaluate(resolver.slices(p.incident[None]), resolver.grids, p.unit)
    measured = np.maximum(p.dsf_per_sr, 0.0)
    calm = (_CALM_U_REL * measured) ** 2
    weight = held.weight * calm / np.maximum(calm + p.variance_per_sr2, 1e-300)
    sr = held.weight.sum()
    mean = float(held.weight @ p.dsf_per_sr) / sr
    rmsd = np.sqrt(float(held.weight @ (model - p.dsf_per_sr) ** 2) / sr)
    near = np.abs(model - p.dsf_per_sr) <= 0.1 * np.abs(p.dsf_per_sr)
    return Prediction(
        float(weight @ (np.sqrt(model) - np.sqrt(measured)) ** 2 / max(float(weight @ measured), 1e-300)),
        float(rmsd / max(mean, 1e-300)),
        float(held.weight @ near / sr),
        float(held.weight @ model / sr / max(mean, 1e-300)),
    )


def leave_one_out(others: list[Resolver], held: list[Held]) -> list[Prediction]:
    """One scheme's predictions of all directions that are held out, each by a resolver without it."""
    return [predict(other, h) for other, h in zip(others, held, strict=True)]


def chosen(table: dict[Scheme, list[Prediction]]) -> Scheme:
    """The scheme with the least mean figure; but an earlier one, which is simpler, unless a later one is clearly
    better: one direction left out is weak evidence. The order of SCHEMES: lobes over a ground at rest; a ground of
    which what directions do not share moves; one that moves; cubics in place of lines; no lobes.
    """
    best, least, most, spread = next(iter(table)), np.inf, 0.0, np.inf
    for scheme, predictions in table.items():
        if not predictions:
            continue
        figure = float(np.mean([p.hellinger for p in predictions]))
        within = float(np.mean([p.within_10 for p in predictions]))
        cv = float(np.mean([p.cv_rmsd for p in predictions]))
        better = figure < _FAR * least or (figure < _CLEARLY * least and within >= most)
        if better and cv <= _NO_WORSE * spread:
            best, least, most, spread = scheme, figure, within, cv
    return best


def as_json(table: dict[Scheme, list[Prediction]], held: list[Held], angles: list[tuple[float, float]]) -> list[Any]:
    """Rows of the table: per scheme the means, and each direction's own."""
    return [
        {
            "method": scheme.name,
            "hellinger": float(np.mean([p.hellinger for p in predictions])),
            "cv_rmsd": float(np.mean([p.cv_rmsd for p in predictions])),
            "within_10_percent": 100.0 * float(np.mean([p.within_10 for p in predictions])),
            "left_out": [
                {
                    "theta_deg": angles[h.node][0],
                    "phi_deg": angles[h.node][1],
                    "hellinger": p.hellinger,
                    "cv_rmsd": p.cv_rmsd,
                    "within_10_percent": 100.0 * p.within_10,
                    "integral_ratio": p.integral_ratio,
                }
                for h, p in zip(held, predictions, strict=True)
            ],
        }
        for scheme, predictions in table.items()
        if predictions
    ]
