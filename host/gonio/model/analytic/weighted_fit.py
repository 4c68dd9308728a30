"""weighted_fit.py: the better-posed fit of any family: weighted, several starts, bounded, with covariance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.family import Family, bounds, from_fitted, to_fitted
from gonio.model.analytic.weighting import thinned, weights
from gonio.model.nodes.points import Points

_REWEIGHTED = 3  # times; after that weights change nothing that matters
_THIN = 2000  # points per distribution while starts are tried
_REFINED = 3  # of the starts, the best
_MOST = 6000  # points per distribution that the iterations see; the last step sees all
_EVALUATIONS = 40


@dataclass(frozen=True)
class WeightedFit:
    """Parameters (p,) and the covariance (p, p) of their fitted form (logarithms where the family says so), NaN rows
    for those at a bound or without effect; `cost`: weighted mean square."""

    values: FloatArray
    covariance: FloatArray
    cost: float


def dsf_of(family: Family, values: FloatArray, points: Points) -> FloatArray:
    """Model DSF (n,) at the points."""
    which = np.zeros(len(points.dsf_per_sr), dtype=np.int64)
    bsdf = family.bsdf_per_sr(values[None, :], points.incident[None, :], points.unit, which)
    return np.asarray(bsdf * points.unit[:, 2])


def fit_weighted(family: Family, directions: Sequence[Points], starts: FloatArray) -> WeightedFit:
    """One set of parameters for all of `directions`; `starts` (s, p).

    Weights follow the model and are found again between fits (weighting.py). Where there are many points the iterations
    see some of them, and one step of Newton's method on all of them follows, which is as good as iterating on all (Le
    Cam's one-step estimator). The covariance is the sandwich
    (J'WJ)^-1 J'W R W J (J'WJ)^-1 with R the squared residuals (White 1980): it holds for whatever noise the points
    have, and grows where the family does not fit. A point that alone decides a parameter has no residual: R gets back
    its stated variance by the share, the leverage, with which the fit follows it.
    """
    thin = [thinned(points, _THIN) for points in directions]
    begun = sorted((_first_cost(family, thin, start), tuple(start)) for start in starts)
    best, cost = np.array(begun[0][1]), np.inf
    for _, start in begun[:_REFINED]:
        found, reached = _refined(family, thin, np.array(start), rounds=1)
        if reached < cost:
            best, cost = found, reached
    best, cost = _refined(family, [thinned(points, _MOST) for points in directions], best, rounds=_REWEIGHTED)
    covariance, step = _covariance(family, directions, best)
    if any(len(points.dsf_per_sr) > _MOST for points in directions):
        best = _stepped(family, best, step, covariance)
    return WeightedFit(best, covariance, cost)


def _first_cost(family: Family, directions: Sequence[Points], values: FloatArray) -> float:
    total = 0.0
    for points in directions:
        weight = weights(points, np.maximum(points.dsf_per_sr, 0.0))
        total += float(weight @ (dsf_of(family, values, points) - points.dsf_per_sr) ** 2)
    return total


def _refined(family: Family, directions: Sequence[Points], values: FloatArray, rounds: int) -> tuple[FloatArray, float]:
    from scipy.optimize import least_squares  # noqa: PLC0415 - slow to load, and a model once fitted needs none

    lower, upper = (to_fitted(family, bound) for bound in bounds(family))
    x = np.clip(to_fitted(family, values), lower + 1e-9, upper - 1e-9)
    y = np.concatenate([points.dsf_per_sr for points in directions])
    cost = np.inf
    for turn in range(rounds + 1):
        # The first weights are those of the data: a start may be far off. Later they are the model's.
        model = [
            np.maximum(points.dsf_per_sr, 0.0) if turn == 0 else dsf_of(family, from_fitted(family, x), points)
            for points in directions
        ]
        root = np.sqrt(np.concatenate([weights(p, m) for p, m in zip(directions, model, strict=True)]))
        scale = max(float(np.sqrt(np.mean((root * y) ** 2))), 1e-300)

        def residual(fitted: FloatArray, root: FloatArray = root, scale: float = scale) -> FloatArray:
            own = from_fitted(family, fitted)
            model = np.concatenate([dsf_of(family, own, points) for points in directions])
            return np.asarray(root * (model - y) / scale)

        found = least_squares(
            residual, x, bounds=(lower, upper), x_scale="jac", max_nfev=_EVALUATIONS, xtol=1e-7, ftol=1e-8
        )
        x, cost = np.clip(found.x, lower + 1e-9, upper - 1e-9), float(2.0 * found.cost / len(y))
    return from_fitted(family, x), cost


def _stepped(family: Family, values: FloatArray, step: FloatArray, covariance: FloatArray) -> FloatArray:
    """After Newton's step; a step that is long for what the points of the iterations leave open is not taken."""
    spread = np.sqrt(np.nan_to_num(np.diag(covariance), nan=0.0))
    if np.any(np.abs(step) > 30.0 * spread):
        return values
    lower, upper = (to_fitted(family, bound) for bound in bounds(family))
    return from_fitted(family, np.clip(to_fitted(family, values) + step, lower, upper))


def _covariance(family: Family, directions: Sequence[Points], values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) and Newton's step (p,) of the fitted form."""
    x = to_fitted(family, values)
    lower, upper = (to_fitted(family, bound) for bound in bounds(family))
    free = np.flatnonzero((x > lower + 1e-6) & (x < upper - 1e-6))
    result = np.full((len(x), len(x)), np.nan)
    step, pull = np.zeros(len(x)), np.zeros(len(free))
    if not len(free):
        return result, step
    bread, count, kept = np.zeros((len(free), len(free))), 0, []
    for points in directions:
        model = dsf_of(family, values, points)
        slope = np.empty((len(model), len(free)))
        for column, parameter in enumerate(free):
            aside = np.zeros(len(x))
            aside[parameter] = 1e-5
            above, below = (dsf_of(family, from_fitted(family, x + sign * aside), points) for sign in (1.0, -1.0))
            slope[:, column] = (above - below) / 2e-5
        weight = weights(points, model)
        bread += slope.T @ (weight[:, None] * slope)
        pull += slope.T @ (weight * (points.dsf_per_sr - model))
        kept.append((slope, weight, (model - points.dsf_per_sr) ** 2, points.variance_per_sr2))
        count += len(model)
    known = np.diag(bread) > 1e-12 * np.max(np.diag(bread), initial=1e-300)
    rows = free[known]
    inverse = np.linalg.pinv(bread[np.ix_(known, known)], hermitian=True)
    step[rows] = inverse @ pull[known]
    meat = np.zeros((len(rows), len(rows)))
    for slope, weight, square, variance in kept:
        own = slope[:, known]
        leverage = np.clip(weight * np.einsum("ni,ij,nj->n", own, inverse, own), 0.0, 1.0)
        meat += own.T @ ((weight**2 * (square + leverage * variance))[:, None] * own)
    spread = inverse @ meat @ inverse * (count / max(count - len(rows), 1))
    result[np.ix_(rows, rows)] = spread
    return result, step
