"""firmware_killed.py: goniod SIGKILLed in mid-scan: drives and shutter board bring everything to rest by themselves."""

from guest.bench import Bench
from guest.gadgets import LINK
from scenarios.registry import scenario
from scenarios.steps import home_again


def _kill_in_scan(bench: Bench) -> None:
    scan = bench.scan("fault.toml")
    bench.values["speed_before"] = bench.until_measuring(scan)["speed_deg_per_s"]
    bench.values["status"] = bench.station.goniod.kill()
    bench.until("at rest", lambda state: state["at_rest"])
    bench.until_safe()
    bench.end(scan)
    bench.values["unplugged"] = LINK.bound_to() == ""
    bench.station.start_goniod()
    bench.gonio("info", "info", "--json")
    home_again(bench)


@scenario(spoils=True)
def firmware_killed(bench: Bench) -> None:
    """The drives' RPDO deadline acts first."""
    _kill_in_scan(bench)


@scenario(twin="twin-basic.toml", spoils=True)
def firmware_killed_basic_drives(bench: Bench) -> None:
    """Without the deadline the heartbeat consumer or nothing stops the axis: its position is unknown."""
    _kill_in_scan(bench)
