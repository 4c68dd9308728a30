"""tcp.py: the link over TCP: a controller through a port of this machine, or a twin."""

import socket

from gonio.link.transport import Transport
from gonio.units.errors import InstrumentFault, UsageError

CHUNK_BYTES = 1 << 20
CONNECT_TIMEOUT_S = 5.0


class TcpTransport(Transport):
    """A connected socket."""

    def __init__(self, connection: socket.socket, name: str, *, lock_step: bool = False) -> None:
        super().__init__(name, lock_step=lock_step)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.settimeout(self.silence_s)
        self._connection = connection

    def receive(self) -> bytes:
        try:
            data = self._wait_for_bytes()
        except TimeoutError as error:
            raise InstrumentFault(
                f"{self.name}: no word from the firmware for {self.silence_s:.0f} s; the instrument stops by itself"
            ) from error
        except OSError as error:
            raise self._lost() from error
        if not data:
            raise self._lost()
        return data

    def _wait_for_bytes(self) -> bytes:
        return self._connection.recv(CHUNK_BYTES)

    def send(self, data: bytes) -> None:
        try:
            self._connection.sendall(data)
        except OSError as error:
            raise self._lost() from error

    def _lost(self) -> InstrumentFault:
        return InstrumentFault(
            f"{self.name}: the firmware closed the link{self._last_words()}; the instrument stops by itself"
        )

    def _last_words(self) -> str:
        """What is known of why the other side has gone."""
        return ""

    def close(self) -> None:
        self._connection.close()


def open_tcp(host: str, port: int, name: str) -> TcpTransport:
    """Connect to a controller's port. Raises UsageError when nobody listens."""
    try:
        connection = socket.create_connection((host, port), CONNECT_TIMEOUT_S)
    except OSError as error:
        raise UsageError(f"{name}: cannot connect ({error}): is the instrument on?") from error
    return TcpTransport(connection, name)
