"""monotone_cubic.py: a cubic between knots that does not overshoot: where the values rise, it rises."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def monotone_cubic(knots: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Values (m, ...) at places (m,) within rising knots (k,), k >= 2, from values (k, ...).

    Hermite's cubic with slopes at inner knots by Fritsch and Butland (1984), a harmonic mean of those of the intervals
    beside, weighted by their lengths, and 0 at a local extreme; at both ends of three points' parabola, kept to the
    sign and three times the size of the interval's own.
    """
    lengths = np.diff(knots)
    shape = (-1,) + (1,) * (values.ndim - 1)
    steps = np.diff(values, axis=0) / lengths.reshape(shape)
    slopes = np.empty_like(values)
    if len(knots) == 2:
        slopes[:] = steps[0]
    else:
        left, right = lengths[:-1].reshape(shape), lengths[1:].reshape(shape)
        product = steps[:-1] * steps[1:]
        blend = (2.0 * right + left) * steps[1:] + (right + 2.0 * left) * steps[:-1]
        slopes[1:-1] = np.where(product > 0.0, 3.0 * (left + right) * product / np.where(blend == 0.0, 1.0, blend), 0.0)
        slopes[0] = _end(lengths[0], lengths[1], steps[0], steps[1])
        slopes[-1] = _end(lengths[-1], lengths[-2], steps[-1], steps[-2])
    k = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    length = lengths[k].reshape(shape)
    t = (at - knots[k]).reshape(shape) / length
    return np.asarray(
        values[k] * (1.0 + 2.0 * t) * (1.0 - t) ** 2
        + values[k + 1] * t**2 * (3.0 - 2.0 * t)
        + length * (slopes[k] * t * (1.0 - t) ** 2 - slopes[k + 1] * t**2 * (1.0 - t))
    )


def _end(own: float, beside: float, step: FloatArray, next_step: FloatArray) -> FloatArray:
    """Slope at an end: lengths and slopes of the interval there and of the next."""
    slope = ((2.0 * own + beside) * step - own * next_step) / (own + beside)
    slope = np.where(slope * step > 0.0, slope, 0.0)
    far = (step * next_step < 0.0) & (np.abs(slope) > 3.0 * np.abs(step))
    return np.asarray(np.where(far, 3.0 * step, slope))
