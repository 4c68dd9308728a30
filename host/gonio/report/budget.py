"""budget.py: which uncertainty budgets a report shows, of integrals, P_i and typical points; as text and as JSON."""

import re
import textwrap
from collections.abc import Iterable
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.budget import Budget, integral_budget, point_budget
from gonio.report.comparison import short_name

_NO_BUDGET = (
    "The dataset holds no uncertainty budget: it was simulated, or imported and not reduced. What is stated is the "
    "independent part alone, noise of the points and of the reference beam."
)
_COLUMNS = 100  # of a terminal
_LEAST_SHARE = 1e-4  # of the variance: smaller contributions are counted, not listed
# Integrals in this order first; names of others follow as they come. Model-filled parts stay out: estimates hold them.
_FIRST = (
    *("rho", "tau", "rho_direct", "tau_direct", "rho_diffuse", "tau_diffuse", "haze", "openness"),
    *("rho_estimate", "tau_estimate"),
)
_WORDS = {
    "rho": "\u03c1, covered directions",
    "tau": "\u03c4, covered directions",
    "rho_estimate": "\u03c1, masked directions modelled",
    "tau_estimate": "\u03c4, masked directions modelled",
    "rho_direct": "\u03c1 direct (regular)",
    "tau_direct": "\u03c4 direct (regular)",
    "rho_diffuse": "\u03c1 diffuse",
    "tau_diffuse": "\u03c4 diffuse",
    "p_i": "P_i of the reference beam",
    "closure": "closure of the beam",
}
# What the overview shows beside each other: the rest stands in the full tables.
OVERVIEW = (
    *(_WORDS[name] for name in ("rho", "tau", "rho_direct", "tau_direct", "rho_diffuse", "tau_diffuse")),
    *("haze", _WORDS["p_i"], _WORDS["closure"], "median point, reflection"),
)
_PEAK = re.compile(r"peak (?P<peak>.+) (?P<field>\w+)")
_CONE = re.compile(r"cone (?P<about>.+) (?P<half>[\d.]+)")


def integral_words(name: str) -> str:
    """What an integral is called in tables: its key where there is no better name."""
    if match := _CONE.fullmatch(name):
        return f"cone \u00b1{match['half']}\u00b0 about {match['about']}"
    if match := _PEAK.fullmatch(name):
        return f"peak {short_name(match['peak'])}, {match['field'].replace('_', ' ')}"
    return _WORDS.get(name, name.replace("_", " "))


def integral_names(d: Distribution) -> list[str]:
    """Integrals of a distribution that have a budget, in the order of the report."""
    found = [name for name in d.budgets if not name.endswith("_filled") and not _minor(name)]
    return sorted(found, key=lambda name: _FIRST.index(name) if name in _FIRST else len(_FIRST))


def _minor(name: str) -> bool:
    """Of a peak's fit only the integral is shown in tables; the rest is in the JSON."""
    return name.startswith("peak ") and not name.endswith(" integral")


def typical_points(d: Distribution) -> dict[str, int]:
    """Words and index of the points whose budget is shown, per hemisphere that was measured: the top of the highest
    peak, and the point with the median DSF by solid angle, which stands for the diffuse part."""
    found: dict[str, int] = {}
    incident_up = d.incident_theta_deg <= 90.0
    for words, upper in (("reflection", incident_up), ("transmission", not incident_up)):
        here = np.flatnonzero(d.measured & ((d.theta_deg <= 90.0) == upper) & np.isfinite(d.dsf_per_sr))
        weight = d.solid_angle_sr[here]
        if not len(here) or not weight.any():
            continue
        rising = np.argsort(d.dsf_per_sr[here], kind="stable")
        share = np.cumsum(weight[rising])
        found[f"highest point, {words}"] = int(here[rising[-1]])
        found[f"median point, {words}"] = int(here[rising[np.searchsorted(share, 0.5 * share[-1])]])
    return found


def integral_budgets(d: Distribution, *, every: bool = False) -> dict[str, Budget]:
    """Budgets of the integrals by their words; with `every` also those that tables leave out."""
    names = list(dict.fromkeys([*integral_names(d), *(d.budgets if every else ())]))
    budgets = ((integral_words(name), integral_budget(d, name)) for name in names)
    return {words: budget for words, budget in budgets if budget is not None}


def point_budgets(d: Distribution) -> dict[str, Budget]:
    """Budgets of the typical points by their words; empty where a distribution has noise alone."""
    if not d.effects:
        return {}
    budgets = ((words, point_budget(d, index)) for words, index in typical_points(d).items())
    return {words: budget for words, budget in budgets if budget is not None}


def sections(dataset: Dataset, *, every: bool = False) -> list[tuple[str, dict[str, Budget]]]:
    """Title and budgets, per distribution and for the free beam; without those that have none."""
    found = []
    for d in dataset.distributions:
        wavelength = "" if d.wavelength_nm is None else f", {d.wavelength_nm:g} nm"
        title = f"incident {d.incident_theta_deg:.4g}\u00b0 / {d.incident_phi_deg:.4g}\u00b0, {d.channel}{wavelength}"
        found.append((title, integral_budgets(d, every=every) | point_budgets(d)))
    if dataset.beam is not None:
        found.append(("free beam", integral_budgets(dataset.beam, every=every)))
    return [(title, budgets) for title, budgets in found if budgets]


def listed(budget: Budget) -> tuple[list[tuple[str, str, str, str]], int]:
    """Rows (contribution, percent of the value, percent of the variance, words), largest first, and how many that are
    too small to matter were left out."""
    kept = [row for row in budget.rows if row.variance_share >= _LEAST_SHARE]
    rows = [
        (
            f"{row.contribution:.3g}",
            "\u2013" if row.relative is None else f"{100 * row.relative:.3g}",
            f"{100 * row.variance_share:.1f}",
            row.words,
        )
        for row in kept
    ]
    return rows, len(budget.rows) - len(kept)


def headline(words: str, budget: Budget) -> str:
    """Value, combined and expanded uncertainty in one line."""
    unit = f" {budget.unit}" if budget.unit else ""
    at = f" ({budget.quantity.removeprefix('DSF at ')})" if budget.quantity.startswith("DSF at ") else ""
    relative = f" = {100 * budget.u / abs(budget.value):.3g} %" if budget.value else ""
    expanded = f"U = {budget.expanded_u:.3g} (k = {budget.coverage_factor:g})"
    return f"{words}{at}: {budget.value:.6g}{unit}, u = {budget.u:.3g}{relative}, {expanded}"


def without_budget(dataset: Dataset) -> str:
    """Why there is no budget, in words."""
    raw = [d for d in dataset.distributions if np.isnan(d.p_i)]
    if not raw:
        return _NO_BUDGET
    return (
        f"The points are a raw signal (unit {raw[0].signal_unit}) that nothing has normalised: there is no DSF, and no "
        "budget. Import them again with --beam or --p-i."
    )


def as_text(dataset: Dataset) -> str:
    """All budgets for a terminal."""
    lines: list[str] = [f"Uncertainty budget of {dataset.sample_name or 'unnamed sample'}, largest contribution first"]
    found = sections(dataset)
    if not found:
        return "\n".join([*lines, "", *textwrap.wrap(without_budget(dataset), _COLUMNS)])
    for title, budgets in found:
        lines += ["", title, "=" * len(title)]
        for words, budget in budgets.items():
            lines += [
                "",
                *textwrap.wrap(headline(words, budget), _COLUMNS, subsequent_indent="    "),
                *_text_table(budget),
            ]
    return "\n".join(lines)


def as_json(dataset: Dataset) -> dict[str, Any]:
    """All budgets, every contribution, as plain values without NaN."""
    return {
        "sample": dataset.sample_name,
        "sections": [
            {"of": title, "budgets": [{"name": words, **budget.as_json()} for words, budget in budgets.items()]}
            for title, budgets in sections(dataset, every=True)
        ],
    }


def _text_table(budget: Budget) -> Iterable[str]:
    rows, left_out = listed(budget)
    unit = budget.unit or "abs."
    of_variance = "% of u\u00b2"
    yield f"  {'u_i, ' + unit:>12}  {'% of value':>10}  {of_variance:>8}  effect"
    for contribution, of_value, of_variance, words in rows:
        yield f"  {contribution:>12}  {of_value:>10}  {of_variance:>8}  {words}"
    if left_out:
        yield f"  {'':>12}  {'':>10}  {'':>8}  {left_out} more, each below 0.01 % of u\u00b2"
