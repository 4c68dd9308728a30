"""corrections.py: from counts to light: dark offset, choice of gain, lamp monitor, and the noise in it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.protocol.generated import records
from gonio.units.errors import UsageError
from gonio.units.instrument import Channel, Instrument

FloatArray = NDArray[np.float64]

# Shares of full scale: high gain alone below the first, low gain alone above the second, a smooth blend between.
BLEND_FROM, BLEND_TO = 0.80, 0.95
_DARK_CHUNK_NS = 1_000_000_000
_DARK_LEAST = 50  # samples
_TEMPERATURE_SPREAD_C = 0.2  # darks must differ by this much before a slope over temperature means anything


@dataclass(frozen=True)
class Gains:
    """The two detector channels of the instrument."""

    high: Channel
    low: Channel

    @classmethod
    def of(cls, instrument: Instrument) -> "Gains":
        """Raises UsageError where the instrument does not have channels named high and low."""
        by_name = {channel.name: channel for channel in instrument.channels}
        if not {"high", "low"} <= by_name.keys():
            raise UsageError(f"instrument {instrument.name!r}: channels 'high' and 'low' are needed in its file")
        return cls(by_name["high"], by_name["low"])

    def high_weight(self, samples: NDArray[np.void]) -> FloatArray:
        """Weight (n,) of the high channel in each sample: 1 below the blend zone, 0 above it or saturated."""
        level = np.abs(samples["high_counts"]) / self.high.full_scale_counts
        x = np.clip((level - BLEND_FROM) / (BLEND_TO - BLEND_FROM), 0.0, 1.0)
        weight = 1.0 - x * x * (3.0 - 2.0 * x)
        return np.where(samples["flags"] & records.SAMPLE_HIGH_SATURATED, 0.0, weight)

    def delay_ns(self, high_weight: FloatArray) -> FloatArray:
        """How long before its strobe time the light of each sample came (n,); a blend's light is between both."""
        return 1e3 * (high_weight * self.high.delay_us + (1.0 - high_weight) * self.low.delay_us)


@dataclass(frozen=True)
class Dark:
    """Dark offsets of a segment: means over stretches of at most a second with the shutter closed; arrays (k,)."""

    time_ns: NDArray[np.int64]
    temperature_c: FloatArray
    counts: FloatArray  # (k, 2): high, low
    variance_counts2: FloatArray  # (2,): of one sample, pooled within the stretches
    per_c: FloatArray  # (2,): counts per degree of the head's temperature; 0 where the darks do not tell

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
        )

    def held_at(self, time_ns: int) -> "Dark":
        """The mean of these darks, for a segment whose clock is another."""
        one = np.array([time_ns], dtype=np.int64)
        mean = self.counts.mean(axis=0)[None]
        return replace(self, time_ns=one, temperature_c=self.temperature_c.mean(keepdims=True), counts=mean)

    def at(self, time_ns: NDArray[np.int64], temperature_c: FloatArray) -> FloatArray:
        """Dark counts (n, 2), linear in time between the darks (constant outside), shifted by temperature."""
        origin = self.time_ns[0]
        t, nodes = (time_ns - origin).astype(np.float64), (self.time_ns - origin).astype(np.float64)
        at_reference = self.counts - self.per_c * self.temperature_c[:, None]
        between = np.stack([np.interp(t, nodes, column) for column in at_reference.T], axis=1)
        return between + self.per_c * temperature_c[:, None]


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


@dataclass(frozen=True)
class Light:
    """Dark-subtracted light of some samples, all (n,): in counts of the low gain; flags are PointFlag bits."""

    signal: FloatArray
    dark_variance: FloatArray
    monitor_counts: FloatArray
    flags: NDArray[np.uint16]


def light_of(
    samples: NDArray[np.void], time_ns: NDArray[np.int64], high_weight: FloatArray, dark: Dark, gains: Gains
) -> Light:
    """Subtract dark and blend the gains. SATURATED: a channel that counts, or the lamp monitor, is at full scale."""
    offset = dark.at(time_ns, smooth_temperature_c(samples))
    high = (samples["high_counts"] - offset[:, 0]) / gains.high.gain
    low = (samples["low_counts"] - offset[:, 1]) / gains.low.gain
    low_weight = 1.0 - high_weight
    raw = samples["flags"]
    saturated = ((low_weight > 0.0) & (raw & records.SAMPLE_LOW_SATURATED != 0)) | (
        raw & records.SAMPLE_MONITOR_SATURATED != 0
    )
    variance = dark.variance_counts2 / np.array([gains.high.gain, gains.low.gain]) ** 2
    return Light(
        signal=high_weight * high + low_weight * low,
        dark_variance=high_weight**2 * variance[0] + low_weight**2 * variance[1],
        monitor_counts=samples["monitor_counts"].astype(np.float64),
        flags=np.where(saturated, np.uint16(PointFlag.SATURATED), np.uint16(0)),
    )


def smooth_temperature_c(samples: NDArray[np.void], length: int = 500) -> FloatArray:
    """Head temperature (n,) through the means of `length` samples each: it moves slowly, its digits do not."""
    values = samples["temperature_centi_c"].astype(np.float64) / 100.0
    if len(values) < 2 * length:
        return np.full(len(values), values.mean() if len(values) else 0.0)
    starts = np.arange(0, len(values) - length + 1, length)
    means = np.add.reduceat(values, starts)[:-1] / length
    return np.interp(np.arange(len(values)), starts[:-1] + 0.5 * (length - 1), means)


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
