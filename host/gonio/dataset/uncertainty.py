"""uncertainty.py: a value with what is independent and what is shared in its uncertainty, kept apart through sums."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Uncertain:
    """A value, the standard uncertainty of its independent part, and its signed change for one standard deviation of
    each systematic effect (GUM, JCGM 100:2008, 5.1.3 and 5.2.2: full correlation within an effect, none between).

    Two values must not share independent parts: sums of the same points are formed with `linear_result`, in one step.
    """

    value: float
    independent: float = 0.0
    effects: Mapping[str, float] = field(default_factory=dict)

    @property
    def u(self) -> float:
        """Combined standard uncertainty."""
        return float(np.hypot(self.independent, np.linalg.norm([0.0, *self.effects.values()])))

    @property
    def budget(self) -> dict[str, float]:
        """Contribution of each effect and of the independent part, in absolute value, largest first."""
        parts = {"independent": self.independent, **{name: abs(part) for name, part in self.effects.items()}}
        return dict(sorted(parts.items(), key=lambda item: -item[1]))

    def scaled(self, factor: float) -> "Uncertain":
        """Times an exact number."""
        effects = {name: factor * part for name, part in self.effects.items()}
        return Uncertain(factor * self.value, abs(factor) * self.independent, effects)

    def with_effect(self, name: str, change: float) -> "Uncertain":
        """With one more effect, or more of one that is there: changes of one effect add up with their signs."""
        return Uncertain(self.value, self.independent, {**self.effects, name: self.effects.get(name, 0.0) + change})

    def plus(self, other: "Uncertain") -> "Uncertain":
        """The sum."""
        return _combined(self.value + other.value, (1.0, self), (1.0, other))

    def minus(self, other: "Uncertain") -> "Uncertain":
        """The difference: what both share cancels."""
        return _combined(self.value - other.value, (1.0, self), (-1.0, other))

    def times(self, other: "Uncertain") -> "Uncertain":
        """The product, to first order."""
        return _combined(self.value * other.value, (other.value, self), (self.value, other))

    def over(self, other: "Uncertain") -> "Uncertain":
        """The ratio, to first order. Raises ZeroDivisionError."""
        ratio = self.value / other.value
        return _combined(ratio, (1.0 / other.value, self), (-ratio / other.value, other))


def linear_result(distribution: Distribution, weight: FloatArray) -> Uncertain:
    """sum w DSF over the measured points, `weight` (n,): u^2 = sum w^2 sigma^2 + sum over effects (w . s_m)^2.

    Masked points do not count, whatever their weight.
    """
    measured = distribution.measured
    w = weight[measured]
    independent = float(np.sqrt(w**2 @ distribution.variance_per_sr2[measured]))
    effects = {name: float(w @ column[measured]) for name, column in distribution.effects.items()}
    return Uncertain(float(w @ distribution.dsf_per_sr[measured]), independent, effects)


def combined_u_per_sr(distribution: Distribution) -> FloatArray:
    """Standard uncertainty of every point's DSF, independent and systematic together, shape (n,); NaN where masked."""
    total = distribution.variance_per_sr2.copy()
    for column in distribution.effects.values():
        total += column**2
    return np.sqrt(total)


def _combined(value: float, *parts: tuple[float, Uncertain]) -> Uncertain:
    effects: dict[str, float] = {}
    for factor, part in parts:
        for name, change in part.effects.items():
            effects[name] = effects.get(name, 0.0) + factor * change
    independent = float(np.linalg.norm([factor * part.independent for factor, part in parts]))
    return Uncertain(value, independent, effects)
