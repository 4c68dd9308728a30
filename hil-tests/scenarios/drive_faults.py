"""drive_faults.py: a drive that falls silent, was never there, or reports trouble."""

from guest.bench import Bench
from scenarios.registry import scenario
from scenarios.steps import fault_in_scan, home_again

AXIS = 2  # arm azimuth, node 3


@scenario()
def node_silent(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("node_silent", axis=AXIS))
    bench.twin.clear()
    home_again(bench)


@scenario()
def node_never_there(bench: Bench) -> None:
    bench.twin.fault("node_missing", axis=AXIS)
    bench.end(bench.scan("fault.toml"))
    bench.until_safe()
    bench.twin.clear()
    home_again(bench)


@scenario()
def emergency_message(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("emcy", axis=AXIS, code="0x4310"))
    bench.twin.clear()
    home_again(bench)
