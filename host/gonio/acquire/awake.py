"""awake.py: keeps this machine from going to sleep while a scan runs, and notices when it slept all the same.

The instrument stops by itself while we sleep, and USB devices come back as new ones: a resume counts as an unplugged
cable.
"""

# ruff: noqa: PLC0415 - what only one system has

import os
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from gonio.units.errors import InstrumentFault

ANSWER_TIMEOUT_S = 5.0  # the login manager grants a lock within milliseconds; without one it is refused as fast
SLEPT_NS = 100_000_000  # less is no sleep: a machine takes longer to go down and up
_ES_CONTINUOUS, _ES_SYSTEM_REQUIRED = 0x80000000, 0x00000001
_HELD = b"held\n"


@contextmanager
def kept_awake(say: Callable[[str], None]) -> Iterator[None]:
    """Hold off sleep; where that is not possible `say` so once, and go on."""
    if sys.platform == "win32":
        import ctypes

        held = bool(ctypes.windll.kernel32.SetThreadExecutionState(_ES_CONTINUOUS | _ES_SYSTEM_REQUIRED))
        child = None
    else:
        child = _inhibitor()
        held = child is not None
    if not held:
        say("nothing here holds off sleep: see to it that this machine does not go to sleep during the scan")
    try:
        yield
    finally:
        if child is not None:
            _end(child)
        if sys.platform == "win32":
            ctypes.windll.kernel32.SetThreadExecutionState(_ES_CONTINUOUS)


def _inhibitor() -> subprocess.Popen[bytes] | None:
    """A process that holds off sleep until its standard input ends: with us, however we end. None: not possible."""
    hold = ["sh", "-c", "echo held; exec cat >/dev/null"]
    if caffeinate := shutil.which("caffeinate"):
        command = [caffeinate, "-i", "-s", *hold]
    elif inhibit := shutil.which("systemd-inhibit"):
        command = [inhibit, "--what=sleep:idle", "--who=gonio", "--why=a scan is running", *hold]
    else:
        return None
    child = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for us; the lock stays until the instrument has stopped
    )
    assert child.stdout
    if select.select([child.stdout], [], [], ANSWER_TIMEOUT_S)[0] and os.read(child.stdout.fileno(), 64) == _HELD:
        return child
    _end(child)
    return None


def _end(child: subprocess.Popen[bytes]) -> None:
    assert child.stdin
    assert child.stdout
    with suppress(OSError):
        child.stdin.close()
    child.stdout.close()
    try:
        child.wait(ANSWER_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


class SleepWatch:
    """Compares the clock that counts sleep with the one that does not; Linux has both. Elsewhere the silence after a
    sleep must do: the firmware has stopped the path by then."""

    def __init__(self) -> None:
        self._ahead_ns = self._least_and_most_ns()[1]

    @staticmethod
    def _least_and_most_ns() -> tuple[int, int]:
        """How far the one is ahead of the other: between these two, whenever we were held up in reading them."""
        boot = getattr(time, "CLOCK_BOOTTIME", None)
        if boot is None:
            return 0, 0
        before_ns = time.clock_gettime_ns(time.CLOCK_MONOTONIC)
        with_sleep_ns = time.clock_gettime_ns(boot)
        after_ns = time.clock_gettime_ns(time.CLOCK_MONOTONIC)
        return with_sleep_ns - after_ns, with_sleep_ns - before_ns

    def check(self) -> None:
        """Raise InstrumentFault, once per sleep, when this machine has slept."""
        least_ns, most_ns = self._least_and_most_ns()
        slept_ns = least_ns - self._ahead_ns
        if slept_ns > SLEPT_NS:
            self._ahead_ns = most_ns
            raise InstrumentFault(
                f"this machine was asleep for {slept_ns * 1e-9:.1f} s: the instrument has stopped by itself; continue"
                " with --resume"
            )
