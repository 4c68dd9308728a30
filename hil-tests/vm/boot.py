"""boot.py: one boot of the virtual machine: QEMU in one of two lanes, its serial log, and a limit on its life."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vm.initrd import initrd

Lane = Literal["system", "timing"]
LAST_LINES = 30
_NICE = -15
_QEMU = "qemu-system-x86_64"
# Two processors on the wall clock; or one, whose time is counted in instructions (4 ns each), and never waits for ours.
_LANES: dict[Lane, tuple[str, ...]] = {
    "system": ("-accel", "tcg,thread=multi", "-smp", "2"),
    "timing": ("-accel", "tcg,thread=single", "-smp", "1", "-icount", "shift=2,sleep=off"),
}
_MEMORY_MIB = {"system": 2048, "timing": 1024}


class BootError(Exception):
    """The virtual machine did not do its part: a broken rig, not a failed test."""


@dataclass(frozen=True)
class Machine:
    """What is booted. `results` is the only folder of this machine that the guest may write."""

    kernel: Path
    lane: Lane
    results: Path
    limit_s: float
    preload: tuple[Path, ...] = ()  # timing lane: all that start.sh needs
    start: str | None = None  # timing lane: start.sh itself

    def command(self, initial_root: Path) -> list[str]:
        """QEMU's command line. Two CAN cards on one bus, two USB device controllers in the kernel, no network."""
        shares = [f"local,path={self.results},mount_tag=results,security_model=none"]
        if self.lane == "system":
            shares.insert(0, "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap")
        append = f"console=ttyS0 quiet panic=-1 dummy_hcd.num=2 tsc=reliable lane={self.lane}"
        command = [_QEMU, *_LANES[self.lane], "-cpu", "max", "-m", str(_MEMORY_MIB[self.lane])]
        command += ["-nographic", "-no-reboot", "-nodefaults", "-serial", "stdio", "-net", "none"]
        command += ["-kernel", str(self.kernel), "-initrd", str(initial_root), "-append", append]
        command += [word for share in shares for word in ("-virtfs", share)]
        command += ["-object", "can-bus,id=bus"]
        return command + [word for _ in range(2) for word in ("-device", "kvaser_pci,canbus=bus")]


def boot(machine: Machine) -> Path:
    """Run the machine to its end; the serial log's path. Raises BootError when it cannot start or hangs."""
    if shutil.which(_QEMU) is None:
        raise BootError(f"no {_QEMU}: apt install qemu-system-x86")
    machine.results.mkdir(parents=True, exist_ok=True)
    initial_root = machine.results / "initrd.gz"
    initial_root.write_bytes(initrd(machine.preload, machine.start))
    serial = machine.results / "serial.log"
    with serial.open("wb") as log:
        process = subprocess.Popen(
            machine.command(initial_root),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            start_new_session=True,  # its own scheduling group
        )
        go_first(process.pid)
        try:
            status = process.wait(machine.limit_s)
        except subprocess.TimeoutExpired:
            raise BootError(
                f"the virtual machine was ended after {machine.limit_s:.0f} s; it said last:\n{last_lines([serial])}"
            ) from None
        finally:
            if process.poll() is None:  # also when the tests are interrupted
                process.kill()
                process.wait()
            initial_root.unlink()
    if status:
        raise BootError(f"QEMU ended with {status}:\n{last_lines([serial])}")
    return serial


def go_first(pid: int) -> None:
    """Where we may say so, nothing else starves the emulation: its instrument runs on the wall clock."""
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, _NICE)
    with suppress(OSError):
        Path(f"/proc/{pid}/autogroup").write_text(str(_NICE))


def last_lines(logs: Iterable[Path]) -> str:
    """The end of each log that is there, for whoever must find out why."""
    parts = []
    for path in logs:
        if path.is_file():
            lines = path.read_text(errors="replace").splitlines()[-LAST_LINES:]
            parts += [f"--- {path.name}", *lines]
    return "\n".join(parts)
