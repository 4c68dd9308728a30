"""test_soak.py: half an hour of scans in one boot: none fails, no sample is lost, no memory leaks. `make soak` only."""

import pytest

from harness.checks import assert_nothing_lost, assert_sample_clock, raw_log
from harness.results import Result
from harness.rig import Rig

SETTLED = 10  # scans after which every buffer has been used
GROWTH_KIB = 256  # over all later scans: what an allocator may do without a leak; 3 KiB per scan would be more


def names(rig: Rig) -> list[str]:
    return [f"scan-{number:03d}" for number in range(1, rig.settings["soak_scans"] + 1)]


@pytest.mark.scenario("soak")
def test_every_scan_succeeds(result: Result, rig: Rig) -> None:
    for name in names(rig):
        assert result.command(name).status == 0, result.command(name).stderr


@pytest.mark.scenario("soak")
def test_no_scan_loses_a_sample(result: Result, rig: Rig) -> None:
    for name in names(rig):
        assert_nothing_lost(result.raw(f"{name}.mcap"))
        assert_sample_clock(raw_log(result.raw(f"{name}.mcap")))


@pytest.mark.scenario("soak")
@pytest.mark.parametrize("program", ["goniod", "twin"])
def test_memory_is_flat(result: Result, rig: Rig, program: str) -> None:
    resident_kib = result.values["resident_kib"][program]
    assert len(resident_kib) == rig.settings["soak_scans"]
    later = resident_kib[min(SETTLED, len(resident_kib)) - 1 :]
    assert max(later) - later[0] <= GROWTH_KIB, resident_kib
