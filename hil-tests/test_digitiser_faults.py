"""test_digitiser_faults.py: the digitiser's cable and its strobe."""

import pytest

from harness.checks import assert_fault_end, raw_log
from harness.results import Result


@pytest.mark.scenario("digitiser_unplugged")
def test_unplugged_digitiser_ends_the_scan_and_serves_again(result: Result) -> None:
    assert_fault_end(result, "digitiser")
    assert result.command("after").status == 0, result.command("after").stderr
    assert raw_log(result.raw("after.mcap")).problem is None


@pytest.mark.scenario("strobe_stuck")
def test_stuck_strobe_ends_the_scan(result: Result) -> None:
    assert_fault_end(result, "strobe", "line")


@pytest.mark.scenario("strobe_doubled")
def test_doubled_strobes_are_counted_and_lose_no_sample(result: Result) -> None:
    assert result.command("raw").status == 0, result.command("raw").stderr
    log = raw_log(result.raw())
    counters = [event.counters for event in log.events if event.HasField("counters")][-1]
    assert counters.strobes_rejected >= 20
    assert log.sample_number[-1] - log.sample_number[0] + 1 == len(log.sample_number)
