"""interfaces.py: the kernel interfaces of the virtual machine: CAN pairs, one chip of simulated GPIO lines."""

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

from guest.processes import RigError

CONFIGFS = Path("/sys/kernel/config")
DEBUGFS = Path("/sys/kernel/debug")
GPIO_LINES = 8
BIT_RATE = 1_000_000
RESTART_MS = 100
SOFTIRQ_PRIORITY = 50  # SCHED_FIFO: above the twin, below goniod
TRANSMIT_QUEUE = 32  # frames; the kernel's default of 10 is one cycle


@dataclass(frozen=True)
class CanPair:
    """Firmware and twin on one bus; a watcher may listen on the twin's side."""

    firmware: str
    twin: str


CAN_PAIRS = {
    "vcan": CanPair("vcan0", "vcan0"),
    "card": CanPair("can0", "can1"),
    "sim": CanPair("cansim0", "cansim1"),
}


def run(*command: str) -> str:
    """A tool of the system. Raises RigError with its words."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RigError(f"{' '.join(command)}: {(done.stderr or done.stdout).strip()}")
    return done.stdout


def raise_softirqs() -> None:
    """Frames and echoes pass through ksoftirqd on a busy machine: as on a real-time board it goes before the rest."""
    for process in Path("/proc").glob("[0-9]*/comm"):
        if process.read_text().startswith("ksoftirqd"):
            os.sched_setscheduler(int(process.parent.name), os.SCHED_FIFO, os.sched_param(SOFTIRQ_PRIORITY))


def set_up_can() -> None:
    """Every pair, up."""
    run("ip", "link", "add", "vcan0", "type", "vcan")
    run("ip", "link", "set", "vcan0", "up")
    for name in ("card", "sim"):
        for interface in (CAN_PAIRS[name].firmware, CAN_PAIRS[name].twin):
            can_up(interface)


def can_up(interface: str) -> None:
    """Bit rate, restart after bus-off, queue, up."""
    timing = ("type", "can", "bitrate", str(BIT_RATE), "restart-ms", str(RESTART_MS))
    run("ip", "link", "set", interface, "txqueuelen", str(TRANSMIT_QUEUE), *timing)
    run("ip", "link", "set", interface, "up")


def can_down(interface: str) -> None:
    """As an administrator or a pulled adapter does."""
    run("ip", "link", "set", interface, "down")


def can_details(interface: str) -> str:
    """What the kernel says of an interface: state, error counters, statistics."""
    return run("ip", "-details", "-statistics", "link", "show", interface)


def can_error_state(interface: str, state: str) -> None:
    """Bring a controller of the simulated pair into an error state (kernel/gonio_can_sim.c)."""
    (DEBUGFS / interface / "state").write_text(state)


@dataclass(frozen=True)
class GpioChip:
    """`device` for the firmware, `folder` for the twin (it holds sim_gpioN)."""

    device: str
    folder: Path


def set_up_gpio() -> GpioChip:
    """One gpio-sim chip with a line for each signal."""
    chip = CONFIGFS / "gpio-sim" / "instrument"
    bank = chip / "bank0"
    bank.mkdir(parents=True)
    (bank / "num_lines").write_text(str(GPIO_LINES))
    (bank / "label").write_text("gonio-instrument")
    (chip / "live").write_text("1")
    name = (bank / "chip_name").read_text().strip()
    device = (chip / "dev_name").read_text().strip()
    return GpioChip(f"/dev/{name}", Path("/sys/devices/platform") / device / name)
