"""test_independent_variance.py: the variance stated of one sample is the scatter of many, in both gains and between."""

import numpy as np
import pytest

from gonio.protocol.generated.records import SAMPLE_DTYPE
from gonio.reduce.corrections.dark import Dark
from gonio.reduce.corrections.light import Gains, light_of
from gonio.reduce.corrections.noise import light_variance
from gonio.units.instrument import load_instrument

NOISE_COUNTS = (9.0, 3.0)
DARK_COUNTS = (350.0, 12.0)
SHOT_PER_COUNT = 2e-3
COUNT = 60_000
FULL_SCALE_OF_HIGH = 8388.607  # low-gain counts


def samples_of(light: float, rng: np.random.Generator, gains: Gains) -> np.ndarray:
    """Samples (COUNT,) of a steady light in low-gain counts; both gains amplify one photocurrent."""
    fallen = light + np.sqrt(SHOT_PER_COUNT * light) * rng.standard_normal(COUNT)
    samples = np.zeros(COUNT, dtype=SAMPLE_DTYPE)
    for index, channel in enumerate((gains.high, gains.low)):
        value = channel.gain * fallen + DARK_COUNTS[index] + NOISE_COUNTS[index] * rng.standard_normal(COUNT)
        samples[f"{channel.name}_counts"] = np.rint(np.minimum(value, channel.full_scale_counts))
    return samples


@pytest.mark.parametrize("level", [0.0, 0.01, 0.5, 0.84, 0.875, 0.92, 1.5, 300.0])
def test_scatter_of_samples(level: float) -> None:
    """`level`: light over full scale of the high gain; it is blended into the low one from 0.80 to 0.95."""
    gains = Gains.of(load_instrument(None))
    rng = np.random.default_rng(int(1000 * level) + 1)
    time_ns = np.arange(COUNT, dtype=np.int64) * 1_000_000
    dark = Dark.measure(time_ns, samples_of(0.0, rng, gains), np.ones(COUNT, dtype=bool))
    assert dark is not None
    light = level * FULL_SCALE_OF_HIGH
    samples = samples_of(light, rng, gains)
    weight = gains.high_weight(samples)
    found = light_of(samples, time_ns, weight, dark, gains)
    stated = light_variance(found.dark_variance, SHOT_PER_COUNT, found.signal)
    assert found.signal.var() == pytest.approx(float(stated.mean()), rel=0.03)
    # Their mean is off by the error of the dark, which its u states, and by their own scatter.
    assert abs(found.signal.mean() - light) < 4.0 * np.hypot(found.dark_u.mean(), np.sqrt(stated.mean() / COUNT))


def test_a_sample_far_below_zero_has_a_variance_still() -> None:
    variance = light_variance(np.full(3, 4.0), 1.0, np.array([-1e6, -0.5, 3.0]))
    assert variance == pytest.approx([3.0, 3.5, 7.0])
