"""transport.py: the byte stream to the firmware, whatever carries it: tcp.py, twin.py, usb.py."""

from abc import ABC, abstractmethod
from typing import Self

# A twin computes between frames, and a test machine may be slow; a real device sends Status every 100 ms.
LOCK_STEP_SILENCE_S = 60.0
PACED_SILENCE_S = 5.0


class Transport(ABC):
    """A connected byte stream. `lock_step` says that the other side keeps virtual time with us."""

    def __init__(self, name: str, *, lock_step: bool) -> None:
        self.name = name  # as the user wrote it; begins every error
        self.lock_step = lock_step
        self.silence_s = LOCK_STEP_SILENCE_S if lock_step else PACED_SILENCE_S

    @abstractmethod
    def receive(self) -> bytes:
        """The next bytes, as many as there are, at least one. Raises InstrumentFault when the other side is silent or
        gone."""

    @abstractmethod
    def send(self, data: bytes) -> None:
        """Send all bytes. Raises InstrumentFault when the other side is gone."""

    @abstractmethod
    def close(self) -> None:
        """End the stream. Safe to call twice."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
