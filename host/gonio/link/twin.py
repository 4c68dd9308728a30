"""twin.py: a twin process of our own in virtual time, and the link to it."""

import os
import socket
import subprocess
import tempfile
from pathlib import Path
from typing import IO

from gonio.link.tcp import CONNECT_TIMEOUT_S, TcpTransport
from gonio.units.errors import InstrumentFault, UsageError

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


class TwinTransport(TcpTransport):
    """The link to a twin of our own, which waits for us as we wait for it."""

    def __init__(self, connection: socket.socket, name: str, twin: TwinProcess) -> None:
        super().__init__(connection, name, lock_step=True)
        self.twin = twin

    def _wait_for_bytes(self) -> bytes:
        while True:
            try:
                return super()._wait_for_bytes()
            except TimeoutError:
                if not self.twin.tracing():
                    raise

    def _last_words(self) -> str:
        said = self.twin.last_words()
        return f" ({said})" if said else ""

    def close(self) -> None:
        """Close the stream, and wait for the twin to bring its instrument to rest."""
        super().close()
        self.twin.wait()


def open_twin(scenario: Path, name: str, *, truth: Path | None, journal: Path | None) -> TwinTransport:
    """Start a twin, which may write its truth and journal files, and connect. Raises UsageError with its complaint."""
    twin = TwinProcess(scenario, virtual=True, truth=truth, journal=journal)
    try:
        connection = socket.create_connection((twin.host, twin.port), CONNECT_TIMEOUT_S)
    except OSError as error:
        twin.terminate()
        raise InstrumentFault(f"{name}: cannot connect to the twin: {error}") from error
    return TwinTransport(connection, name, twin)
