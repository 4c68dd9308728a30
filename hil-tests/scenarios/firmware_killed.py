"""firmware_killed.py: goniod killed or frozen in mid-scan: drives and shutter board bring everything to rest alone."""

import signal
import time

from guest.bench import Bench
from guest.gadgets import LINK
from guest.gonio_command import GonioCommand
from scenarios.registry import scenario
from scenarios.steps import FAULT_PLAN, home_again

STATE_BITS, OPERATION_ENABLED = 0x6F, 0x27  # of the statusword


def _rest(bench: Bench) -> None:
    """What the instrument does by itself."""
    bench.until("at rest", lambda state: state["at_rest"])
    bench.until_safe()
    bench.until(
        "out of operation",
        lambda state: all(word & STATE_BITS != OPERATION_ENABLED for word in state["statusword"]),
    )


def _kill(bench: Bench) -> None:
    bench.values["killed_at_s"] = time.time()  # candump's clock
    bench.values["status"] = bench.station.goniod.kill()


def _begin_anew(bench: Bench, scan: GonioCommand) -> None:
    """The next start of the firmware takes no position over."""
    bench.end(scan)
    bench.values["unplugged"] = LINK.bound_to() == ""
    bench.values["restarted_at_s"] = time.time()
    bench.station.start_goniod()
    bench.gonio("info", "info", "--json")
    home_again(bench)


@scenario(spoils=True)
def firmware_killed(bench: Bench) -> None:
    """The drives' RPDO deadline acts first."""
    scan = bench.scan(FAULT_PLAN)
    bench.until_measuring(scan)
    _kill(bench)
    _rest(bench)
    _begin_anew(bench, scan)


@scenario(twin="twin-unguarded.toml", spoils=True)
def firmware_killed_without_deadline(bench: Bench) -> None:
    """The axes stop dead at their last set-point and stay in operation until their heartbeat consumers act.

    With the other instrument file, which wants more speed than such drives are given, nothing moves.
    """
    bench.end(bench.scan("slow.toml", "refused.mcap", instrument=bench.rig_folder / "vm-axes.toml"))
    bench.station.goniod.kill(signal.SIGTERM)  # configured once, it takes another file only after its drives' release
    bench.station.start_goniod()
    scan = bench.scan("slow.toml")
    bench.until_measuring(scan, degrees=1.0, least_deg_per_s=1.0)
    _kill(bench)
    _rest(bench)
    _begin_anew(bench, scan)


@scenario(spoils=True)
def firmware_frozen(bench: Bench) -> None:
    """It lives and does nothing: its outputs stay as they were; the shutter's board misses the watchdog's pulses."""
    scan = bench.scan(FAULT_PLAN)
    bench.values["watchdog_trips"] = bench.until_measuring(scan)["watchdog_trips"]
    bench.station.goniod.process.send_signal(signal.SIGSTOP)
    _rest(bench)
    _kill(bench)
    _begin_anew(bench, scan)
