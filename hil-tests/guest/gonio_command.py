"""gonio_command.py: the command line `gonio`, imported once and forked for each call: imports take 10 s there."""

import importlib
import io
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path

from guest.processes import POLL_S, NeverCameError, wait_until

# What the commands import only when they need it, beyond what the warming-up call imports.
PRELOADED = (
    "importlib.readers",
    "gonio.acquire.scan",
    "gonio.acquire.operator",
    "gonio.acquire.session",
    "gonio.plan.compile",
    "gonio.link.usb",
)
WARMING_UP = ("gonio", "info", "--json", "--device", "tcp://127.0.0.1:1")  # nobody listens there: it ends at once
PROMPT_END = "Then press Enter."


@dataclass(frozen=True)
class Ended:
    """A command that has ended: what the user would have seen."""

    argv: tuple[str, ...]
    status: int  # negative: the signal that killed it
    seconds: float
    stdout: str
    stderr: str


def preload() -> None:
    """Import what the commands need, before the first fork."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # a process with threads must not be forked
    for name in PRELOADED:
        importlib.import_module(name)
    sys.argv = list(WARMING_UP)
    with suppress(SystemExit), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        _main()()


def _main() -> Callable[[], object]:
    return importlib.import_module("gonio.cli.main").main  # type: ignore[no-any-return]


class GonioCommand:
    """One running `gonio` with the user's arguments, its outputs in files."""

    def __init__(self, arguments: Sequence[str], output: Path) -> None:
        self.argv = ("gonio", *arguments)
        self._output = output.with_suffix(".out")
        self._errors = output.with_suffix(".err")
        for path in (self._output, self._errors):
            path.write_bytes(b"")
        self._began = time.monotonic()
        self._ended: Ended | None = None
        self._answered = 0
        read_end, self._answers = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self._answers)
            self._be_gonio(read_end)
        os.close(read_end)

    def _be_gonio(self, answers: int) -> None:
        status = 70
        try:
            os.setsid()
            signal.signal(signal.SIGINT, signal.default_int_handler)
            for number, path in ((1, self._output), (2, self._errors)):
                descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
                os.dup2(descriptor, number)
                os.close(descriptor)
            os.dup2(answers, 0)
            os.close(answers)
            sys.argv = list(self.argv)
            _main()()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)

    def running(self) -> bool:
        """Whether it has not ended yet."""
        if self._ended is None:
            pid, waited = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                os.close(self._answers)
                self._ended = Ended(
                    self.argv,
                    os.waitstatus_to_exitcode(waited),
                    time.monotonic() - self._began,
                    self._output.read_text(errors="replace"),
                    self._errors.read_text(errors="replace"),
                )
        return self._ended is None

    def prompt(self) -> str | None:
        """What the command asks a person to do and nobody has done yet."""
        asked = [line for line in self._errors.read_text(errors="replace").splitlines() if line.endswith(PROMPT_END)]
        return asked[self._answered] if len(asked) > self._answered else None

    def answer(self) -> None:
        """Press Enter."""
        self._answered += 1
        os.write(self._answers, b"\n")

    def send(self, number: signal.Signals) -> None:
        """Signal it."""
        if self.running():
            os.kill(self.pid, number)

    def wait(self, limit_s: float, meanwhile: Callable[[], None]) -> Ended:
        """Its end. One that does not end is killed, and the scenario fails (NeverCameError)."""

        def ended() -> bool:
            meanwhile()
            return not self.running()

        try:
            wait_until(f"{' '.join(self.argv[:2])} ended", ended, limit_s)
        except NeverCameError:
            self.send(signal.SIGKILL)
            while self.running():
                time.sleep(POLL_S)
            raise
        assert self._ended is not None
        return self._ended
