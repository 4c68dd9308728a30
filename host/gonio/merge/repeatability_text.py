"""repeatability_text.py: the repeatability report as lines of text."""

from collections.abc import Sequence

import numpy as np

from gonio.merge.repeatability import Quantity, Scatter
from gonio.merge.variance_components import Component

_MEANING = {
    "day": "different day",
    "mount": "remounted",
    "position": "shifted position",
    "repeat": "same mount and position",
}


def lines(quantities: Sequence[Quantity]) -> list[str]:
    """A block per result: mean, one line per level, and whether the stated uncertainties explain the scatter."""
    told: list[str] = []
    for q in quantities:
        theta, phi = q.incident_deg
        mean = q.analysis.mean
        u = float(np.sqrt(q.analysis.variance_of_mean))
        told.append(
            f"{q.name}, {q.channel}, incident ({theta:g}, {phi:g}): mean {mean:.6g} +- {u:.2g} of {q.analysis.count}"
        )
        told += [f"  {_level(component, mean)}" for component in q.analysis.components]
        told.append(f"  {_stated(q.scatter, mean)}")
    return told


def _level(component: Component, mean: float) -> str:
    name = f"{_MEANING.get(component.level, component.level):<24}"
    if component.variance is None or component.low is None or component.high is None:
        return f"{name}not told by these runs"
    s = float(np.sqrt(max(component.variance, 0.0)))
    low, high = float(np.sqrt(component.low)), float(np.sqrt(component.high))
    test = "" if component.p is None else f", F {component.f:.2f}, p {component.p:.3f}"
    dof = f"{component.dof} dof{test}"
    return f"{name}s {s:.3g} ({_relative(s, mean)}), 95 %: {low:.3g} to {high:.3g}, {dof}"


def _stated(scatter: Scatter | None, mean: float) -> str:
    if scatter is None:
        return "no stated uncertainty to compare with"
    verdict = "explained" if scatter.explained else "NOT explained"
    whole = "" if scatter.budgets else ", no budgets: all of it taken as each run's own"
    return (
        f"scatter {verdict} by the stated uncertainties ({_relative(scatter.stated_u, mean)}{whole}): chi2 "
        f"{scatter.chi2:.1f} of {scatter.dof}, p {scatter.probability:.3f}"
    )


def _relative(s: float, mean: float) -> str:
    return f"{s / abs(mean):.2%}" if mean else f"{s:.3g}"
