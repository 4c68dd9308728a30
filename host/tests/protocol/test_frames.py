"""test_frames.py: frames against the written format, the golden vectors and every way of being damaged."""

import struct

import google_crc32c
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gonio.protocol.frames import (
    HEADER_SIZE,
    MAX_PAYLOAD,
    FrameDecoder,
    FrameError,
    FrameProblem,
    decode_frame,
    encode_frame,
)

frames = st.lists(
    st.tuples(st.integers(1, 9), st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.binary(max_size=300)),
    min_size=1,
    max_size=8,
)


def test_header_is_that_of_records_toml() -> None:
    """Built by hand from records.toml: fields in order, CRC over the first 16 bytes and the payload."""
    head = struct.pack("<HBBIII", 0x4E47, 1, 4, 7, 3, 2)
    crc = struct.pack("<I", google_crc32c.value(head + b"ab"))
    assert encode_frame(4, 7, 3, b"ab") == head + crc + b"ab"


def test_crc_is_castagnoli() -> None:
    """The check value of CRC-32C for "123456789" (RFC 3720, B.4)."""
    assert google_crc32c.value(b"123456789") == 0xE3069283


@given(frames, st.data())
def test_any_cut_gives_the_same_frames(sent: list[tuple[int, int, int, bytes]], data: st.DataObject) -> None:
    stream = b"".join(encode_frame(*frame) for frame in sent)
    decoder = FrameDecoder()
    received = []
    start = 0
    while start < len(stream):
        size = data.draw(st.integers(1, len(stream) - start))
        received += decoder.feed(stream[start : start + size])
        start += size
    assert [(f.kind, f.sequence, f.acknowledged, bytes(f.payload)) for f in received] == sent
    assert b"".join(f.raw for f in received) == stream


@given(st.binary(max_size=40), st.integers(0, 2**32 - 1), st.data())
def test_every_flipped_bit_is_found(payload: bytes, sequence: int, data: st.DataObject) -> None:
    """A flipped bit raises or, in the length, leaves the frame incomplete; it never gives a frame."""
    stream = bytearray(encode_frame(5, sequence, 1, payload))
    bit = data.draw(st.integers(0, len(stream) * 8 - 1))
    stream[bit // 8] ^= 1 << (bit % 8)
    try:
        assert decode_frame(bytes(stream)) is None
    except FrameError:
        pass
    else:
        assert 12 <= bit // 8 < 16  # only a longer length may wait for more


@pytest.mark.parametrize(
    ("position", "value", "problem"),
    [
        (0, b"XX", FrameProblem.MAGIC),
        (2, b"\x02", FrameProblem.VERSION),
        (12, struct.pack("<I", MAX_PAYLOAD + 1), FrameProblem.LENGTH),
        (HEADER_SIZE, b"\xff", FrameProblem.CRC),
    ],
)
def test_problem_is_named(position: int, value: bytes, problem: FrameProblem) -> None:
    stream = bytearray(encode_frame(4, 1, 0, b"payload"))
    stream[position : position + len(value)] = value
    with pytest.raises(FrameError) as caught:
        FrameDecoder().feed(bytes(stream))
    assert caught.value.problem is problem
    assert "\n" not in str(caught.value)


def test_unknown_kind_is_refused() -> None:
    with pytest.raises(FrameError) as caught:
        FrameDecoder().feed(encode_frame(10, 1, 0))
    assert caught.value.problem is FrameProblem.KIND


def test_longest_payload_passes_and_a_longer_one_is_refused() -> None:
    assert len(FrameDecoder().feed(encode_frame(5, 1, 0, bytes(MAX_PAYLOAD)))) == 1
    with pytest.raises(ValueError, match="65537"):
        encode_frame(5, 1, 0, bytes(MAX_PAYLOAD + 1))
