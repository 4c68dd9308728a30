"""test_throughput.py: 100,000 samples per second, each with its own number, none lost."""

import numpy as np
import pytest

from harness.checks import assert_nothing_lost, assert_sample_clock, counters, raw_log
from harness.results import Result

LEAST_SAMPLES = 300_000
PATTERN_MODULO = 1 << 23  # of the twin's counter pattern


@pytest.mark.scenario("throughput")
def test_every_sample_of_100_khz_arrives_as_it_was_sent(result: Result) -> None:
    assert result.command("raw").status == 0, result.command("raw").stderr
    assert_nothing_lost(result.raw())
    log = raw_log(result.raw())
    assert (counters(log).samples_lost, counters(log).packets_lost) == (0, 0)
    assert len(log.sample_number) >= LEAST_SAMPLES
    assert_sample_clock(log)
    assert np.array_equal(log.samples["high_counts"], log.sample_number % PATTERN_MODULO)
    assert result.state("safe")["packets_lost"] == 0
