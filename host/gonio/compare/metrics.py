"""metrics.py: the metrics themselves, on plain arrays: a is the reference, b is compared with it, w are weights.

Sources: global and local accordance, paper [1] eq. 3 and 4; delta of integrals, eq. 5; RMSE and CV, paper [4] eq. 3,
whose bars are integrals (the printed CV of 40 and 45 degrees follows from that reading alone); CV(RMSD) and shares
within 5, 10, 20 %, paper [0] table 4. All arrays have shape (n,); functions return None where a value is undefined.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def global_accordance_percent(a: FloatArray, b: FloatArray, w: FloatArray | None = None) -> float | None:
    """100 (1 - sqrt(sum w (a - b)^2 / sum w (a + b)^2)); 0/0 is 100 %, any other division by zero undefined."""
    return accordance_from_sums(_sum((a - b) ** 2, w), _sum((a + b) ** 2, w), len(a))


def accordance_from_sums(differences: float, sums: float, points: int) -> float | None:
    """Global accordance in percent from sum w (a - b)^2 and sum w (a + b)^2 over so many points."""
    if points == 0:
        return None
    if sums == 0.0:
        return 100.0 if differences == 0.0 else None
    return 100.0 * (1.0 - float(np.sqrt(differences / sums)))


def accordance_gradients(
    a: FloatArray, b: FloatArray, w: FloatArray | None = None
) -> tuple[FloatArray, FloatArray] | None:
    """Change of the global accordance in percent with each a and with each b; None where a = b or it is undefined.

    f = 100 (1 - r), r^2 = N / D: dr = r/2 (dN/N - dD/D).
    """
    weight = np.ones(len(a)) if w is None else w
    difference, total = a - b, a + b
    n, d = float(weight @ difference**2), float(weight @ total**2)
    if n == 0.0 or d == 0.0:
        return None
    ratio = float(np.sqrt(n / d))
    by_difference, by_total = ratio * weight * difference / n, ratio * weight * total / d
    return -100.0 * (by_difference - by_total), -100.0 * (-by_difference - by_total)


def local_accordance_percent(a: FloatArray, b: FloatArray, unexplained: FloatArray | None = None) -> FloatArray:
    """100 (1 - |a - b| / (a + b)) per point; 0/0 is 100 %; NaN where a + b <= 0 otherwise. Noise below zero can make
    it negative. `unexplained` stands for |a - b| where only a part of that counts."""
    total = a + b
    apart = np.abs(a - b) if unexplained is None else unexplained
    with np.errstate(divide="ignore", invalid="ignore"):
        local = np.where(total > 0.0, 100.0 * (1.0 - apart / total), np.nan)
    return np.where((a == 0.0) & (b == 0.0), 100.0, local)


def delta_percent(a: float, b: float) -> float | None:
    """100 |1 - b / a| of two integrals, a the reference."""
    return None if a == 0.0 else 100.0 * abs(1.0 - b / a)


def mean(values: FloatArray, w: FloatArray | None = None) -> float | None:
    """Mean, or weighted mean; None without points or weight."""
    total = float(len(values)) if w is None else float(w.sum())
    return _sum(values, w) / total if total > 0.0 else None


def rms(values: FloatArray, w: FloatArray | None = None) -> float | None:
    """Root of the mean square, or of the weighted mean square."""
    square = mean(values**2, w)
    return None if square is None else float(np.sqrt(square))


def cv(rmse: float | None, integral_a: float, integral_b: float) -> float | None:
    """Coefficient of variation of paper [4] eq. 3: 2 RMSE / (|integral of b| + |integral of a|)."""
    bars = abs(integral_a) + abs(integral_b)
    return None if rmse is None or bars == 0.0 else 2.0 * rmse / bars


def cv_rmsd(rmsd: float | None, mean_a: float | None) -> float | None:
    """RMSD / mean of the reference; undefined where that is not over 0."""
    return None if rmsd is None or mean_a is None or mean_a <= 0.0 else rmsd / mean_a


def share_percent(inside: BoolArray, w: FloatArray | None = None) -> float | None:
    """Share of points that are `inside`, by number or by weight."""
    share = mean(inside.astype(np.float64), w)
    return None if share is None else 100.0 * share


def within(a: FloatArray, b: FloatArray, percent: float) -> BoolArray:
    """Which points differ from the reference by no more than so many percent of it."""
    return np.asarray(np.abs(b - a) <= 0.01 * percent * np.abs(a))


def chi_square(difference: FloatArray, variance: FloatArray, effects: FloatArray) -> float:
    """r . C^-1 . r with C = diag(variance) + effects^T . effects, effects (m, n): each row has one cause.

    By the matrix inversion lemma (M. A. Woodbury, Inverting Modified Matrices, 1950), in O(n m^2). Variances must be
    over 0.
    """
    own = difference / variance
    plain = float(difference @ own)
    if len(effects) == 0:
        return plain
    inner = np.eye(len(effects)) + (effects / variance) @ effects.T
    along = effects @ own
    return plain - float(along @ np.linalg.solve(inner, along))


def _sum(values: FloatArray, w: FloatArray | None) -> float:
    return float(values.sum() if w is None else w @ values)
