"""variance_components.py: analysis of variance of repeated results with nested random effects, balanced or not."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_DRAWS = 20_000
_SEED = 1
_COVERAGE = 0.95


@dataclass(frozen=True)
class Component:
    """One level. `dof` 0: the design does not tell its variance, which is None then. A method-of-moments estimate can
    come out negative: it says that nothing is to be seen of this level. `low`, `high`: 95 % interval of the variance,
    not below 0; `f` and `p`: whether the mean square is larger than without this component."""

    level: str
    groups: int
    dof: int
    mean_square: float | None = None
    variance: float | None = None
    low: float | None = None
    high: float | None = None
    f: float | None = None
    p: float | None = None


@dataclass(frozen=True)
class Analysis:
    """`components` from the outermost level to the repeats; `variance_of_mean`: of the plain mean, by components that
    are not negative."""

    mean: float
    count: int
    components: tuple[Component, ...]
    variance_of_mean: float


def analyse(values: FloatArray, labels: Sequence[Sequence[str]], levels: Sequence[str]) -> Analysis:
    """Analysis of variance of values (n,). `labels` has one entry per value, outermost level first; a label means
    something only within those before it. The innermost level, the repeats, needs no label: `levels` names it last.

    Sums of squares in sequence, equated to their expectations (C. R. Henderson, Biometrics 9 (1953) 226, method 1;
    S. R. Searle, Linear Models, 1971, ch. 11): with T_l = sum over groups g of level l of n_g mean_g^2, the variance of
    level k enters E(T_l) with sum n_gh^2 / n_g over groups g of l and h of k. Intervals: every sum of squares is drawn
    as its chi-square says, and the equations are solved for each draw (generalised confidence intervals, S. Weerahandi,
    J. Am. Stat. Assoc. 88 (1993) 899); exact for the repeats, good for nearly balanced designs.
    """
    groups = _groups(labels, len(values))  # one index (n,) per level, the whole first, single values last
    sizes = np.array([int(index.max()) + 1 for index in groups])
    dof = np.diff(sizes)
    squares = np.array([_square(values, index) for index in groups])
    between = np.maximum(np.diff(squares), 0.0)
    shares = np.array([[_shared(over, of) for of in groups[1:]] for over in groups])
    expected = np.diff(shares, axis=0)  # E(SS_l) = sum_k expected[l, k] variance_k
    known = np.flatnonzero(dof > 0)
    design = expected[np.ix_(known, known)]
    variance = np.linalg.solve(design, between[known]) if len(known) else np.zeros(0)
    low, high = _intervals(design, between[known], dof[known])
    f, p = _f_tests(design, between[known], dof[known])
    where = {int(level): k for k, level in enumerate(known)}
    components = []
    for level, name in enumerate(levels):
        k = where.get(level)
        if k is None:
            components.append(Component(name, int(sizes[level + 1]), 0))
            continue
        components.append(
            Component(
                level=name,
                groups=int(sizes[level + 1]),
                dof=int(dof[level]),
                mean_square=float(between[level] / dof[level]),
                variance=float(variance[k]),
                low=float(low[k]),
                high=float(high[k]),
                f=f[k],
                p=p[k],
            )
        )
    # The plain mean: a level's variance enters with sum n_h^2 / N^2.
    of_mean = float(np.maximum(variance, 0.0) @ shares[0][known]) / len(values) if len(known) else 0.0
    return Analysis(float(np.mean(values)), len(values), tuple(components), of_mean)


def _groups(labels: Sequence[Sequence[str]], n: int) -> list[IntArray]:
    found = [np.zeros(n, dtype=np.int64)]
    for depth in range(1, len(labels[0]) + 1):
        numbers: dict[tuple[str, ...], int] = {}
        found.append(np.array([numbers.setdefault(tuple(row[:depth]), len(numbers)) for row in labels]))
    found.append(np.arange(n))
    return found


def _square(values: FloatArray, index: IntArray) -> float:
    sums, sizes = np.bincount(index, values - values.mean()), np.bincount(index)
    return float(np.sum(sums**2 / sizes))


def _shared(over: IntArray, of: IntArray) -> float:
    """sum over groups g of one level and h of another of n_gh^2 / n_g."""
    size = np.bincount(over)
    pair, count = np.unique(np.stack((over, of)), axis=1, return_counts=True)
    return float(np.sum(count**2 / size[pair[0]]))


def _intervals(design: FloatArray, squares: FloatArray, dof: IntArray) -> tuple[FloatArray, FloatArray]:
    if not len(dof):
        return np.zeros(0), np.zeros(0)
    rng = np.random.default_rng(_SEED)
    # design E(SS): of a level with its own chi-square, E(SS) is SS dof / chi-square.
    drawn = (squares * dof)[:, None] / rng.chisquare(dof[:, None], (len(dof), _DRAWS))
    variances = np.maximum(np.linalg.solve(design, drawn), 0.0)
    tail = 50.0 * (1.0 - _COVERAGE)
    low, high = np.percentile(variances, [tail, 100.0 - tail], axis=1)
    return low, high


def _f_tests(design: FloatArray, squares: FloatArray, dof: IntArray) -> tuple[list[float | None], list[float | None]]:
    """F and its probability: a level's mean square against what it would be expected to be without its own component
    (F. E. Satterthwaite's degrees of freedom, Biometrics Bulletin 2 (1946) 110)."""
    from scipy.stats import f as f_distribution  # noqa: PLC0415 - scipy's statistics load slowly

    mean_squares = squares / dof
    per_dof = design / dof[:, None]
    inverse = np.linalg.inv(design * (1.0 / dof)[:, None]) if len(dof) else design
    f: list[float | None] = []
    p: list[float | None] = []
    for k in range(len(dof)):
        rest = per_dof[k].copy()
        rest[k] = 0.0
        terms = (rest @ inverse) * mean_squares  # the expected mean square as a sum of mean squares
        below = float(terms.sum())
        if k == len(dof) - 1 or not below > 0.0:
            f.append(None)
            p.append(None)
            continue
        below_dof = below**2 / float(np.sum(terms**2 / dof))
        f.append(float(mean_squares[k]) / below)
        p.append(float(f_distribution.sf(mean_squares[k] / below, dof[k], below_dof)))
    return f, p
