"""results.py: named results of a distribution: values, their standard uncertainties and budgets; sums over points."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain

FloatArray = NDArray[np.float64]

_MANY = 0.2


@dataclass
class Results:
    """What goes into Distribution.integrals and Distribution.budgets."""

    values: dict[str, float] = field(default_factory=dict)
    budgets: dict[str, dict[str, float]] = field(default_factory=dict)

    def put(self, name: str, result: Uncertain) -> None:
        """`name`, `name`_u and the budget; nothing where the value is no number."""
        if not np.isfinite(result.value) or not np.isfinite(result.u):
            return
        self.values[name] = result.value
        self.values[f"{name}_u"] = result.u
        self.budgets[name] = result.budget

    def add(self, other: "Results") -> None:
        """All of another."""
        self.values |= other.values
        self.budgets |= other.budgets

    def into(self, distribution: Distribution) -> None:
        """Writes them to the distribution beside what it has."""
        distribution.integrals |= self.values
        distribution.budgets |= self.budgets


def weighted_sum(distribution: Distribution, weight: FloatArray) -> Uncertain:
    """sum w DSF over measured points, `weight` (n,), as dataset.uncertainty.linear_result, at the cost of the points
    whose weight is not 0; with the effect `p_i` of a distribution that has no column for it."""
    counts = distribution.measured & (weight != 0.0)
    used = np.flatnonzero(counts)
    if len(used) > _MANY * len(weight):  # to choose so many points costs more than to go through all
        w = np.where(counts, weight, 0.0)

        def of(column: FloatArray) -> FloatArray:
            return np.where(counts, column, 0.0)
    else:
        w = weight[used]

        def of(column: FloatArray) -> FloatArray:
            return column[used]

    value = _dot(w, of(distribution.dsf_per_sr))
    independent = float(np.sqrt(_dot(w**2, of(distribution.variance_per_sr2))))
    effects = {name: _dot(w, of(column)) for name, column in distribution.effects.items()}
    if "p_i" not in effects and distribution.p_i_u_rel > 0.0:
        effects["p_i"] = -distribution.p_i_u_rel * value  # DSF = E / P_i: what P_i has too much the DSF has too little
    return Uncertain(value, independent, effects)


def weighted_ratio(distribution: Distribution, above: FloatArray, below: FloatArray) -> Uncertain:
    """(sum a DSF) / (sum b DSF), weights (n,), to first order (GUM, JCGM 100:2008, 5.1.2) and in one step, as both sums
    share points: what moves both alike, P_i for one, cancels. Raises ZeroDivisionError."""
    used = distribution.measured
    lower = float(below[used] @ distribution.dsf_per_sr[used])
    if lower == 0.0:
        raise ZeroDivisionError("the sum below the line is 0")
    ratio = float(above[used] @ distribution.dsf_per_sr[used]) / lower
    change = weighted_sum(distribution, (above - ratio * below) / lower)
    return Uncertain(ratio, change.independent, change.effects)


def _dot(a: FloatArray, b: FloatArray) -> float:
    """In one thread: a sum of a few hundred thousand products is over before others have been woken."""
    return float(np.einsum("i,i", a, b))
