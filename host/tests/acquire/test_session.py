"""test_session.py: what the firmware is told about the reference instrument, in counts."""

import pytest
from fake_firmware import Connect, FakeFirmware

from gonio.acquire.session import Session, axis_message, configure_message, homing_timeout_ms, zone_messages
from gonio.link.client import Client
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.errors import InstrumentFault
from gonio.units.instrument import load_instrument, parse_instrument

REFERENCE = load_instrument(None)
PER_DEG = 400_000 / 360


def test_axis_in_counts() -> None:
    message = axis_message(2, REFERENCE.axes[2])
    assert (message.axis, message.node, message.name) == (2, 3, "arm azimuth")
    assert message.min_counts == pytest.approx(-200 * PER_DEG)
    assert message.max_counts == pytest.approx(200 * PER_DEG)
    assert message.home_offset_counts == round(REFERENCE.axes[2].homing.switch_deg * PER_DEG)
    assert message.homing_fast_counts_per_s == round(10 * PER_DEG)
    assert message.following_error_counts == round(0.5 * PER_DEG)
    assert 30 * PER_DEG < message.max_velocity_counts_per_s < 1.1 * 30 * PER_DEG
    assert homing_timeout_ms(REFERENCE.axes[2]) > 1000 * 402 / 10


def test_axis_that_counts_backwards() -> None:
    """Limits stay in order, speeds positive; only positions change their sign."""
    text = REFERENCE.text.replace("counts_per_deg = [10000, 9]", "counts_per_deg = [-10000, 9]", 1)
    message = axis_message(0, parse_instrument(text, "x").axes[0])
    assert message.min_counts == pytest.approx(-185 * PER_DEG)
    assert message.max_counts == pytest.approx(5 * PER_DEG)
    assert message.max_velocity_counts_per_s > 0
    assert message.home_offset_counts == round(-REFERENCE.axes[0].homing.switch_deg * PER_DEG)


def test_zone_holds_in_counts_where_it_holds_in_degrees() -> None:
    """A pose on each side of every face: the inequality in counts must agree with the one in degrees."""
    for zone, message in zip(REFERENCE.zones, zone_messages(REFERENCE), strict=True):
        for line, sent in zip(zone.half_spaces, message.half_spaces, strict=True):
            for q_deg in ((0, 0, 149, -77), (0, 0, 151, -79), (0, 0, -151, -79), (0, 0, -149, -77)):
                in_degrees = sum(a * q for a, q in zip(line.a, q_deg, strict=True)) <= line.b
                in_counts = sum(a * q * PER_DEG for a, q in zip(sent.a, q_deg, strict=True)) <= sent.b
                assert in_degrees == in_counts


def test_every_setting_of_the_cycle_is_sent() -> None:
    message = configure_message(REFERENCE)
    assert message.axis_count == 4
    for field in message.DESCRIPTOR.fields:
        if field.name != "axis_count":
            assert getattr(message, field.name) == getattr(REFERENCE.cycle, field.name)


def power_up(fake: FakeFirmware, request: pb.Request) -> pb.Reply | None:
    """A script that changes the state as the firmware does."""
    body = request.WhichOneof("body")
    if body == "clear_fault":
        fake.status.state = pb.STATE_UNCONFIGURED
    elif body == "configure" and fake.status.state == pb.STATE_UNCONFIGURED:
        fake.status.state = pb.STATE_CONFIGURED
    elif body == "boot":
        fake.status.state = pb.STATE_UNHOMED
    elif body == "home":
        fake.status.position_known_mask |= request.home.axis_mask
        fake.status.state = pb.STATE_READY
    return None


CONFIGURATION = ["configure", *["configure_axis"] * 4, *["configure_zone"] * 2]


@pytest.mark.parametrize(
    ("state", "known", "expected"),
    [
        (pb.STATE_UNCONFIGURED, 0, [*CONFIGURATION, "boot", "home"]),
        (pb.STATE_FAULT, 0, ["clear_fault", *CONFIGURATION, "boot", "home"]),
        (pb.STATE_UNHOMED, 0b0011, [*CONFIGURATION, "home"]),
        (pb.STATE_READY, 0b1111, CONFIGURATION),
    ],
)
def test_make_ready_from_any_state(
    connect: Connect, state: pb.InstrumentState, known: int, expected: list[str]
) -> None:
    fake, transport = connect(on_request=power_up)
    fake.status.state = state
    fake.status.position_known_mask = known
    with Client(transport) as client:
        Session(client, REFERENCE).make_ready()
    assert [request.WhichOneof("body") for request in fake.requests] == expected
    if "home" in expected:
        assert fake.requests[-1].home.axis_mask == 0b1111 & ~known
    assert fake.broken == []


def test_acquisition_of_an_earlier_session_is_ended(connect: Connect) -> None:
    fake, transport = connect(on_request=power_up)
    fake.status.acquiring = True
    with Client(transport) as client:
        Session(client, REFERENCE).make_ready()
    assert fake.requests[0].WhichOneof("body") == "acquire"
    assert not fake.requests[0].acquire.on


def test_axis_set_by_hand_is_refused(connect: Connect) -> None:
    _, transport = connect()
    by_hand = parse_instrument(REFERENCE.text.replace("driven = true", "driven = false", 1), "x")
    with Client(transport) as client, pytest.raises(InstrumentFault, match="sample azimuth is set by hand"):
        Session(client, by_hand).configure()


def test_clock_that_never_locks(connect: Connect) -> None:
    def keep_unlocked(fake: FakeFirmware, _tick: int) -> None:
        fake.status.clock_locked = False

    _, transport = connect(on_tick=keep_unlocked, ticks=1000)
    with Client(transport) as client, pytest.raises(InstrumentFault, match="sample clock"):
        Session(client, REFERENCE).acquire(True)
