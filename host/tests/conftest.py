"""conftest.py: what many tests share: fixed property tests, a fake firmware to talk to, both backends of models."""

import importlib
import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fake_firmware import Connect, FakeFirmware
from hypothesis import settings

from gonio.link.tcp import TcpTransport
from gonio.link.transport import Transport

# The same examples in every run, and none fails for being slow.
settings.register_profile("fixed", derandomize=True, deadline=None)
settings.load_profile("fixed")


@pytest.fixture
def connect() -> Iterator[Connect]:
    """connect(**FakeFirmware arguments) gives the fake and a transport; both are closed after the test."""
    opened: list[tuple[FakeFirmware, Transport]] = []

    def make(**arguments: Any) -> tuple[FakeFirmware, Transport]:
        fake = FakeFirmware(**arguments)
        connection = socket.create_connection(("127.0.0.1", fake.port))
        transport = TcpTransport(connection, "fake", lock_step=fake.lock_step)
        opened.append((fake, transport))
        return fake, transport

    yield make
    for fake, transport in opened:
        transport.close()
        fake.close()


@pytest.fixture
def device() -> Iterator[Callable[..., tuple[FakeFirmware, str]]]:
    """device(**FakeFirmware arguments) gives a fake in real time and its device name; it is closed after the test."""
    made: list[FakeFirmware] = []

    def make(**arguments: Any) -> tuple[FakeFirmware, str]:
        made.append(FakeFirmware(lock_step=False, **arguments))
        return made[-1], f"tcp://127.0.0.1:{made[-1].port}"

    yield make
    for fake in made:
        fake.close()


@pytest.fixture(params=["_model", "fallback"], ids=["compiled", "numpy"])
def who_answers(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiled module and then numpy evaluate models and fit grids."""
    module = importlib.import_module(f"gonio.model.{request.param}")
    for user in ("evaluate", "grid_fit"):
        monkeypatch.setattr(f"gonio.model.{user}.model", module)
