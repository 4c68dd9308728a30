"""fake_firmware.py: a scripted firmware for tests of the host's link, on a TCP socket in a thread of the test.

It speaks frames, numbers them, keeps virtual time in steps of one Status, grants credits and finishes a path once it
has all its knots. It does not move anything, check a path, know the CAN bus, take samples, expire, or replay: those are
the twin's part. What it was sent is kept in `received`; a rule that the host broke is kept in `broken`.
"""

import socket
import threading
from collections.abc import Callable

from gonio.link.transport import Transport
from gonio.protocol.blocks import knot_block
from gonio.protocol.frames import Frame, FrameDecoder, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records

TICK_NS = 100_000_000
CREDIT_STEP = 60
AHEAD_TICKS = 4  # in real time the host says a word at every second one
GIVE_UP_S = 60.0


class FakeFirmware:
    """Serves one client. `on_request` may answer a request by itself: it returns the reply, or None for the default."""

    def __init__(
        self,
        *,
        lock_step: bool = True,
        schema_hash: int = records.SCHEMA_HASH,
        refusal: str = "",
        on_request: Callable[["FakeFirmware", pb.Request], pb.Reply | None] | None = None,
        on_tick: Callable[["FakeFirmware", int], None] | None = None,
        ticks: int = 400,
    ) -> None:
        self.lock_step = lock_step
        self.schema_hash = schema_hash
        self.refusal = refusal
        self.on_request = on_request
        self.on_tick = on_tick
        self.ticks = ticks
        self.received: list[Frame] = []
        self.requests: list[pb.Request] = []
        self.broken: list[str] = []
        self.time_ns = 1_000_000_000
        self.sequence = 0
        self.status = pb.Status(state=pb.STATE_READY, position_counts=[0, 0, 0, 0], position_known_mask=15)
        self.knots_received = 0
        self.knot_count = 0
        self._host_sequence = 0
        self._unheard_ticks = 0  # since the host's last word
        self._decoder = FrameDecoder()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._connection: socket.socket | None = None
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Wait for the thread; the client must have gone."""
        self._thread.join(20.0)
        self._listener.close()
        assert not self._thread.is_alive(), "the fake firmware did not see its client go"

    # What a script may say

    def put(self, kind: int, payload: bytes, *, skip: int = 0, damage: bool = False) -> None:
        """Send a numbered frame; `skip` leaves out numbers before it, `damage` flips a bit of its payload."""
        self.sequence += 1 + skip
        raw = bytearray(encode_frame(kind, self.sequence, self._host_sequence, payload))
        if damage:
            raw[-1] ^= 1
        assert self._connection is not None
        self._connection.sendall(raw)

    def event(self, **body: object) -> None:
        self.put(records.FRAME_EVENT, pb.Event(time_ns=self.time_ns, **body).SerializeToString())

    # The thread

    def _serve(self) -> None:
        try:
            self._connection, _ = self._listener.accept()
            self._run(self._connection)
        except OSError:
            pass  # the client has gone: the end of every script
        finally:
            if self._connection:
                self._connection.close()

    def _run(self, connection: socket.socket) -> None:
        frames = self._read()
        hello = pb.Hello()
        hello.ParseFromString(bytes(frames[0].payload))
        mine = pb.Hello(schema_hash=self.schema_hash, software="fake 1", session_id=1, refusal=self.refusal)
        connection.sendall(encode_frame(records.FRAME_HELLO, 0, 0, mine.SerializeToString()))
        if self.refusal:
            return
        for tick in range(self.ticks):
            self.time_ns += TICK_NS
            if self.on_tick:
                self.on_tick(self, tick)
            self.status.knot_credit = min(self.knot_count, self.knots_received + CREDIT_STEP)
            self.event(status=self.status)
            self._listen()
            self._wait_for_host()

    def _read(self) -> list[Frame]:
        assert self._connection is not None
        frames: list[Frame] = []
        while not frames:
            data = self._connection.recv(1 << 20)
            if not data:
                raise OSError("the client has gone")
            frames = self._decoder.feed(data)
        self.received += frames
        return frames

    def _wait_for_host(self) -> None:
        """In real time: a host that is held up finds no more than a few ticks waiting for it, so that a slow machine
        runs into no time-out."""
        assert self._connection is not None
        self._connection.settimeout(GIVE_UP_S)
        self._unheard_ticks += 1
        while not self.lock_step and self._unheard_ticks > AHEAD_TICKS:
            for frame in self._read():
                self._take(frame)

    def _listen(self) -> None:
        """Take frames: in lock-step until the host is idle after our last frame, else what comes within a moment."""
        idle = False
        assert self._connection is not None
        self._connection.settimeout(20.0 if self.lock_step else 0.005)
        while not idle:
            try:
                frames = self._read()
            except TimeoutError:
                return
            for frame in frames:
                answered = self.sequence
                self._take(frame)
                if frame.kind == records.FRAME_IDLE:
                    idle = frame.acknowledged >= answered and self.sequence == answered

    def _take(self, frame: Frame) -> None:
        self._unheard_ticks = 0
        if frame.sequence:
            if frame.sequence != self._host_sequence + 1:
                self.broken.append(f"host frame {frame.sequence} after {self._host_sequence}")
            self._host_sequence = frame.sequence
        if frame.kind == records.FRAME_IDLE and not self.lock_step:
            self.broken.append("IDLE to a paced device")
        if frame.kind == records.FRAME_REQUEST:
            request = pb.Request()
            request.ParseFromString(bytes(frame.payload))
            self.requests.append(request)
            self._answer(request)
        elif frame.kind == records.FRAME_KNOTS:
            self._take_knots(frame)

    def _take_knots(self, frame: Frame) -> None:
        head, knots = knot_block(frame.payload)
        if int(head["first_knot"]) != self.knots_received:
            self.broken.append(f"knot {head['first_knot']} after {self.knots_received}")
        self.knots_received += len(knots)
        if self.knots_received > self.status.knot_credit:
            self.broken.append(f"{self.knots_received} knots, credit {self.status.knot_credit}")
        if self.knots_received == self.knot_count:
            self.event(path=pb.PathState(path_id=self.status.path_id, end=pb.PATH_FINISHED, path_time_ns=1))

    def _answer(self, request: pb.Request) -> None:
        reply = self.on_request(self, request) if self.on_request else None
        body = request.WhichOneof("body")
        if reply is None:
            long = body in ("boot", "home")
            reply = pb.Reply(code=pb.REPLY_ACCEPTED if long else pb.REPLY_OK)
        reply.id = request.id
        self.put(records.FRAME_REPLY, reply.SerializeToString())
        if reply.code == pb.REPLY_ACCEPTED:
            self.event(done=pb.OperationDone(request_id=request.id, code=pb.REPLY_OK))
        if reply.code != pb.REPLY_OK:
            return
        if body == "motion_begin":
            self.knots_received, self.knot_count = 0, request.motion_begin.knot_count
            self.status.path_id = request.motion_begin.path_id
        elif body == "acquire":
            self.status.acquiring = self.status.clock_locked = request.acquire.on
        elif body == "set_output" and request.set_output.output == pb.OUTPUT_SHUTTER:
            self.status.shutter_open = request.set_output.on
        elif body == "stop":
            self.status.shutter_open = False
            self.event(path=pb.PathState(path_id=self.status.path_id, end=pb.PATH_STOPPED, path_time_ns=1))


Connect = Callable[..., tuple[FakeFirmware, Transport]]  # the fixture `connect`
