"""budget.py: the uncertainty budget of an integral or a point as a table, largest contribution first."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Distribution
from gonio.dataset.effects import effect_of

COVERAGE_FACTOR = 2.0


@dataclass(frozen=True)
class BudgetRow:
    """One effect: `contribution` in the unit of the value, of its absolute value (None where that is 0), and the share
    of the combined variance."""

    effect: str
    words: str
    contribution: float
    relative: float | None
    variance_share: float


@dataclass(frozen=True)
class Budget:
    """A value, its combined standard uncertainty u, expanded uncertainty k u (GUM 6.2.1), and where u comes from."""

    quantity: str
    value: float
    unit: str
    u: float
    rows: tuple[BudgetRow, ...]
    coverage_factor: float = COVERAGE_FACTOR

    @property
    def expanded_u(self) -> float:
        """k u: an interval of about 95 % of confidence where the value's distribution is near a normal one."""
        return self.coverage_factor * self.u

    def as_json(self) -> dict[str, Any]:
        """Plain JSON values, no NaN."""
        return {
            "quantity": self.quantity,
            "value": self.value,
            "unit": self.unit,
            "u": self.u,
            "coverage_factor": self.coverage_factor,
            "expanded_u": self.expanded_u,
            "rows": [vars(row) for row in self.rows],
        }


def budget_of(quantity: str, value: float, contributions: Mapping[str, float], unit: str = "") -> Budget:
    """From the contributions [unit of the value] by key (dataset/effects.py), signed or not; zeros are left out."""
    u = float(np.linalg.norm([0.0, *contributions.values()]))
    parts = sorted(((name, abs(part)) for name, part in contributions.items() if part != 0.0), key=lambda x: -x[1])
    rows = (
        BudgetRow(name, words_of(name), part, part / abs(value) if value != 0.0 else None, (part / u) ** 2)
        for name, part in parts
    )
    return Budget(quantity, value, unit, u, tuple(rows))


def integral_budget(distribution: Distribution, name: str) -> Budget | None:
    """The stored budget of an integral (rho: of rho_measured); None where there is none, or no value."""
    contributions = distribution.budgets.get(name)
    value = distribution.integrals.get(name, distribution.integrals.get(f"{name}_measured"))
    if contributions is None or value is None or not np.isfinite(value):
        return None
    return budget_of(name, value, contributions)


def point_budget(distribution: Distribution, index: int) -> Budget | None:
    """The budget of one point's DSF; None where it is masked."""
    if not distribution.measured[index] or not np.isfinite(distribution.dsf_per_sr[index]):
        return None
    contributions = {"independent": float(np.sqrt(distribution.variance_per_sr2[index]))}
    contributions |= {name: float(column[index]) for name, column in distribution.effects.items()}
    theta, phi = distribution.theta_deg[index], distribution.phi_deg[index]
    return budget_of(f"DSF at {theta:.2f}, {phi:.2f}", float(distribution.dsf_per_sr[index]), contributions, "1/sr")


def words_of(key: str) -> str:
    """What a key is called: the effect in the terms of ASTM E2387, its detail (an axis, say), and where it was kept
    apart in a merge. A key that this version does not know is its own name."""
    body, _, scope = key.partition(" #")
    _, _, detail = body.partition(" ")
    try:
        words = effect_of(key).words
    except KeyError:
        return key
    return words + (f" ({detail})" if detail else "") + (f", {scope}" if scope else "")
