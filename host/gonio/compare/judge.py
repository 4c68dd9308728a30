"""judge.py: all metrics of one region: points alike, by solid angle, and beside what the uncertainties explain."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gonio.compare import metrics
from gonio.compare.result import (
    COVERAGE_FACTOR,
    GOOD_PERCENT,
    VERY_GOOD_PERCENT,
    WITHIN_PERCENT,
    WITHIN_U,
    Metric,
    Metrics,
    Region,
    Share,
)
from gonio.compare.values import Values, difference_effects, difference_u_per_sr
from gonio.dataset.uncertainty import Uncertain

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Mean of |x| of a normal distribution, in standard deviations.
_MEAN_ABSOLUTE = float(np.sqrt(2.0 / np.pi))


def judge(
    region: Region,
    here: BoolArray,
    left_out: Mapping[str, int],
    a: Values,
    b: Values,
    solid_angle_sr: FloatArray,
    floor_per_sr: float,
) -> Metrics:
    """Metrics over the points `here` (n,), which have a value on both sides; arrays as in A's distribution."""
    a_dsf, b_dsf, omega = a.dsf_per_sr[here], b.dsf_per_sr[here], solid_angle_sr[here]
    u = difference_u_per_sr(a, b)[here]
    difference = b_dsf - a_dsf
    noise_known = u > 0.0
    explained = metrics.rms(u) or None
    value = metrics.global_accordance_percent(a_dsf, b_dsf)
    rmse = metrics.rms(difference)
    in_u = None if rmse is None or explained is None else rmse / explained
    over = a_dsf >= floor_per_sr
    known_u, z = omega[noise_known], difference[noise_known] / u[noise_known]
    local = metrics.local_accordance_percent(a_dsf, b_dsf)
    return Metrics(
        region=region,
        points=len(a_dsf),
        solid_angle_sr=float(omega.sum()),
        left_out=dict(left_out),
        global_accordance_percent=Metric(
            value=value,
            u=_u_of_accordance(here, a, b, np.ones(len(a_dsf)), u),
            by_solid_angle=metrics.global_accordance_percent(a_dsf, b_dsf, omega) if omega.any() else None,
            u_by_solid_angle=_u_of_accordance(here, a, b, omega, u) if omega.any() else None,
            from_uncertainty=metrics.accordance_from_sums(float(u @ u), float(np.sum((a_dsf + b_dsf) ** 2)), len(u)),
            in_u=in_u,
        ),
        global_accordance_by_uncertainty_percent=metrics.global_accordance_percent(
            a_dsf[noise_known], b_dsf[noise_known], u[noise_known] ** -2.0
        ),
        accordance_class=accordance_class(value),
        local_accordance_percent=_local(local, a_dsf + b_dsf, u, omega),
        local_accordance_beyond_uncertainty_percent=_mean_where_defined(
            metrics.local_accordance_percent(a_dsf, b_dsf, np.maximum(np.abs(difference) - COVERAGE_FACTOR * u, 0.0))
        ),
        local_accordance_undefined=int(np.isnan(local).sum()),
        local_accordance_both_zero=int(((a_dsf == 0.0) & (b_dsf == 0.0)).sum()),
        bias_per_sr=_bias(here, a, b, omega),
        bias_percent=_relative_bias(here, a, b, omega),
        rmse_per_sr=Metric(
            value=rmse,
            by_solid_angle=metrics.rms(difference, omega),
            from_uncertainty=metrics.rms(u),
            in_u=in_u,
        ),
        cv=_cv(difference, u, omega, float(omega @ a_dsf), float(omega @ b_dsf), in_u),
        within_percent=shares_within_percent(a_dsf[over], b_dsf[over], omega[over]),
        floor_per_sr=floor_per_sr,
        under_floor=int((~over).sum()),
        under_floor_sr=float(omega[~over].sum()),
        within_u=tuple(
            Share(k, metrics.share_percent(np.abs(z) <= k), metrics.share_percent(np.abs(z) <= k, known_u))
            for k in WITHIN_U
        ),
        without_uncertainty=int((~noise_known).sum()),
        chi_square_per_point=metrics.mean(z**2),
        chi_square_with_correlations_per_point=_chi_square(here, a, b),
    )


def shares_within_percent(a: FloatArray, b: FloatArray, w: FloatArray | None = None) -> tuple[Share, ...]:
    """Shares of points within 5, 10 and 20 % of the reference, by number and by weight."""
    found = [(limit, metrics.within(a, b, limit)) for limit in WITHIN_PERCENT]
    return tuple(
        Share(limit, metrics.share_percent(inside), None if w is None else metrics.share_percent(inside, w))
        for limit, inside in found
    )


def accordance_class(percent: float | None) -> Literal["very good", "good", "below good", "undefined"]:
    """The words of the literature on luminaires that paper [1] cites in section 5."""
    if percent is None:
        return "undefined"
    if percent >= VERY_GOOD_PERCENT:
        return "very good"
    return "good" if percent >= GOOD_PERCENT else "below good"


def difference_of(here: BoolArray, a: Values, b: Values, weight: FloatArray) -> Uncertain:
    """sum w (B - A) over the points `here`, `weight` for each of them; what both share cancels."""
    whole = spread_out(here, weight)
    return b.linear(whole).minus(a.linear(whole))


def spread_out(here: BoolArray, weight: FloatArray) -> FloatArray:
    """Weights of the points `here` as weights of all points (n,), 0 elsewhere."""
    whole = np.zeros(len(here))
    whole[here] = weight
    return whole


def _u_of_accordance(here: BoolArray, a: Values, b: Values, w: FloatArray, u: FloatArray) -> float | None:
    """To first order in the values. Where A = B that has no slope: there, what the uncertainties could make of it."""
    a_dsf, b_dsf = a.dsf_per_sr[here], b.dsf_per_sr[here]
    gradients = metrics.accordance_gradients(a_dsf, b_dsf, w)
    if gradients is None:
        ceiling = metrics.accordance_from_sums(float(w @ u**2), float(w @ (a_dsf + b_dsf) ** 2), len(u))
        return None if ceiling is None else 100.0 - ceiling
    by_a, by_b = (spread_out(here, gradient) for gradient in gradients)
    return a.linear(by_a).plus(b.linear(by_b)).u


def _local(local: FloatArray, total: FloatArray, u: FloatArray, omega: FloatArray) -> Metric:
    """Mean of the local accordance over the points where it is defined."""
    defined = ~np.isnan(local)
    value = metrics.mean(local[defined])
    lit = defined & (total > 0.0)
    lowered = np.zeros(len(local))
    lowered[lit] = 100.0 * _MEAN_ABSOLUTE * u[lit] / total[lit]
    explained = metrics.mean(lowered[defined])
    return Metric(
        value=value,
        by_solid_angle=metrics.mean(local[defined], omega[defined]),
        from_uncertainty=None if explained is None else 100.0 - explained,
        in_u=(100.0 - value) / explained if value is not None and explained else None,
    )


def _mean_where_defined(local: FloatArray) -> float | None:
    return metrics.mean(local[~np.isnan(local)])


def _bias(here: BoolArray, a: Values, b: Values, omega: FloatArray) -> Metric:
    points = int(here.sum())
    if points == 0:
        return Metric()
    plain = difference_of(here, a, b, np.full(points, 1.0 / points))
    by_omega = difference_of(here, a, b, omega / omega.sum()) if omega.any() else None
    return Metric(
        value=plain.value,
        u=plain.u,
        by_solid_angle=None if by_omega is None else by_omega.value,
        u_by_solid_angle=None if by_omega is None else by_omega.u,
        from_uncertainty=plain.u,
        in_u=plain.value / plain.u if plain.u > 0.0 else None,
    )


def _relative_bias(here: BoolArray, a: Values, b: Values, omega: FloatArray) -> Metric:
    """100 (sum w B / sum w A - 1)."""
    plain, by_omega = (_ratio(here, a, b, weight) for weight in (np.ones(len(omega)), omega))
    if plain is None:
        return Metric()
    return Metric(
        value=100.0 * (plain.value - 1.0),
        u=100.0 * plain.u,
        by_solid_angle=None if by_omega is None else 100.0 * (by_omega.value - 1.0),
        u_by_solid_angle=None if by_omega is None else 100.0 * by_omega.u,
        from_uncertainty=100.0 * plain.u,
        in_u=(plain.value - 1.0) / plain.u if plain.u > 0.0 else None,
    )


def _ratio(here: BoolArray, a: Values, b: Values, weight: FloatArray) -> Uncertain | None:
    whole = spread_out(here, weight)
    below = a.linear(whole)
    return None if below.value == 0.0 else b.linear(whole).over(below)


def _cv(
    difference: FloatArray,
    u: FloatArray,
    omega: FloatArray,
    integral_a: float,
    integral_b: float,
    in_u: float | None,
) -> Metric:
    return Metric(
        value=metrics.cv(metrics.rms(difference), integral_a, integral_b),
        by_solid_angle=metrics.cv(metrics.rms(difference, omega), integral_a, integral_b),
        from_uncertainty=metrics.cv(metrics.rms(u), integral_a, integral_b),
        in_u=in_u,
    )


def _chi_square(here: BoolArray, a: Values, b: Values) -> float | None:
    """With every effect fully correlated over the points. None without points of known noise, and for interpolated
    values, whose noise is correlated from point to point."""
    if a.spread is not None or b.spread is not None:
        return None
    variance = (a.variance_per_sr2 + b.variance_per_sr2)[here]
    known = variance > 0.0
    if not known.any():
        return None
    difference = (b.dsf_per_sr - a.dsf_per_sr)[here][known]
    at = np.flatnonzero(here)[known]
    changes = [column[at] for column in difference_effects(a, b).values()]
    effects = np.stack(changes) if changes else np.zeros((0, len(at)))
    return metrics.chi_square(difference, variance[known], effects) / len(difference)
