"""transport.py: the byte stream to the firmware: TCP, or a twin process of our own in virtual time."""

import os
import socket
import subprocess
import tempfile
from pathlib import Path
from typing import IO, Self

from gonio.link.device import Device
from gonio.units.errors import InstrumentFault, UsageError

CHUNK_BYTES = 1 << 20
# A twin computes between frames, and a test machine may be slow; a real device sends Status every 100 ms.
LOCK_STEP_SILENCE_S = 60.0
PACED_SILENCE_S = 5.0
CONNECT_TIMEOUT_S = 5.0
START_TIMEOUT_S = 30.0  # the twin loads its scenario before it listens
TELLS_OF_LIGHT = "photon map: "  # how the twin begins a line on its standard error that is no complaint
TRACES = TELLS_OF_LIGHT + "tracing "  # its last line while it traces a sample; that takes what it takes
END_TIMEOUT_S = 60.0  # after we are gone the twin still brings the arm to rest and writes its journal


def twin_program() -> Path:
    """The twin's program: GONIO_TWIN, else the build in the source tree. Raises UsageError when it is not there."""
    named = os.environ.get("GONIO_TWIN")
    program = Path(named) if named else Path(__file__).resolve().parents[3] / "build" / "native" / "sim" / "gonio-twin"
    if not os.access(program, os.X_OK):
        where = "GONIO_TWIN names" if named else "the twin is not built:"
        raise UsageError(f"{where} {program}, which is no program: run make build")
    return program


class TwinProcess:
    """A twin that this program started; it has its own process session, so that Ctrl-C reaches only us."""

    def __init__(
        self, scenario: Path, *, virtual: bool, truth: Path | None = None, journal: Path | None = None, port: int = 0
    ) -> None:
        command = [str(twin_program()), str(scenario), "--virtual" if virtual else "--paced"]
        command += ["--listen", f"127.0.0.1:{port}"]
        command += ["--truth", str(truth)] if truth else []
        command += ["--journal", str(journal)] if journal else []
        self._stderr: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process
        self.process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self._stderr, start_new_session=True
        )
        self.host, self.port = self._address()

    def _address(self) -> tuple[str, int]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline().decode(errors="replace").strip()
        word, _, address = line.partition(" ")
        host, _, port = address.rpartition(":")
        if word != "listening" or not port.isdigit():
            self.process.wait(START_TIMEOUT_S)
            said = self.last_words()
            # The twin says itself what is wrong with a scenario.
            raise UsageError(said or f"the twin did not start (it said {line!r}): run make build")
        return host, int(port)

    def last_words(self) -> str:
        """The last complaint that the twin wrote to its standard error, or nothing."""
        complaints = [line for line in self._told() if not line.startswith(TELLS_OF_LIGHT)]
        return complaints[-1].removeprefix("gonio-twin: ") if complaints else ""

    def tracing(self) -> bool:
        """Whether the twin is at work on a photon map, and so says nothing on the link."""
        told = self._told()
        return bool(told) and told[-1].startswith(TRACES) and self.process.poll() is None

    def _told(self) -> list[str]:
        # The twin writes through the same open file: pread leaves its place in it alone.
        length = os.fstat(self._stderr.fileno()).st_size
        return os.pread(self._stderr.fileno(), length, 0).decode(errors="replace").strip().splitlines()

    def wait(self) -> int:
        """Wait for the end of a virtual twin whose driver is gone; its exit status. Raises InstrumentFault."""
        try:
            return self.process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired as error:
            self.terminate()
            raise InstrumentFault(
                f"the twin did not come to rest within {END_TIMEOUT_S:.0f} s and was ended"
            ) from error

    def terminate(self) -> None:
        """End the twin now."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


class Transport:
    """A connected byte stream. `lock_step` says that the other side keeps virtual time with us."""

    def __init__(
        self, connection: socket.socket, *, lock_step: bool, name: str, twin: TwinProcess | None = None
    ) -> None:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.silence_s = LOCK_STEP_SILENCE_S if lock_step else PACED_SILENCE_S
        connection.settimeout(self.silence_s)
        self._connection = connection
        self.lock_step = lock_step
        self.name = name
        self.twin = twin

    def receive(self) -> bytes:
        """The next bytes, as many as there are. Raises InstrumentFault when the other side is silent or gone."""
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
        while True:
            try:
                return self._connection.recv(CHUNK_BYTES)
            except TimeoutError:
                if not (self.twin and self.twin.tracing()):
                    raise

    def send(self, data: bytes) -> None:
        """Send all bytes. Raises InstrumentFault when the other side is gone."""
        try:
            self._connection.sendall(data)
        except OSError as error:
            raise self._lost() from error

    def _lost(self) -> InstrumentFault:
        said = f" ({self.twin.last_words()})" if self.twin and self.twin.last_words() else ""
        return InstrumentFault(f"{self.name}: the firmware closed the link{said}; the instrument stops by itself")

    def close(self) -> None:
        """Close the stream; wait for a twin of ours to bring its instrument to rest. Safe to call twice."""
        self._connection.close()
        if self.twin:
            self.twin.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_transport(device: Device, *, truth: Path | None = None, journal: Path | None = None) -> Transport:
    """Connect to a device; a twin is started first and may write its truth and journal files.

    Raises UsageError when there is nothing to connect to, or when truth or journal are asked of a device that has none.
    """
    if device.scenario is not None:
        twin = TwinProcess(device.scenario, virtual=True, truth=truth, journal=journal)
        try:
            connection = socket.create_connection((twin.host, twin.port), CONNECT_TIMEOUT_S)
        except OSError as error:
            twin.terminate()
            raise InstrumentFault(f"{device.name}: cannot connect to the twin: {error}") from error
        return Transport(connection, lock_step=True, name=device.name, twin=twin)
    if truth or journal:
        raise UsageError(f"{device.name}: only a twin: device writes truth and journal files")
    try:
        connection = socket.create_connection((device.host, device.port), CONNECT_TIMEOUT_S)
    except OSError as error:
        raise UsageError(f"{device.name}: cannot connect ({error}): is the instrument on?") from error
    return Transport(connection, lock_step=False, name=device.name)
