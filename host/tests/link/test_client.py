"""test_client.py: the session's rules against a scripted firmware."""

import itertools
import threading

import pytest
from fake_firmware import TICK_NS, Connect, FakeFirmware

from gonio.link.client import ALIVE_INTERVAL_NS, REPLY_TIMEOUT_NS, Client
from gonio.protocol.frames import FrameError, FrameProblem
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.units.errors import InstrumentFault, UsageError


def take(client: Client, count: int) -> None:
    for _ in range(count):
        client.step()


def test_other_schema_is_refused_and_both_are_named(connect: Connect) -> None:
    _, transport = connect(schema_hash=0x1234)
    with pytest.raises(UsageError) as caught:
        Client(transport)
    assert f"{records.SCHEMA_HASH:016x}" in str(caught.value)
    assert "0000000000001234" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_refusal_of_the_firmware_is_passed_on(connect: Connect) -> None:
    _, transport = connect(refusal="another program drives")
    with pytest.raises(UsageError, match="another program drives"):
        Client(transport)


def test_request_gets_its_reply(connect: Connect) -> None:
    def answer(_: FakeFirmware, request: pb.Request) -> pb.Reply | None:
        return pb.Reply(info=pb.Info(device="fake", axis_count=4)) if request.HasField("get_info") else None

    fake, transport = connect(on_request=answer)
    with Client(transport) as client:
        assert client.request(get_info=pb.GetInfo()).info.axis_count == 4
        client.operation(10 * TICK_NS, home=pb.Home(axis_mask=15))
    assert [r.WhichOneof("body") for r in fake.requests] == ["get_info", "home"]
    assert fake.broken == []


@pytest.mark.parametrize(
    ("code", "error"),
    [(pb.REPLY_NOT_DRIVER, UsageError), (pb.REPLY_REFUSED, InstrumentFault), (pb.REPLY_INVALID, InstrumentFault)],
)
def test_bad_reply_is_an_error_with_its_text(connect: Connect, code: pb.ReplyCode, error: type[Exception]) -> None:
    _, transport = connect(on_request=lambda _fake, _request: pb.Reply(code=code, text="not now"))
    with Client(transport) as client, pytest.raises(error):
        client.request(boot=pb.Boot())


def test_answers_are_marked_with_the_frame_they_answer(connect: Connect) -> None:
    """Lock-step: whatever was received, what is sent in answer to frame n says n, and one IDLE closes each batch."""

    def talk(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:  # several frames in one go
            fake.event(log=pb.Log(text="a"))
            fake.event(log=pb.Log(text="b"))

    fake, transport = connect(on_tick=talk, ticks=8)
    answered: list[int] = []
    with Client(transport) as client:

        def on_event(event: pb.Event) -> None:
            if event.HasField("log"):
                answered.append(client.last_sequence)
                client.send_request(get_info=pb.GetInfo())

        client.on_event = on_event
        take(client, 12)
    asked = [f.acknowledged for f in fake.received if f.kind == records.FRAME_REQUEST]
    assert asked == answered
    assert len(asked) == 2
    assert asked[1] == asked[0] + 1
    idles = [f.acknowledged for f in fake.received if f.kind == records.FRAME_IDLE]
    assert idles == sorted(idles)
    assert fake.broken == []


def test_gaps_are_counted_and_not_hidden(connect: Connect) -> None:
    def lose(fake: FakeFirmware, tick: int) -> None:
        if tick == 2:
            fake.put(records.FRAME_SAMPLES, bytes(56), skip=3)

    _, transport = connect(on_tick=lose)
    seen: list[int] = []
    with Client(transport) as client:
        client.on_frame = lambda frame: seen.append(frame.sequence)
        take(client, 5)
        assert client.gap_frames == 3
    assert seen == [1, 2, 6, 7, 8]


def test_damaged_frame_ends_the_session(connect: Connect) -> None:
    def damage(fake: FakeFirmware, tick: int) -> None:
        if tick == 2:
            fake.put(records.FRAME_POSES, bytes(16), damage=True)

    _, transport = connect(on_tick=damage)
    with Client(transport) as client, pytest.raises(FrameError) as caught:
        take(client, 10)
    assert caught.value.problem is FrameProblem.CRC
    assert caught.value.exit_status == 3


def test_time_outs_count_link_time(connect: Connect) -> None:
    """The wait ends after its own time on the firmware's clock: the fake runs through it in a moment."""
    fake, transport = connect()
    with Client(transport) as client:
        client.step()
        begun_ns = client.link_time_ns
        with pytest.raises(InstrumentFault, match="homing: not done after 2 s"):
            client.wait_until(lambda: False, REPLY_TIMEOUT_NS, "homing")
        assert client.link_time_ns - begun_ns == REPLY_TIMEOUT_NS + TICK_NS
    assert fake.broken == []


def test_fault_ends_a_wait_with_the_firmwares_sentence(connect: Connect) -> None:
    def fail(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(fault=pb.Fault(code=pb.FAULT_NODE_LOST, node=3, sentence="node 3: heartbeat stopped"))

    _, transport = connect(on_tick=fail)
    with Client(transport) as client:
        with pytest.raises(InstrumentFault, match="node 3: heartbeat stopped"):
            client.wait_until(lambda: False, REPLY_TIMEOUT_NS, "homing")
        client.request(set_output=pb.SetOutput(output=pb.OUTPUT_SHUTTER), despite_fault=True)


def test_paced_device_gets_alive_and_never_idle(connect: Connect) -> None:
    """One Status per step (every 100 ms of link time): ALIVE goes out at every second one."""
    turn = threading.Semaphore(0)
    fake, transport = connect(lock_step=False, on_tick=lambda _fake, _tick: turn.acquire() and None)
    with Client(transport) as client:
        for _ in range(20):
            turn.release()
            client.step()
    turn.release(1000)
    fake.close()
    alive = [f.acknowledged for f in fake.received if f.kind == records.FRAME_ALIVE]
    assert len(alive) == 10
    assert {b - a for a, b in itertools.pairwise(alive)} == {ALIVE_INTERVAL_NS // TICK_NS}
    assert fake.broken == []


def test_lost_link_is_said(connect: Connect) -> None:
    _, transport = connect(ticks=3)
    with Client(transport) as client, pytest.raises(InstrumentFault, match="closed the link"):
        take(client, 10)


def test_event_that_is_no_event_is_named(connect: Connect) -> None:
    def talk(fake: FakeFirmware, tick: int) -> None:
        if tick == 1:
            fake.put(records.FRAME_EVENT, b"\xff\xff\xff\xff")

    _, transport = connect(on_tick=talk)
    with Client(transport) as client, pytest.raises(InstrumentFault, match="is no Event"):
        take(client, 4)
