"""test_timing.py: 500 Hz for 2,000 cycles in guest time: no missed cycle; latency is reported, never judged."""

import pytest

from harness.timing import TimingLane

CYCLES = 2000


@pytest.mark.timing
def test_no_cycle_is_missed_at_500_hz(timing_lane: TimingLane) -> None:
    counters = timing_lane.account()["counters"]
    assert counters["syncs"] >= CYCLES
    assert counters["cycles_missed"] == 0
    assert counters["samples_lost"] == 0
