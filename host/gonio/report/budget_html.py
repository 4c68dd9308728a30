"""budget_html.py: the report's section on uncertainty: budgets beside each other, then each of them in full."""

from gonio.dataset.bsdf import Dataset
from gonio.dataset.budget import Budget
from gonio.report.budget import OVERVIEW, headline, listed, sections, without_budget
from gonio.report.html_parts import folded, number, paragraph, subtitle, table

_MOST_ROWS = 14  # effects in the overview
_LEAST_PERCENT = 0.001  # of the value: what is smaller is no news
_MANY = 6  # more sections than this are folded


def uncertainty(dataset: Dataset) -> str:
    """Overview per incident direction, contributions in percent of the value; below it every budget as a table."""
    found = sections(dataset)
    if not found:
        return paragraph(without_budget(dataset), "note")
    parts = [
        paragraph(
            "Contributions to the combined standard uncertainty (k = 1), in percent of the value, on the whole largest "
            "first; the terms are those of ASTM E2387. One effect moves all points together and adds up with its sign; "
            "different effects are independent of each other. U is expanded with k = 2: an interval of about 95 %.",
            "note",
        )
    ]
    for title, budgets in found:
        inner = _overview(budgets) + folded("Each budget in full", *(_full(w, b) for w, b in budgets.items()))
        heading = title[0].upper() + title[1:]
        parts.append(folded(heading, inner) if len(found) > _MANY else subtitle(heading) + inner)
    return "".join(parts)


def _overview(budgets: dict[str, Budget]) -> str:
    """Rows are effects by their mean share of the variance, columns are the quantities that matter most."""
    chosen = {words: budget for words, budget in budgets.items() if words in OVERVIEW} or budgets
    shares: dict[str, float] = {}
    for budget in chosen.values():
        for row in budget.rows:
            shares[row.words] = shares.get(row.words, 0.0) + row.variance_share
    effects = sorted(shares, key=lambda words: -shares[words])[:_MOST_ROWS]
    columns = []
    for budget in chosen.values():
        relative = {row.words: row.relative for row in budget.rows}
        of_value = budget.u / abs(budget.value) if budget.value else None
        ends = [_percent(of_value), _percent(None if of_value is None else budget.coverage_factor * of_value)]
        columns.append([f"{budget.value:.5g}", *(_percent(relative.get(words)) for words in effects), *ends])
    names = ["value", *effects, "u, combined [%]", "U, k = 2 [%]"]
    rows = [[name, *(column[i] for column in columns)] for i, name in enumerate(names)]
    return table(["effect [% of the value]", *chosen], rows, strong_rows=(0, len(names) - 2, len(names) - 1), wide=True)


def _full(words: str, budget: Budget) -> str:
    rows, left_out = listed(budget)
    cells = [[effect, contribution, of_value, of_variance] for contribution, of_value, of_variance, effect in rows]
    if left_out:
        cells.append([f"{left_out} more, each below 0.01 % of u\u00b2", "", "", ""])
    unit = f" [{budget.unit}]" if budget.unit else ""
    head = ["effect", f"contribution{unit}", "% of value", "% of u\u00b2"]
    return paragraph(headline(words, budget)) + table(head, cells)


def _percent(relative: float | None) -> str:
    if relative is None:
        return ""
    percent = 100 * relative
    if percent >= 100:
        return f"{percent:.0f}"
    return number(percent, 2) if percent >= _LEAST_PERCENT else f"< {_LEAST_PERCENT:g}"
