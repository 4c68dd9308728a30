"""client.py: one session with the firmware: hand-shake, requests, events, lock-step with virtual time.

The client handles one received frame at a time. What it sends is marked as the answer to the frame it last handled,
so a run in virtual time repeats bit for bit however the stream was cut into pieces. Time-outs count link time, never
the wall clock.
"""

from collections import deque
from collections.abc import Callable
from typing import Any, Self, TypeVar

from google.protobuf.message import DecodeError

from gonio.link.transport import Transport
from gonio.protocol.frames import Frame, FrameDecoder, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.protocol.messages import check_reply, code_name, request_name
from gonio.units.errors import InstrumentFault, UsageError

ALIVE_INTERVAL_NS = 200_000_000  # three words and more before the firmware begins to stop (protocol/link.md)
REPLY_TIMEOUT_NS = 2_000_000_000  # the firmware answers within a cycle; two seconds mean that it does not
SOFTWARE = "gonio-host 0.1.0"
_Message = TypeVar("_Message", pb.Hello, pb.Event, pb.Reply)


class Client:
    """A session. `on_frame` sees every numbered firmware frame, whole; `on_event` every event, after the client."""

    def __init__(
        self, transport: Transport, role: pb.Role = pb.ROLE_DRIVER, schema_hash: int = records.SCHEMA_HASH
    ) -> None:
        self._transport = transport
        self._is_driver = role == pb.ROLE_DRIVER
        self._decoder = FrameDecoder()
        self._waiting: deque[Frame] = deque()
        self._out: list[bytes] = []
        self._sent_sequence = 0
        self._next_request = 1
        self._replies: dict[int, pb.Reply] = {}
        self._operations: dict[int, pb.OperationDone] = {}
        self._last_alive_ns = 0
        self.last_sequence = 0  # last numbered firmware frame handled
        self.gap_frames = 0  # firmware frames that never came
        self.link_time_ns = 0
        self.status: pb.Status | None = None
        self.counters: pb.Counters | None = None
        self.fault: pb.Fault | None = None
        self.on_frame: Callable[[Frame], None] | None = None
        self.on_request: Callable[[bytes], None] | None = None
        self.on_event: Callable[[pb.Event], None] | None = None
        self.before_receive: Callable[[], None] | None = None
        self.hello = self._shake_hands(role, schema_hash)

    def _shake_hands(self, role: pb.Role, schema_hash: int) -> pb.Hello:
        mine = pb.Hello(schema_hash=schema_hash, software=SOFTWARE, role=role)
        self._transport.send(encode_frame(records.FRAME_HELLO, 0, 0, mine.SerializeToString()))
        while not self._waiting:
            self._waiting.extend(self._decoder.feed(self._transport.receive()))
        frame = self._waiting.popleft()
        if frame.kind != records.FRAME_HELLO:
            raise InstrumentFault(f"{self._transport.name}: the first frame is of kind {frame.kind}, HELLO expected")
        hello = self._parse(pb.Hello, frame)
        if hello.schema_hash != schema_hash:
            raise UsageError(
                f"{self._transport.name}: host and firmware speak different protocols: host {schema_hash:016x},"
                f" firmware {hello.schema_hash:016x} ({hello.software or 'unnamed'}); build both from the same source"
            )
        if hello.refusal:
            raise UsageError(f"{self._transport.name}: {hello.refusal}")
        return hello

    def _parse(self, kind: type[_Message], frame: Frame) -> _Message:
        message = kind()
        try:
            message.ParseFromString(bytes(frame.payload))
        except DecodeError as error:
            raise InstrumentFault(
                f"{self._transport.name}: frame {frame.sequence} (kind {frame.kind}) is no {kind.__name__}"
            ) from error
        return message

    # Sending

    def _put(self, kind: int, payload: bytes = b"") -> bytes:
        self._sent_sequence += 1
        raw = encode_frame(kind, self._sent_sequence, self.last_sequence, payload)
        self._out.append(raw)
        return raw

    def send_request(self, **body: Any) -> int:
        """Queue a request, e.g. send_request(home=pb.Home(axis_mask=15)); its id."""
        request = pb.Request(id=self._next_request, **body)
        self._next_request += 1
        raw = self._put(records.FRAME_REQUEST, request.SerializeToString())
        if self.on_request:
            self.on_request(raw)
        return int(request.id)

    def send_knots(self, payload: bytes) -> None:
        """Queue a KNOTS frame (blocks.knot_payload)."""
        self._put(records.FRAME_KNOTS, payload)

    def _flush(self) -> None:
        """Send what is queued. In lock-step, say that nothing more comes in answer to what was handled."""
        if self._transport.lock_step:
            self._out.append(encode_frame(records.FRAME_IDLE, 0, self.last_sequence))
        elif self._out:
            self._last_alive_ns = self.link_time_ns
        elif self.link_time_ns - self._last_alive_ns >= ALIVE_INTERVAL_NS:
            self._out.append(encode_frame(records.FRAME_ALIVE, 0, self.last_sequence))
            self._last_alive_ns = self.link_time_ns
        if self._out:
            self._transport.send(b"".join(self._out))
            self._out.clear()

    # Receiving

    def step(self) -> None:
        """Handle the next frame, waiting for it if need be. Raises InstrumentFault when the link is lost or damaged."""
        if not self._waiting:
            if self.before_receive:
                self.before_receive()
            self._flush()
            while not self._waiting:
                self._waiting.extend(self._decoder.feed(self._transport.receive()))
        self._handle(self._waiting.popleft())

    def _handle(self, frame: Frame) -> None:
        if frame.sequence:
            self.gap_frames += frame.sequence - self.last_sequence - 1
            self.last_sequence = frame.sequence
        event = None
        if frame.kind == records.FRAME_EVENT:
            event = self._parse(pb.Event, frame)
            self.link_time_ns = max(self.link_time_ns, event.time_ns)
        if self.on_frame and frame.sequence:
            self.on_frame(frame)
        if event is not None:
            self._take_event(event)
        elif frame.kind == records.FRAME_REPLY:
            reply = self._parse(pb.Reply, frame)
            self._replies[reply.id] = reply

    def _take_event(self, event: pb.Event) -> None:
        body = event.WhichOneof("body")
        if body == "status":
            self.status = event.status
        elif body == "counters":
            self.counters = event.counters
        elif body == "fault":
            self.fault = event.fault
        elif body == "done":
            self._operations[event.done.request_id] = event.done
        if self.on_event:
            self.on_event(event)

    # Waiting

    def wait_until(
        self, condition: Callable[[], bool], timeout_ns: int, what: str, *, despite_fault: bool = False
    ) -> None:
        """Handle frames until the condition holds.

        Raises InstrumentFault with the firmware's sentence when a fault comes first (unless `despite_fault`), or one
        that names `what` after `timeout_ns` of link time.
        """
        self._wait_for_clock()
        deadline_ns = self.link_time_ns + timeout_ns
        while not condition():
            if self.fault is not None and not despite_fault:
                raise InstrumentFault(self.fault.sentence)
            if self.link_time_ns > deadline_ns:
                raise InstrumentFault(f"{what}: not done after {timeout_ns * 1e-9:g} s; see gonio info")
            self.step()

    def _wait_for_clock(self) -> None:
        """The first Status sets the link's clock. A visitor gets none: the transport's own silence limit must do."""
        while self._is_driver and self.status is None:
            self.step()

    def request(self, *, despite_fault: bool = False, **body: Any) -> pb.Reply:
        """Send a request and wait for its reply. Raises UsageError or InstrumentFault when it is not granted."""
        self._wait_for_clock()
        number = self.send_request(**body)
        what = request_name(pb.Request(**body)).replace("_", " ")
        self.wait_until(lambda: number in self._replies, REPLY_TIMEOUT_NS, what, despite_fault=despite_fault)
        reply = self._replies.pop(number)
        check_reply(what, reply.code, reply.text)
        return reply

    def operation(self, timeout_ns: int, **body: Any) -> None:
        """Send a request for a long operation and wait for its end. A fault on the way is raised as it was said."""
        reply = self.request(**body)
        if reply.code != pb.REPLY_ACCEPTED:
            return
        what = request_name(pb.Request(**body)).replace("_", " ")
        number = int(reply.id)
        self.wait_until(lambda: number in self._operations, timeout_ns, what)
        done = self._operations.pop(number)
        if done.code != pb.REPLY_OK:
            raise InstrumentFault(done.text or f"{what}: {code_name(done.code)}")

    def close(self) -> None:
        """End the session; the firmware stops by itself if it was moving."""
        self._transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
