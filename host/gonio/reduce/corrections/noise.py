"""noise.py: the noise of light and monitor, estimated from the scan itself."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


# However far noise takes a sample below zero, its variance is no less than this share of the dark's.
_LEAST_OF_DARK = 0.75


def light_variance(dark_variance: FloatArray, shot_per_count: float, signal: FloatArray) -> FloatArray:
    """Variance (n,) of samples of light, low-gain counts^2: the dark's and shot noise in proportion to the signal.

    A signal below zero takes as much away as one above it adds: the mean over many samples in the dark is the dark's.
    """
    return np.maximum(dark_variance + shot_per_count * signal, _LEAST_OF_DARK * dark_variance)


def smooth_variance(values: FloatArray) -> FloatArray:
    """Local estimates (n - 4,) of the variance of white noise on a smooth signal: squared fourth differences over 70.

    A fourth difference leaves less than 1e-6 of a lobe sampled forty times per sigma. One estimate alone follows chi
    square with one degree of freedom: use medians of many (median of chi square: 0.4549).
    """
    return np.diff(values, 4) ** 2 / 70.0


def shot_variance_per_count(signal: FloatArray, dark_variance: FloatArray, consecutive: NDArray[np.bool_]) -> float:
    """Variance of the light in low-gain counts per count, from the scan itself; 0 where it does not show.

    `consecutive` (n,) is False where a sample does not follow its predecessor. Local variances are binned by signal;
    the median of a bin is robust against edges of the beam; the slope follows by weighted least squares.
    """
    if len(signal) < 1000:
        return 0.0
    local = smooth_variance(signal)
    level, floor = signal[2:-2], dark_variance[2:-2]
    joined = np.convolve(~consecutive, np.ones(4), mode="valid")[1:] == 0
    order = np.flatnonzero(joined & (level > 0.0))
    order = order[np.argsort(level[order])]
    bins = [part for part in np.array_split(order, 50) if len(part) >= 30]
    if not bins:
        return 0.0
    excess = np.array([np.median(local[part]) / 0.4549 - np.mean(floor[part]) for part in bins])
    at = np.array([np.mean(level[part]) for part in bins])
    below = np.array([np.mean(floor[part]) for part in bins])
    slope = max(float(excess.sum() / at.sum()), 0.0)
    for _ in range(10):
        spread = below + slope * at  # a median's uncertainty goes with the variance itself
        if not spread.all():  # no noise at all, nothing to weigh by
            break
        slope = max(float(np.sum(at * excess / spread**2) / np.sum((at / spread) ** 2)), 0.0)
    return slope
