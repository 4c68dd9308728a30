"""test_runner.py: a program's steps against a scripted firmware: credits, ends of paths, faults, stops."""

import numpy as np
import pytest
from fake_firmware import CREDIT_STEP, Connect, FakeFirmware

from gonio.acquire.interrupt import Interrupt, ScanStopped, stop_from_elsewhere
from gonio.acquire.operator import AssumedOperator
from gonio.acquire.progress import ScanProgress
from gonio.acquire.runner import Runner
from gonio.acquire.session import Session
from gonio.link.client import Client
from gonio.link.transport import Transport
from gonio.plan.program import DarkStep, OperatorStep, PathStep, Program, ShutterStep
from gonio.protocol.blocks import knot_block
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.units.errors import InstrumentFault
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)


def path(path_id: int, count: int) -> PathStep:
    knots = np.zeros(count, records.KNOT_DTYPE)
    knots["time_ns"] = np.arange(count) * 50_000_000
    knots["position_counts"][:, 2] = np.arange(count) * 10.0
    return PathStep(path_id, "coarse", f"coarse {path_id}", knots, 30.0, 0.0)


def run(transport: Transport, program: Program) -> Client:
    client = Client(transport)
    session = Session(client, REFERENCE)
    with ScanProgress(program.duration_s) as progress:
        runner = Runner(session, AssumedOperator(), progress)
        client.on_event = runner.take_event
        runner.run(program)
    return client


def test_knots_go_by_credits_and_arrive_as_planned(connect: Connect) -> None:
    fake, transport = connect()
    steps = [path(1, 5 * CREDIT_STEP + 7), path(2, 3)]
    run(transport, Program(steps=list(steps)))
    assert fake.broken == []
    blocks = [knot_block(f.payload) for f in fake.received if f.kind == records.FRAME_KNOTS]
    for step in steps:
        sent = np.concatenate([knots for head, knots in blocks if int(head["path_id"]) == step.path_id])
        np.testing.assert_array_equal(sent, step.knots)
    assert max(len(knots) for _, knots in blocks) <= 50


def test_steps_in_their_order(connect: Connect) -> None:
    fake, transport = connect()
    program = Program(
        steps=[
            OperatorStep("sample_removed", "Remove the sample."),
            DarkStep(1.0),
            ShutterStep(True),
            path(1, 4),
            ShutterStep(False),
        ]
    )
    begun = fake.time_ns
    run(transport, program)
    bodies = [request.WhichOneof("body") for request in fake.requests]
    assert bodies == ["operator_done", "set_output", "motion_begin", "set_output"]
    assert fake.requests[0].operator_done.action == pb.OPERATOR_SAMPLE_REMOVED
    assert fake.time_ns - begun >= 1_000_000_000  # the dark step stood for its second of link time
    assert not fake.status.shutter_open


def test_fault_on_the_way_is_the_firmwares_sentence(connect: Connect) -> None:
    sentence = "axis 3 (node 3): 0x6065 following error, commanded 1000, measured 400: free the arm, then home"

    def fail(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(path=pb.PathState(path_id=1, end=pb.PATH_FAULT))
            fake.event(fault=pb.Fault(code=pb.FAULT_FOLLOWING_ERROR, axis=2, sentence=sentence))

    _, transport = connect(on_tick=fail)
    with pytest.raises(InstrumentFault) as caught:
        run(transport, Program(steps=[path(1, 2000)]))
    assert str(caught.value) == sentence


def test_expired_path_says_how_to_go_on(connect: Connect) -> None:
    def expire(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(path=pb.PathState(path_id=1, end=pb.PATH_EXPIRED))

    _, transport = connect(on_tick=expire)
    with pytest.raises(InstrumentFault, match="--resume"):
        run(transport, Program(steps=[path(1, 2000)]))


def test_refused_knot_is_named(connect: Connect) -> None:
    """The firmware complains in its log and stops the path: that is a fault with its words, not somebody's stop."""

    def refuse(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(log=pb.Log(level=3, text="axis 3, knot 7: velocity 50000 counts/s is over the limit"))
            fake.event(path=pb.PathState(path_id=1, end=pb.PATH_STOPPED))

    _, transport = connect(on_tick=refuse)
    with pytest.raises(InstrumentFault, match="knot 7"):
        run(transport, Program(steps=[path(1, 2000)]))


def test_stop_from_a_visitor(connect: Connect) -> None:
    def stop(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(path=pb.PathState(path_id=1, end=pb.PATH_STOPPED))

    _, transport = connect(on_tick=stop)
    with pytest.raises(ScanStopped, match="another program"):
        run(transport, Program(steps=[path(1, 2000)]))


def test_stop_from_a_visitor_counts_while_nothing_moves(connect: Connect) -> None:
    """In a dark, at a prompt, between paths: the firmware says that a visitor asked, and the scan ends."""

    def stop(fake: FakeFirmware, tick: int) -> None:
        if tick == 3:
            fake.event(stop=pb.Stop(reason="gonio stop"))

    _, transport = connect(on_tick=stop)
    interrupt, client = Interrupt(), Client(transport)
    client.before_receive = interrupt.check
    client.on_event = lambda event: stop_from_elsewhere(event, interrupt)
    with pytest.raises(ScanStopped, match="gonio stop"):
        client.wait_until(lambda: False, 10_000_000_000, "a dark")


def test_interrupt_stops_between_frames_and_closes_the_shutter(connect: Connect) -> None:
    fake, transport = connect()
    fake.status.shutter_open = True
    interrupt = Interrupt()
    client = Client(transport)
    client.before_receive = interrupt.check
    session = Session(client, REFERENCE)
    session.status()
    interrupt.reason = "Ctrl-C"
    with pytest.raises(ScanStopped) as caught:
        client.request(get_info=pb.GetInfo())
    assert caught.value.exit_status == 130
    session.stop("Ctrl-C")
    assert [r.stop.reason for r in fake.requests if r.HasField("stop")] == ["Ctrl-C"]
    assert not fake.status.shutter_open


def test_path_that_never_ends_is_given_up(connect: Connect) -> None:
    def ignore(_: FakeFirmware, request: pb.Request) -> pb.Reply | None:
        refused = request.HasField("motion_begin")
        return pb.Reply(code=pb.REPLY_ACCEPTED) if refused else None

    _, transport = connect(on_request=ignore, ticks=1000)
    with pytest.raises(InstrumentFault, match="path coarse 1: not done after"):
        run(transport, Program(steps=[path(1, 4)]))
