"""steps.py: sequences that many scenarios share."""

from collections.abc import Callable

from guest.bench import Bench
from guest.gonio_command import Ended

BRIEF_PLAN = "brief.toml"  # for faults that a scan survives
FAULT_PLAN = "fault.toml"  # a spiral of some seconds: time enough for something to happen


def fault_in_scan(
    bench: Bench, happens: Callable[[], None], device: str | None = None, plan: str = FAULT_PLAN
) -> Ended:
    """Scan, let it happen while the arm measures, wait for the scan's end and for the safe state."""
    scan = bench.scan(plan, device=device)
    bench.until_measuring(scan)
    happens()
    ended = bench.end(scan)
    bench.until_safe()
    return ended


def home_again(bench: Bench, device: str | None = None) -> Ended:
    """Recovery: what was wrong is mended, and the next command finds the positions again."""
    ended = bench.gonio("recovery", "home", device=device)
    bench.state("recovered")
    return ended
