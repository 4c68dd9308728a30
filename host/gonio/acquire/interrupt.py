"""interrupt.py: how a running scan is asked to stop: Ctrl-C, SIGTERM, or gonio stop through the control socket."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Self

from gonio.acquire.control import ControlSocket
from gonio.link.client import Client
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.errors import GonioError, InstrumentFault


class ScanStopped(GonioError):  # noqa: N818 - nothing went wrong: someone asked
    """The scan was stopped on request; the status is the shell's for SIGINT."""

    exit_status = 128 + signal.SIGINT


def stop_from_elsewhere(event: pb.Event, interrupt: "Interrupt") -> None:
    """A visitor's stop counts whatever the scan is doing, standing still included."""
    if event.WhichOneof("body") == "stop":
        interrupt.ask(f"another program ({event.stop.reason})")


@contextmanager
def a_stop_is_no_fault(interrupt: "Interrupt", client: Client) -> Iterator[None]:
    """A stop ends the firmware's operations with sentences of their own: raises ScanStopped for them when somebody had
    asked for it and the instrument has no fault."""
    try:
        yield
    except InstrumentFault:
        if client.fault is None:
            interrupt.check()
        raise


class Interrupt:
    """Collects requests to stop.

    A second Ctrl-C or SIGTERM while stopping ends the program at once: the firmware then stops by itself within its
    expiry.
    """

    def __init__(self, control: ControlSocket | None = None) -> None:
        self._control = control
        self._handlers: dict[int, signal.Handlers | signal._HANDLER] = {}
        self._acknowledged = False
        self.reason: str | None = None

    def _on_signal(self, number: int, _frame: FrameType | None) -> None:
        if self._acknowledged:
            raise KeyboardInterrupt
        self.reason = "Ctrl-C" if number == signal.SIGINT else "SIGTERM"

    def ask(self, reason: str) -> None:
        """Stop at the next check; the first reason counts."""
        self.reason = self.reason or reason

    def check(self) -> None:
        """Raise ScanStopped, once, when someone asked to stop."""
        if self._acknowledged:
            return
        if self._control and self.reason is None:
            self.reason = self._control.poll()
        if self.reason is not None:
            self._acknowledged = True
            raise ScanStopped(f"stopped by {self.reason}")

    def __enter__(self) -> Self:
        for number in (signal.SIGINT, signal.SIGTERM):
            self._handlers[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
