"""table.py: a comparison in rows of text: for the terminal, and for the tables of the report."""

import math
from collections.abc import Iterator, Sequence

from gonio.compare.result import COVERAGE_FACTOR, Comparison, IntegralDelta, Metric, Metrics, Pair, Profile, Share

METRIC_HEAD = ("", "points alike", "by solid angle", "from uncertainty alone", "in uncertainties")
INTEGRAL_HEAD = ("integral", "A", "B", "delta", "B / A - 1", "in uncertainties")
_NONE = "\u2013"
_ROUTES = {
    "same points": "B has the same points",
    "evaluated": "B evaluated at A's directions",
    "interpolated": "B interpolated at A's directions",
}
_LEFT_OUT = {"masked_a": "masked in A", "masked_b": "masked in B", "outside_b": "where B has nothing"}


def metric_rows(metrics: Metrics) -> list[tuple[str, ...]]:
    """Rows under METRIC_HEAD for one region of one pair."""
    beyond = metrics.local_accordance_beyond_uncertainty_percent
    return [
        _row("global accordance f [%]", metrics.global_accordance_percent),
        _alone("f, points weighted by 1/u^2 [%]", metrics.global_accordance_by_uncertainty_percent, ""),
        _row("local accordance, mean [%]", metrics.local_accordance_percent),
        _alone(f"of what {COVERAGE_FACTOR:g} u leave unexplained [%]", beyond, ""),
        _row("bias, mean of B - A [1/sr]", metrics.bias_per_sr, sign=True),
        _row("bias, relative [%]", metrics.bias_percent, sign=True),
        _row("RMSE [1/sr]", metrics.rmse_per_sr),
        _row("CV", metrics.cv),
        *(_share(f"within {share.limit:g} % of A", share) for share in metrics.within_percent),
        *(_share(f"within {share.limit:g} u(A - B)", share, _normal(share.limit)) for share in metrics.within_u),
        _alone("chi-square per point", metrics.chi_square_per_point, "1"),
        _alone("the same with correlations", metrics.chi_square_with_correlations_per_point, "1"),
    ]


def integral_rows(integrals: Sequence[IntegralDelta]) -> list[tuple[str, ...]]:
    """Rows under INTEGRAL_HEAD."""
    return [
        (
            one.name,
            _with_u(one.a, one.u_a),
            _with_u(one.b, one.u_b),
            _percent(one.delta_percent),
            f"{_with_u(one.signed_percent, one.u_percent, sign=True)} %" if one.signed_percent is not None else _NONE,
            _figure(one.in_u, sign=True),
        )
        for one in integrals
    ]


def profile_rows(profile: Profile) -> list[tuple[str, ...]]:
    """Rows under METRIC_HEAD for one side of the scatter plane."""
    within = (_share(f"within {share.limit:g} % of A", share) for share in profile.within_percent)
    cv = profile.cv_rmsd
    return [("CV(RMSD)", _figure(cv.value), "", _figure(cv.from_uncertainty), _figure(cv.in_u)), *within]


def pair_name(pair: Pair) -> str:
    """Channel and incident direction: "visible (30, 0)"."""
    return f"{pair.channel} ({pair.incident_theta_deg:g}, {pair.incident_phi_deg:g})"


def pair_title(pair: Pair) -> str:
    """Channel, incident direction and how B came to A's directions."""
    incident, b_incident = (
        f"({theta:.4g}, {phi:.4g})"
        for theta, phi in (
            (pair.incident_theta_deg, pair.incident_phi_deg),
            (pair.b_incident_theta_deg, pair.b_incident_phi_deg),
        )
    )
    apart = "" if incident == b_incident else f" (B: {b_incident})"
    return f"{pair.channel}, incident {incident}{apart}: {_ROUTES[pair.route]}"


def counted(metrics: Metrics) -> str:
    """What counts and what does not, in one line."""
    parts = [f"{metrics.points} points, {metrics.solid_angle_sr:.4g} sr, accordance {metrics.accordance_class}"]
    left = [f"{number} {_LEFT_OUT[name]}" for name, number in metrics.left_out.items() if number]
    if left:
        parts.append("left out: " + ", ".join(left))
    if metrics.under_floor:
        parts.append(f"not in the shares of A: {metrics.under_floor} points with A under {metrics.floor_per_sr:g} 1/sr")
    if metrics.local_accordance_undefined:
        parts.append(f"no local accordance: {metrics.local_accordance_undefined} points with A + B <= 0")
    return "; ".join(parts)


def overview(comparison: Comparison) -> str:
    """What a comparison found, one row per region, scatter plane and integral."""
    return "\n".join(_overview(comparison))


def text(comparison: Comparison) -> str:
    """The whole comparison for a terminal."""
    return "\n".join(_lines(comparison))


def _overview(comparison: Comparison) -> Iterator[str]:
    yield from _names(comparison)
    regions, planes, integrals = [], [], []
    for pair in comparison.pairs:
        name = pair_name(pair)
        for region, metrics in pair.metrics.items():
            if region == "whole" or len(pair.metrics) > 2:
                regions.append((f"{name} {region}", *_in_short(metrics)))
        for profile in pair.profiles:
            shares = (_percent(share.value) for share in profile.within_percent)
            planes.append((f"{name} {profile.region}", _figure(profile.cv_rmsd.value), *shares))
        integrals += [(f"{name} {row[0]}", *row[1:3], *row[4:]) for row in integral_rows(pair.integrals)]
    limits = [f"within {share.limit:g} %" for share in next(iter(comparison.pairs[0].metrics.values())).within_percent]
    yield from _aligned(("", "points", "accordance f [%]", "RMSE [1/sr]", "CV", *limits, "2 u", "chi-square"), regions)
    yield from _aligned(("scatter plane", "CV(RMSD)", *limits), planes)
    yield from _aligned(("integral", "A", "B", *INTEGRAL_HEAD[4:]), integrals)
    yield from _rest(comparison)


def _in_short(metrics: Metrics) -> Iterator[str]:
    f = metrics.global_accordance_percent
    yield f"{metrics.points}"
    yield _with_u(f.value, f.u)
    yield _figure(metrics.rmse_per_sr.value)
    yield _figure(metrics.cv.value)
    yield from (_percent(share.value) for share in metrics.within_percent)
    yield from (_percent(share.value) for share in metrics.within_u if share.limit == COVERAGE_FACTOR)
    yield _figure(metrics.chi_square_with_correlations_per_point or metrics.chi_square_per_point, 3)


def _names(comparison: Comparison) -> Iterator[str]:
    yield f"A (reference): {comparison.a_name}"
    yield f"B ({comparison.b_kind}): {comparison.b_name}"


def _lines(comparison: Comparison) -> Iterator[str]:
    yield from _names(comparison)
    for pair in comparison.pairs:
        yield ""
        yield pair_title(pair)
        if pair.shared_effects:
            yield f"  shared by A and B: {', '.join(pair.shared_effects)}"
        for region, metrics in pair.metrics.items():
            if region == "whole" or len(pair.metrics) > 2:
                yield f"  {region}: {counted(metrics)}"
                yield from _aligned(METRIC_HEAD, metric_rows(metrics))
        if pair.integrals:
            yield f"  integrals (cones of {comparison.settings.cone_deg:g} degrees about)"
            yield from _aligned(INTEGRAL_HEAD, integral_rows(pair.integrals))
        for profile in pair.profiles:
            left = len(profile.used) - int(profile.used.sum())
            yield f"  scatter plane, {profile.region}: {len(profile.used)} angles, {left} left out"
            yield from _aligned(METRIC_HEAD, profile_rows(profile))
    yield from _rest(comparison)


def _rest(comparison: Comparison) -> Iterator[str]:
    """What was not compared, and remarks."""
    for side, names in (("A", comparison.unmatched_a), ("B", comparison.unmatched_b)):
        if names:
            yield ""
            yield f"only in {side}: {', '.join(names)}"
    for remark in comparison.remarks:
        yield f"remark: {remark}"


def _aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Columns under each other, the first one left, empty columns left out."""
    shown = [column for column in range(len(head)) if any(row[column] for row in rows)]
    table = [[row[column] for column in shown] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in table) for column in range(len(shown))]
    for row in table:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        yield f"    {'  '.join(cells)}".rstrip()


def _row(name: str, metric: Metric, *, sign: bool = False) -> tuple[str, ...]:
    return (
        name,
        _with_u(metric.value, metric.u, sign=sign),
        _with_u(metric.by_solid_angle, metric.u_by_solid_angle, sign=sign),
        _figure(metric.from_uncertainty),
        _figure(metric.in_u, sign=sign),
    )


def _alone(name: str, value: float | None, expected: str) -> tuple[str, ...]:
    return (name, _figure(value), "", expected, "")


def _share(name: str, share: Share, expected: str = "") -> tuple[str, ...]:
    by_solid_angle = "" if share.by_solid_angle is None else _percent(share.by_solid_angle)
    return (name, _percent(share.value), by_solid_angle, expected, "")


def _normal(limit: float) -> str:
    """Share of a normal distribution within so many standard deviations."""
    return f"{100.0 * math.erf(limit / math.sqrt(2.0)):.1f} %"


def _figure(value: float | None, digits: int = 4, *, sign: bool = False) -> str:
    if value is None or not math.isfinite(value):
        return _NONE
    return f"{value:+.{digits}g}" if sign else f"{value:.{digits}g}"


def _with_u(value: float | None, u: float | None, *, sign: bool = False) -> str:
    figure = _figure(value, sign=sign)
    return figure if u is None or not u > 0.0 or value is None else f"{figure} \u00b1 {u:.2g}"


def _percent(value: float | None) -> str:
    return _NONE if value is None or not math.isfinite(value) else f"{value:.1f} %"
