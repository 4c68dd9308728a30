"""held_out.py: how well families predict what they have not seen; the choice between them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gonio.model.analytic.component import Component
from gonio.model.analytic.component_fit import Fitted, fit_component, theta_deg, without
from gonio.model.analytic.family import Family, Process
from gonio.model.analytic.targets import tie_of
from gonio.model.analytic.weighting import left, thinned
from gonio.model.nodes.points import Points

LEAST_DIRECTIONS = 3  # from which on whole incident directions are left out
_EVERY = 5  # else every fifth point is kept back
_MOST_POINTS = 3000  # per distribution


def rule(directions: Sequence[Points]) -> str:
    """What is held out, in words."""
    if len(directions) >= LEAST_DIRECTIONS:
        return "leave one incident direction out"
    return f"fit without every {_EVERY}th point, judged on those"


def held_out(family: Family, process: Process, directions: Sequence[Points]) -> dict[str, Any]:
    """One line of the table: family, number of parameters per fit, cv and misplaced (weighting.Left) as means over
    what was held out, and the same per incident angle."""
    thin = [thinned(points, _MOST_POINTS) for points in directions]
    found = []
    if len(thin) >= LEAST_DIRECTIONS:
        fitted: Fitted = fit_component(family, process, thin)
        for number, points in enumerate(thin):
            found.append((points, _tied(without(fitted, thin, number), thin[:number] + thin[number + 1 :])))
    else:
        parts = [(_rows(points, back=False), _rows(points, back=True)) for points in thin]
        component = fit_component(family, process, [seen for seen, _ in parts]).component
        component = _tied(component, [seen for seen, _ in parts])
        found = [(back, component) for _, back in parts]
    errors = [(points, _error(component, points)) for points, component in found]
    return {
        "family": family.name,
        "parameters": len(family.parameters),
        "misplaced": float(np.mean([error[0] for _, error in errors])),
        "cv": float(np.mean([error[1] for _, error in errors])),
        "directions": [
            {"theta_i_deg": theta_deg(points), "misplaced": misplaced, "cv": cv} for points, (misplaced, cv) in errors
        ],
    }


def best(table: Sequence[dict[str, Any]]) -> str:
    """Name of the family that sends least light elsewhere; within 2 % of that, the one with fewest parameters."""
    least = min(line["misplaced"] for line in table)
    near = [line for line in table if line["misplaced"] <= 1.02 * least + 1e-6]
    return str(min(near, key=lambda line: (line["parameters"], line["misplaced"]))["family"])


def _error(component: Component, points: Points) -> tuple[float, float]:
    which = np.zeros(len(points.dsf_per_sr), dtype=np.int64)
    error = left(points, component.dsf_per_sr(points.incident[None, :], points.unit, which))
    return error.misplaced, error.cv


def _tied(component: Component, directions: Sequence[Points]) -> Component:
    """As it would be delivered: its integral tied to that of what was seen."""
    return replace(component, tie=tie_of(component, directions, (), ""))


def _rows(points: Points, *, back: bool) -> Points:
    return points.some((np.arange(len(points.dsf_per_sr)) % _EVERY == 0) == back)
