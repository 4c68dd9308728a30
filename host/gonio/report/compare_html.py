"""compare_html.py: writes a comparison as one self-contained HTML file: metrics in tables, and A beside B."""

from html import escape
from pathlib import Path

from gonio.compare.result import Comparison, Metrics, Pair
from gonio.compare.table import (
    INTEGRAL_HEAD,
    METRIC_HEAD,
    counted,
    integral_rows,
    metric_rows,
    pair_title,
    profile_rows,
)
from gonio.formats import atomic
from gonio.report import compare_figures
from gonio.report.html import page
from gonio.report.html_parts import bullets, facts, figure, folded, number, paragraph, section, subtitle, table
from gonio.report.polar_map import scale_words

_MANY = 4  # more pairs than this are folded away
_KINDS = {
    "dataset": "dataset",
    "scenario": "closed form, evaluated at A's directions",
    "matrices": "Klems matrices, evaluated at A's directions",
    "tree": "tensor tree, evaluated at A's directions",
    "model": "model, evaluated at A's directions",
    "simulation": "simulated at A's directions",
}


def write_compare(comparison: Comparison, path: Path) -> None:
    """Writes the report, whole or not at all."""
    atomic.write_bytes(path, render_compare(comparison).encode("utf-8"))


def render_compare(comparison: Comparison) -> str:
    """The HTML document."""
    many = len(comparison.pairs) > _MANY
    bodies = []
    for pair in comparison.pairs:
        body = _figures(comparison, pair) + _tables(pair)
        title = pair_title(pair)
        bodies.append(folded(title, body) if many else subtitle(title[0].upper() + title[1:]) + body)
    notes = [f"Only in A: {name}" for name in comparison.unmatched_a]
    notes += [f"Only in B: {name}" for name in comparison.unmatched_b]
    notes += list(comparison.remarks)
    parts = [
        section("overview", "Overview", _overview(comparison)),
        section("pairs", "A beside B", *bodies),
        section("remarks", "Remarks", bullets(notes)) if notes else "",
    ]
    a, b = Path(comparison.a_name).name, Path(comparison.b_name).name
    head = paragraph(f"A, the reference: {comparison.a_name}. B: {comparison.b_name}.", "lead") + facts(
        {
            "B is a": _KINDS[comparison.b_kind],
            "Pairs compared": str(len(comparison.pairs)),
            "Incident directions within": f"{comparison.settings.incident_tolerance_deg:g}\u00b0",
            "Shares count A above": f"{comparison.settings.floor_per_sr:g} 1/sr",
            "Cones of": f"\u00b1{comparison.settings.cone_deg:g}\u00b0",
        }
    )
    title = f"{b} against {a}"
    header = f'<header><div class="eyebrow">gonio \u00b7 comparison</div><h1>{escape(title)}</h1>{head}</header>'
    return page(f"{title} \u2013 comparison", f"{header}<main>{''.join(parts)}</main>")


def _overview(comparison: Comparison) -> str:
    """One row per pair and region: the figures that decide."""
    rows = []
    for pair in comparison.pairs:
        for region, metrics in pair.metrics.items():
            if region == "whole" or len(pair.metrics) > 2:
                rows.append(_overview_row(pair, region, metrics))
    head = [
        "channel, incident",
        "region",
        "points",
        "global accordance [%]",
        "class",
        "local accordance [%]",
        "CV",
        "within 10 %",
        "beyond 2 u",
        "chi-square per point",
    ]
    note = (
        "Global accordance: one less the root of the sum of (A \u2212 B)\u00b2 over the sum of (A + B)\u00b2; "
        "98 % is good, 99 % very good. "
        "Local: the mean of the same at every point. Beyond 2 u: points whose difference exceeds twice its standard "
        "uncertainty; 4.6 % are expected. Chi-square: 1 where the uncertainties explain the differences."
    )
    return table(head, rows, name_columns=(1, 4)) + paragraph(note, "note")


def _overview_row(pair: Pair, region: str, metrics: Metrics) -> list[str]:
    within = {share.limit: share.value for share in metrics.within_percent}
    in_u = {share.limit: share.value for share in metrics.within_u}
    beyond = None if in_u.get(2.0) is None else 100.0 - float(in_u[2.0] or 0.0)
    return [
        f"{pair.channel}, {pair.incident_theta_deg:.4g}\u00b0 / {pair.incident_phi_deg:.4g}\u00b0",
        region,
        f"{metrics.points:,}",
        number(metrics.global_accordance_percent.value, 5),
        metrics.accordance_class,
        number(metrics.local_accordance_percent.value, 5),
        number(metrics.cv.value, 3),
        _percent(within.get(10.0)),
        _percent(beyond),
        number(metrics.chi_square_per_point, 3),
    ]


def _figures(comparison: Comparison, pair: Pair) -> str:
    if not pair.used.any():
        return paragraph("A and B have no point in common.", "warn")
    names = (f"A, {Path(comparison.a_name).name}", f"B, {Path(comparison.b_name).name}")
    of = compare_figures.pictures(pair)
    incident = f"{pair.incident_theta_deg:.4g}\u00b0 / {pair.incident_phi_deg:.4g}\u00b0, {pair.channel}"
    end, beyond = compare_figures.difference_end(compare_figures.relative_percent(pair))
    shown = [
        figure(
            compare_figures.side_by_side(pair, of),
            f"Polar maps of A and B for incidence {incident}",
            "DSF of A and B on one logarithmic scale, at the nearest of A's points. Hatched: A or B has no value."
            + scale_words(of.scale),
        ),
        figure(
            compare_figures.differences(pair, of),
            f"Difference and local accordance for incidence {incident}",
            f"Relative difference: blue where B is lower, orange where it is higher; {100 * beyond:.2g} % of the "
            f"points lie beyond {end:g} % and have the colours at the ends of the bar. White: A is not above zero. "
            "Local accordance: 100 % where A and B agree, 0 % where one of them is zero.",
        ),
    ]
    if plane := compare_figures.planes(pair, names):
        caption = (
            "Scatter planes with bands of k = 2 combined uncertainties. Below: deviation of B from A (dots), and the "
            "bands of both about zero, A blue, B orange; what A and B have in common is in both bands but not in their "
            "difference."
        )
        shown.append(figure(plane, f"Scatter planes for incidence {incident}", caption))
    if overlay := compare_figures.paths(pair, names):
        lone = pair.path_b is None
        caption = "Detector path of A; B needs none." if lone else "Detector paths of A and B on top of each other."
        shown.append(folded("Paths", figure(overlay, f"Detector paths for incidence {incident}", caption)))
    return "".join(shown)


def _tables(pair: Pair) -> str:
    parts = []
    for region, metrics in pair.metrics.items():
        if region == "whole" or len(pair.metrics) > 2:
            parts.append(paragraph(f"{region.capitalize()}: {counted(metrics)}."))
            parts.append(table(METRIC_HEAD, metric_rows(metrics), wide=True))
    if pair.integrals:
        parts.append(paragraph("Integrals:"))
        parts.append(table(INTEGRAL_HEAD, integral_rows(pair.integrals)))
    for profile in pair.profiles:
        parts.append(paragraph(f"Scatter plane, {profile.region}: {int(profile.used.sum()):,} angles."))
        parts.append(table(METRIC_HEAD, profile_rows(profile), wide=True))
    if pair.shared_effects:
        parts.append(paragraph(f"Shared by A and B, so that they cancel: {', '.join(pair.shared_effects)}.", "note"))
    return folded("Metrics in full", *parts, opened=True)


def _percent(value: float | None) -> str:
    return "\u2013" if value is None else f"{value:.1f} %"
