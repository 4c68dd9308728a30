"""light.py: choice of gain: from the counts of two channels to one signal, in counts of the low gain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.protocol.generated import records
from gonio.reduce.corrections.dark import Dark, smooth_temperature_c
from gonio.units.errors import UsageError
from gonio.units.instrument import Channel, Instrument

FloatArray = NDArray[np.float64]

NAME = "gain"
WHAT = "high gain, smoothly blended into the low one from 80 to 95 % of full scale; without: the low gain alone"
# Shares of full scale: high gain alone below the first, low gain alone above the second, a smooth blend between.
BLEND_FROM, BLEND_TO = 0.80, 0.95


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

    def level(self, signal: FloatArray, high_weight: FloatArray) -> FloatArray:
        """Signal (n,) in counts of the low gain, over full scale of the channel that counts."""
        on_high = self.high.gain / self.high.full_scale_counts
        on_low = self.low.gain / self.low.full_scale_counts
        return signal * (on_low + high_weight * (on_high - on_low))


@dataclass(frozen=True)
class Light:
    """Light of some samples, all (n,), in counts of the low gain; flags are PointFlag bits."""

    signal: FloatArray
    dark_variance: FloatArray  # of one sample, in the dark
    dark_u: FloatArray  # standard uncertainty of the offset that was subtracted, common to neighbours
    monitor_counts: FloatArray
    flags: NDArray[np.uint16]


def light_of(
    samples: NDArray[np.void],
    time_ns: NDArray[np.int64],
    high_weight: FloatArray,
    dark: Dark,
    gains: Gains,
    *,
    subtract: bool = True,
) -> Light:
    """Subtract dark (or not) and blend the gains. SATURATED: a channel that counts, or the lamp monitor, is at full
    scale."""
    low_weight = 1.0 - high_weight
    share = high_weight / gains.high.gain, low_weight / gains.low.gain
    signal = share[0] * samples["high_counts"] + share[1] * samples["low_counts"]
    dark_u = np.zeros(len(samples))
    if subtract:
        offset, u = dark.at(time_ns, smooth_temperature_c(samples))
        signal -= share[0] * offset[0] + share[1] * offset[1]
        # Both gains amplify one photocurrent, but their offsets are noise of their own.
        dark_u = np.hypot(share[0] * u[0], share[1] * u[1])
    raw = samples["flags"]
    saturated = ((low_weight > 0.0) & (raw & records.SAMPLE_LOW_SATURATED != 0)) | (
        raw & records.SAMPLE_MONITOR_SATURATED != 0
    )
    return Light(
        signal=signal,
        dark_variance=share[0] ** 2 * dark.variance_counts2[0] + share[1] ** 2 * dark.variance_counts2[1],
        dark_u=dark_u,
        monitor_counts=samples["monitor_counts"].astype(np.float64),
        flags=np.where(saturated, np.uint16(PointFlag.SATURATED), np.uint16(0)),
    )
