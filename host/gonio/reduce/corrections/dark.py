"""dark.py: the offset with the shutter closed, over time and temperature: measured, and subtracted."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NAME = "dark"
WHAT = "offset subtracted: means with the shutter closed, linear in time, and over temperature where the darks tell"
_DARK_CHUNK_NS = 1_000_000_000
_DARK_LEAST = 50  # samples
_TEMPERATURE_SPREAD_C = 0.2  # darks must differ by this much before a slope over temperature means anything


@dataclass(frozen=True)
class Dark:
    """Dark offsets of a segment: means over stretches of at most a second with the shutter closed; arrays (k,)."""

    time_ns: NDArray[np.int64]
    temperature_c: FloatArray
    counts: FloatArray  # (k, 2): high, low
    variance_counts2: FloatArray  # (2,): of one sample, pooled within the stretches
    per_c: FloatArray  # (2,): counts per degree of the head's temperature; 0 where the darks do not tell
    u_counts: FloatArray  # (k, 2): standard uncertainty of the means

    @classmethod
    def measure(cls, time_ns: NDArray[np.int64], samples: NDArray[np.void], closed: NDArray[np.bool_]) -> "Dark | None":
        """From the samples (n,) of one segment, in order; None when the shutter was never closed for long enough."""
        index = np.flatnonzero(closed)
        if len(index) < _DARK_LEAST:
            return None
        gap = np.diff(time_ns[index], prepend=time_ns[index[0]]) > _DARK_CHUNK_NS // 10
        stretch = np.cumsum(gap)
        begin = time_ns[index[np.r_[0, np.flatnonzero(gap)]]]
        chunk = np.cumsum(np.diff((time_ns[index] - begin[stretch]) // _DARK_CHUNK_NS, prepend=0) + gap * 10**6 != 0)
        size = np.bincount(chunk)
        keep = size >= _DARK_LEAST
        if not keep.any():
            return None
        values = np.stack((samples["high_counts"][index], samples["low_counts"][index])).astype(np.float64)
        mean = np.stack([np.bincount(chunk, v) / size for v in values], axis=1)
        residual2 = np.stack(
            [np.bincount(chunk, (v - m[chunk]) ** 2) for v, m in zip(values, mean.T, strict=True)], axis=1
        )
        centre_ns = begin[0] + np.rint(np.bincount(chunk, time_ns[index] - begin[0]) / size).astype(np.int64)
        temperature_c = np.bincount(chunk, samples["temperature_centi_c"][index]) / size / 100.0
        variance = residual2[keep].sum(axis=0) / (size[keep] - 1).sum()
        return cls(
            centre_ns[keep],
            temperature_c[keep],
            mean[keep],
            variance,
            _slope((centre_ns[keep] - begin[0]) * 1e-9, temperature_c[keep], mean[keep]),
            np.sqrt(variance / size[keep][:, None]),
        )

    def held_at(self, time_ns: int) -> "Dark":
        """The mean of these darks, for a segment whose clock is another."""
        one = np.array([time_ns], dtype=np.int64)
        mean = self.counts.mean(axis=0)[None]
        # Where the offset stood in the other segment is not known better than it wandered in its own.
        u = np.hypot(np.linalg.norm(self.u_counts, axis=0) / len(self.counts), self.counts.std(axis=0))[None]
        return replace(self, time_ns=one, temperature_c=self.temperature_c.mean(keepdims=True), counts=mean, u_counts=u)

    def at(self, time_ns: NDArray[np.int64], temperature_c: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Dark counts (2, n), linear in time between the darks (constant outside), shifted by temperature, and the
        standard uncertainty (2, n) of that mean: neighbouring samples share it."""
        origin = self.time_ns[0]
        t, nodes = (time_ns - origin).astype(np.float64), (self.time_ns - origin).astype(np.float64)
        place = np.interp(t, nodes, np.arange(len(nodes), dtype=np.float64))
        before = np.minimum(place.astype(np.intp), max(len(nodes) - 2, 0))
        after = np.minimum(before + 1, len(nodes) - 1)
        later = place - before
        at_reference = (self.counts - self.per_c * self.temperature_c[:, None]).T
        offset = np.empty((2, len(t)))
        u = np.empty((2, len(t)))
        for gain in range(2):
            nodes_of, u_of = at_reference[gain], self.u_counts[:, gain]
            offset[gain] = nodes_of[before] + later * (nodes_of[after] - nodes_of[before])
            offset[gain] += self.per_c[gain] * temperature_c
            u[gain] = np.hypot((1.0 - later) * u_of[before], later * u_of[after])
        return offset, u


def _slope(time_s: FloatArray, temperature_c: FloatArray, counts: FloatArray) -> FloatArray:
    """Counts per degree (2,) by least squares beside a drift that is linear in time; 0 where there are fewer than four
    darks or their temperatures lie on such a line themselves."""
    if len(time_s) < 4:
        return np.zeros(2)
    drift = np.stack((np.ones(len(time_s)), time_s), axis=1)
    off_c = temperature_c - drift @ np.linalg.lstsq(drift, temperature_c, rcond=None)[0]
    if np.ptp(off_c) < _TEMPERATURE_SPREAD_C:
        return np.zeros(2)
    return np.asarray(off_c @ counts / (off_c @ off_c))


def smooth_temperature_c(samples: NDArray[np.void], length: int = 500) -> FloatArray:
    """Head temperature (n,) through the means of `length` samples each: it moves slowly, its digits do not."""
    values = samples["temperature_centi_c"].astype(np.float64) / 100.0
    if len(values) < 2 * length:
        return np.full(len(values), values.mean() if len(values) else 0.0)
    starts = np.arange(0, len(values) - length + 1, length)
    means = np.add.reduceat(values, starts)[:-1] / length
    return np.interp(np.arange(len(values)), starts[:-1] + 0.5 * (length - 1), means)
