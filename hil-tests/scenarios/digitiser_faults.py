"""digitiser_faults.py: the digitiser's cable pulled, its strobe stuck or doubled."""

from guest.bench import Bench
from guest.gadgets import DIGITISER
from scenarios.registry import scenario
from scenarios.steps import BRIEF_PLAN, fault_in_scan, home_again


@scenario()
def digitiser_unplugged(bench: Bench) -> None:
    fault_in_scan(bench, DIGITISER.unplug)
    DIGITISER.plug()
    home_again(bench)
    bench.end(bench.scan("brief.toml", "after.mcap"))


@scenario()
def strobe_stuck(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("strobe_stuck"))
    bench.twin.clear()
    home_again(bench)


@scenario()
def strobe_doubled(bench: Bench) -> None:
    """Pulses that come twice are rejected and counted; the scan is whole."""
    fault_in_scan(bench, lambda: bench.twin.fault("strobe_doubled", count=20), plan=BRIEF_PLAN)
    bench.state("after")
    bench.twin.clear()
