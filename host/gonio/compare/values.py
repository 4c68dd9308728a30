"""values.py: the DSF of one side of a comparison at the directions of A, with its independent and its shared errors."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.dataset.effects import effect_of
from gonio.dataset.uncertainty import Uncertain

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Spread:
    """Values that are weighted means of three points of another list: index and weight (n, 3), the points' independent
    variance (m,). Two values that share a point share its noise."""

    index: NDArray[np.intp]
    weight: FloatArray
    variance_per_sr2: FloatArray


@dataclass(frozen=True)
class Values:
    """DSF [1/sr] at n directions, NaN where there is none; variance of the independent part (n,) and the change (n,)
    for one standard deviation of each systematic effect."""

    dsf_per_sr: FloatArray
    variance_per_sr2: FloatArray
    effects: Mapping[str, FloatArray] = field(default_factory=dict)
    spread: Spread | None = None  # of interpolated values

    @property
    def u_per_sr(self) -> FloatArray:
        """Combined standard uncertainty (n,)."""
        return np.sqrt(self.variance_per_sr2 + sum(column**2 for column in self.effects.values()))

    def linear(self, weight: FloatArray) -> Uncertain:
        """sum w DSF over the points of weight (n,) other than 0, which must have a value."""
        at = np.flatnonzero(weight)
        w = weight[at]
        if self.spread is None:
            variance = w**2 @ self.variance_per_sr2[at]
        else:
            index, parts = self.spread.index[at].ravel(), (w[:, None] * self.spread.weight[at]).ravel()
            on_source = np.bincount(index, parts, len(self.spread.variance_per_sr2))
            touched = np.flatnonzero(on_source)
            variance = on_source[touched] ** 2 @ self.spread.variance_per_sr2[touched]
        effects = dict(zip(self.effects, (self._rows @ weight).tolist(), strict=True))
        return Uncertain(float(w @ self.dsf_per_sr[at]), float(np.sqrt(variance)), effects)

    @cached_property
    def _rows(self) -> FloatArray:
        """All effects (m, n), 0 where there is no value."""
        rows = np.zeros((len(self.effects), len(self.dsf_per_sr)))
        for row, column in zip(rows, self.effects.values(), strict=True):
            np.copyto(row, column, where=np.isfinite(column))
        return rows

    def with_own_effects(self, mark: str, shared: frozenset[str]) -> "Values":
        """With effects that are not `shared` renamed after this side, so that they never cancel with the other's."""
        renamed = {name if name in shared else f"{name} @{mark}": column for name, column in self.effects.items()}
        return replace(self, effects=renamed)


def values_of(distribution: Distribution) -> Values:
    """A distribution's own values; P_i's uncertainty becomes an effect where the dataset only has the number, and
    simulated points that no photon reached have the variance of one photon: their own stands as 0."""
    measured = distribution.measured
    dsf = np.where(measured, distribution.dsf_per_sr, np.nan)
    effects = dict(distribution.effects)
    if distribution.p_i_u_rel > 0.0 and not any(effect_of(name).name == "p_i" for name in effects):
        effects["p_i"] = distribution.p_i_u_rel * dsf
    variance = np.where(np.isfinite(distribution.variance_per_sr2), distribution.variance_per_sr2, 0.0)
    hit = measured & (distribution.count > 0) & (variance > 0.0)
    unseen = measured & (distribution.flags & PointFlag.SIMULATED != 0) & (distribution.count == 0) & (variance == 0.0)
    if unseen.any() and hit.any():
        variance[unseen] = np.median(dsf[hit] / distribution.count[hit]) ** 2
    return Values(dsf, variance, effects)


def modelled(dsf_per_sr: FloatArray) -> Values:
    """Values (n,) of a model, which states no uncertainty."""
    return Values(dsf_per_sr, np.zeros(len(dsf_per_sr)))


def shared_effects(a: Distribution, b: Distribution, *, one_instrument: bool) -> frozenset[str]:
    """Effects whose cause is the same in both: those of the instrument itself, if one instrument measured both. A scope
    ("#2") counts within its own file only."""
    if not one_instrument:
        return frozenset()
    both = a.effects.keys() & b.effects.keys()
    return frozenset(name for name in both if "#" not in name and effect_of(name).reach == "instrument")


def difference_u_per_sr(a: Values, b: Values) -> FloatArray:
    """Standard uncertainty (n,) of A - B, effects of one name having one cause."""
    variance = a.variance_per_sr2 + b.variance_per_sr2
    for column in difference_effects(a, b).values():
        variance = variance + column**2
    return np.sqrt(variance)


def difference_effects(a: Values, b: Values) -> dict[str, FloatArray]:
    """Change (n,) of A - B for one standard deviation of each effect of either side."""
    changes = dict(a.effects)
    for name, column in b.effects.items():
        changes[name] = changes[name] - column if name in changes else -column
    return changes
