"""host_faults.py: the host dies, its disk is full, its clock steps, its cable is pulled."""

import signal
import time
from pathlib import Path

from guest.bench import Bench
from guest.gadgets import LINK
from guest.interfaces import run
from scenarios.registry import scenario
from scenarios.steps import BRIEF_PLAN, fault_in_scan, home_again

STEP_S = 3600
SMALL_DISK = Path("/run/small-disk")


@scenario()
def host_killed(bench: Bench) -> None:
    scan = bench.scan("fault.toml")
    bench.until_measuring(scan)
    scan.send(signal.SIGKILL)
    bench.end(scan)
    bench.until_safe()
    home_again(bench)


@scenario()
def link_unplugged(bench: Bench) -> None:
    fault_in_scan(bench, LINK.unplug, device=bench.usb)
    LINK.plug()
    home_again(bench, device=bench.usb)


@scenario()
def disk_full(bench: Bench) -> None:
    SMALL_DISK.mkdir(exist_ok=True)
    run("mount", "-t", "tmpfs", "-o", "size=96k", "small", str(SMALL_DISK))
    try:
        scan = bench.start("raw", "scan", bench.plan("fault.toml"), "-o", SMALL_DISK / "raw.mcap")
        bench.end(scan)
        bench.until_safe()
        bench.keep(SMALL_DISK / "raw.mcap")
    finally:
        run("umount", str(SMALL_DISK))
    home_again(bench)


@scenario()
def clock_stepped(bench: Bench) -> None:
    """Host and controller share the virtual machine's wall clock: both see it go an hour forward, and back."""

    def step(seconds: int) -> None:
        time.clock_settime(time.CLOCK_REALTIME, time.clock_gettime(time.CLOCK_REALTIME) + seconds)

    try:
        fault_in_scan(bench, lambda: step(STEP_S), plan=BRIEF_PLAN)
    finally:
        step(-STEP_S)
