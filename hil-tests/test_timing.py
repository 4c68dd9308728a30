"""test_timing.py: 500 Hz for 2,000 cycles in guest time: no missed cycle; latency is reported, never judged."""

from pathlib import Path

import pytest

from harness.rig import Rig
from harness.session import ROOT
from harness.timing import run_timing_lane

CYCLES = 2000


def test_no_cycle_is_missed_at_500_hz(rig: Rig, pytestconfig: pytest.Config) -> None:
    if rig.kind != "vm":
        pytest.skip(f"not run: {rig.path.name} has no instruction clock")
    build = Path(pytestconfig.getoption("--build")).resolve()
    counters = run_timing_lane(rig, build, ROOT / "build" / "hil" / rig.path.stem / "timing")["counters"]
    assert counters["syncs"] >= CYCLES
    assert counters["cycles_missed"] == 0
    assert counters["samples_lost"] == 0
