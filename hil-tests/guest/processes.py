"""processes.py: programs that run beside the steps of a scenario: started, listened to, ended, their words kept."""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

POLL_S = 0.02
READY_LIMIT_S = 60.0  # a program loads from the 9p share, which an emulated processor reads slowly
END_LIMIT_S = 20.0  # goniod brings the arm to rest first


class RigError(Exception):
    """The rig did not do its part: the scenario says nothing about the firmware."""


class NeverCameError(Exception):
    """A condition did not come true: the scenario failed."""


def wait_until(what: str, condition: Callable[[], bool], limit_s: float) -> float:
    """Seconds until the condition was true. Raises NeverCameError."""
    began = time.monotonic()
    while not condition():
        if time.monotonic() - began > limit_s:
            raise NeverCameError(f"after {limit_s:.0f} s still not: {what}")
        time.sleep(POLL_S)
    return time.monotonic() - began


class Program:
    """A program with its standard output and error in files of the results folder."""

    def __init__(self, name: str, command: Sequence[str], folder: Path, priority: int = 0) -> None:
        self.name = name
        self.output = _fresh(folder, name, "out")
        self.errors = _fresh(folder, name, "err")
        with self.output.open("wb") as output, self.errors.open("wb") as errors:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=errors)
        if priority:
            os.sched_setscheduler(self.pid, os.SCHED_FIFO, os.sched_param(priority))

    @property
    def pid(self) -> int:
        return self.process.pid

    def alive(self) -> bool:
        """Whether it still runs."""
        return self.process.poll() is None

    def wait_for_line(self, beginning: str) -> str:
        """The first line of standard output that begins so. Raises RigError when the program ends or never says it."""
        began = time.monotonic()
        while time.monotonic() - began < READY_LIMIT_S:
            for line in self.output.read_text(errors="replace").splitlines(keepends=True):
                if line.startswith(beginning) and line.endswith("\n"):
                    return line.strip()
            if not self.alive():
                raise RigError(f"{self.name} ended with {self.process.returncode}: {self.errors.read_text()[-400:]}")
            time.sleep(POLL_S)
        raise RigError(f"{self.name} did not say {beginning!r} within {READY_LIMIT_S:.0f} s")

    def kill(self, number: signal.Signals = signal.SIGKILL) -> int:
        """Send a signal and wait for the end; the exit status."""
        if self.alive():
            self.process.send_signal(number)
        try:
            return self.process.wait(END_LIMIT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise NeverCameError(f"{self.name} did not end within {END_LIMIT_S:.0f} s of {number.name}") from None

    def account(self) -> dict[str, float | str]:
        """What it uses: resident memory now, processor time since its start."""
        process = Path(f"/proc/{self.pid}")
        resident = [line for line in (process / "status").read_text().splitlines() if line.startswith("VmRSS:")]
        times = (process / "stat").read_text().rpartition(")")[2].split()
        ticks = os.sysconf("SC_CLK_TCK")
        return {
            "name": self.name,
            "resident_kib": int(resident[0].split()[1]) if resident else 0,
            "user_s": int(times[11]) / ticks,
            "system_s": int(times[12]) / ticks,
        }


def _fresh(folder: Path, name: str, kind: str) -> Path:
    number = 1
    while (path := folder / f"{name}.{number}.{kind}").exists():
        number += 1
    return path
