"""test_rawlog_damage.py: cut at every byte, flipped at any bit: what is read is what was written, or it is said."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_log import METADATA, write_log

from gonio.rawlog.segment_reader import Segment, parse_segment, read_segment
from gonio.units.errors import UsageError


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_log(tmp_path_factory.mktemp("log") / "raw.mcap", blocks=2).read_bytes()


def messages_area(data: bytes) -> range:
    """From the first message's opcode to the end of the last message's data."""
    start = data.index(b'{"crc32c"') - 31
    end = data.index(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00", start)
    return range(start, end)


def contents(segment: Segment) -> list[list[bytes]]:
    return [
        [bytes(payload) for payload in segment.sample_payloads],
        [bytes(payload) for payload in segment.pose_payloads],
        [event.SerializeToString() for event in segment.events],
        [request.SerializeToString() for request in segment.requests],
    ]


def check(data: bytes, original: Segment) -> Segment | None:
    """Read damaged data: everything in it is a beginning of what was written; None when refused in one line."""
    try:
        segment = parse_segment(Path("raw.mcap"), data)
    except UsageError:
        return None
    assert segment.metadata == METADATA
    for got, written in zip(contents(segment), contents(original), strict=True):
        assert got == written[: len(got)]
    if segment.problem is None:
        assert segment.complete
        assert contents(segment) == contents(original)
        assert segment.link_gap_frames == original.link_gap_frames
    else:
        assert not segment.complete
        assert "\n" not in segment.problem
    return segment


def test_cut_at_every_byte(whole: bytes) -> None:
    original = parse_segment(Path("raw.mcap"), whole)
    assert original.problem is None
    seen = 0
    for size in range(len(whole)):
        segment = check(whole[:size], original)
        assert segment is None or not segment.complete
        messages = 0 if segment is None else segment.messages
        assert messages >= seen  # never less of a longer file
        seen = messages
    assert seen == original.messages


def test_every_flipped_bit_among_the_messages(whole: bytes) -> None:
    original = parse_segment(Path("raw.mcap"), whole)
    found = 0
    area = messages_area(whole)
    for position in area:
        for bit in range(8):
            data = bytearray(whole)
            data[position] ^= 1 << bit
            segment = check(bytes(data), original)
            found += segment is None or segment.problem is not None
    harmless = 8 * len(area) - found
    # MCAP's own channel number and two times of each message (18 bytes) are all that nothing depends on.
    assert harmless == original.messages * 18 * 8


@given(st.data())
def test_flipped_bit_anywhere_and_many(whole: bytes, data: st.DataObject) -> None:
    original = parse_segment(Path("raw.mcap"), whole)
    damaged = bytearray(whole)
    for position in data.draw(st.lists(st.integers(0, len(whole) - 1), min_size=1, max_size=5, unique=True)):
        damaged[position] ^= data.draw(st.integers(1, 255))
    check(bytes(damaged), original)


@given(st.data())
def test_a_lost_piece_is_found(whole: bytes, data: st.DataObject) -> None:
    original = parse_segment(Path("raw.mcap"), whole)
    area = messages_area(whole)
    start = data.draw(st.integers(area.start, area.stop - 1))
    end = data.draw(st.integers(start + 1, area.stop))
    segment = check(whole[:start] + whole[end:], original)
    assert segment is None or segment.problem is not None


def test_killed_writer_leaves_all_blocks(tmp_path: Path) -> None:
    segment = read_segment(write_log(tmp_path / "raw.mcap", blocks=5, finish=False))
    assert len(segment.sample_payloads) == 5
    assert not segment.complete
    assert not segment.damaged
    assert segment.problem is not None
    assert "5 sample blocks" in segment.problem


@pytest.mark.parametrize("content", [b"", b"\x89MCA", b"PK\x03\x04" + bytes(100), b"<?xml version='1.0'?>"])
def test_foreign_files(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(UsageError, match="not a raw log"):
        read_segment(path)


def test_mcap_of_another_program(tmp_path: Path) -> None:
    from mcap.writer import Writer  # noqa: PLC0415 - only this test writes by hand

    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="x")
        writer.finish()
    with pytest.raises(UsageError, match="not a raw log of gonio"):
        read_segment(path)


def test_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No such file"):
        read_segment(tmp_path / "none.mcap")
