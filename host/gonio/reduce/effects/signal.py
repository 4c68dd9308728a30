"""signal.py: effects on the light of each point: dark, ratio of the gains, linearity, lamp."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.reduce.corrections.light import Gains
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Level:
    """Where light stood on the scales of the receiver; arrays (n,)."""

    high_share: FloatArray  # of the light that came from the high gain
    of_full_scale: FloatArray  # signal over full scale, of the channel that counts


def level_of(signal_counts: FloatArray, high_weight: FloatArray, instrument: Instrument) -> Level:
    """From the light (n,) in low-gain counts and the weight (n,) of the high channel in it."""
    return Level(high_weight, Gains.of(instrument).level(signal_counts, high_weight))


def signal_columns(
    dsf_per_sr: FloatArray, dark_u_per_sr: FloatArray, level: Level, beam_level: Level, instrument: Instrument
) -> dict[str, FloatArray]:
    """Columns (n,) [1/sr per standard deviation]; `beam_level` holds the means over P_i's light, shape (1,).

    P_i was measured by the same receiver: an error of the gains' ratio moves only the difference of both shares, and
    light = s (1 + c s / full scale) only the difference of both levels, as DSF = E / P_i.
    """
    gains = Gains.of(instrument)
    calibration = instrument.calibration
    # E = high / G_high or low / G_low: only the ratio G_high / G_low shows.
    ratio_u_rel = float(np.hypot(gains.high.gain_u_rel, gains.low.gain_u_rel))
    return {
        "dark": dark_u_per_sr,
        "gain_ratio": dsf_per_sr * (level.high_share - beam_level.high_share) * ratio_u_rel,
        "linearity": dsf_per_sr * (level.of_full_scale - beam_level.of_full_scale) * calibration.nonlinearity_u,
        "lamp": dsf_per_sr * calibration.monitor_u_rel,
    }
