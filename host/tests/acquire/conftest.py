"""conftest.py: the link tests' fake firmware and the raw log tests' small log, here too."""

import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

for folder in ("link", "rawlog"):
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / folder))

from fake_firmware import Connect, FakeFirmware  # noqa: E402 - found by the path above

from gonio.link.transport import Transport  # noqa: E402 - stays beside it


@pytest.fixture
def connect() -> Iterator[Connect]:
    """connect(**FakeFirmware arguments) gives the fake and a transport; both are closed after the test."""
    opened: list[tuple[FakeFirmware, Transport]] = []

    def make(**arguments: Any) -> tuple[FakeFirmware, Transport]:
        fake = FakeFirmware(**arguments)
        connection = socket.create_connection(("127.0.0.1", fake.port))
        transport = Transport(connection, lock_step=fake.lock_step, name="fake")
        opened.append((fake, transport))
        return fake, transport

    yield make
    for fake, transport in opened:
        transport.close()
        fake.close()
