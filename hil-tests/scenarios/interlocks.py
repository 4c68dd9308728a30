"""interlocks.py: door, emergency stop, STO and limit switch in mid-scan: safe at once, home again afterwards."""

from guest.bench import Bench
from scenarios.registry import scenario
from scenarios.steps import fault_in_scan, home_again


@scenario()
def door_opened(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("door_open"))
    bench.twin.clear()
    home_again(bench)


@scenario()
def emergency_stop(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("emergency_stop"))
    bench.twin.clear()
    home_again(bench)


@scenario()
def limit_switch(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("limit"))
    bench.twin.clear()
    home_again(bench)


@scenario()
def sto_opened_and_closed(bench: Bench) -> None:
    fault_in_scan(bench, lambda: bench.twin.fault("sto_open"))
    bench.gonio("home-while-open", "home")
    bench.twin.clear()
    home_again(bench)
