"""test_blocks.py: packed payloads against bytes made with struct from records.toml."""

import struct

import numpy as np
import pytest

from gonio.protocol.blocks import BlockError, knot_block, knot_payload, pose_block, sample_block
from gonio.protocol.generated import records

SAMPLE_HEADER = "<QqdIIIIfIII"
POSE = "<qIiiiiBBH"


def test_sample_block_is_read_in_place() -> None:
    header = struct.pack(SAMPLE_HEADER, 2**40, -5, 1e6, 3, 2, 7, 8, 12.5, 200, 6, 0)
    samples = struct.pack("<iiihH", -1, 2, 3, -250, 1) + struct.pack("<iiihH", 4, 5, 6, 2150, 0)
    head, view = sample_block(header + samples)
    assert (int(head["first_sample"]), int(head["first_time_ns"]), float(head["period_ns"])) == (2**40, -5, 1e6)
    assert (int(head["samples_lost"]), int(head["strobes_lost"]), int(head["flags"])) == (7, 8, 6)
    assert view["high_counts"].tolist() == [-1, 4]
    assert view["temperature_centi_c"].tolist() == [-250, 2150]
    assert view.base is not None  # no copy


def test_pose_block_is_read_in_place() -> None:
    payload = struct.pack("<IIII", 1, 1, 4, 0) + struct.pack(POSE, 123, 9, -1, 2, -3, 4, 0b1011, 4, 0)
    head, view = pose_block(payload)
    assert int(head["axis_count"]) == 4
    assert view["position_counts"].tolist() == [[-1, 2, -3, 4]]
    assert int(view["valid"][0]) == 0b1011


@pytest.mark.parametrize("change", [-1, 1])
def test_size_must_fit_the_count(change: int) -> None:
    payload = struct.pack("<IIII", 1, 1, 4, 0) + bytes(32)
    damaged = payload[:change] if change < 0 else payload + b"\0"
    with pytest.raises(BlockError):
        pose_block(damaged)
    with pytest.raises(BlockError):
        sample_block(b"short")


def test_knots_there_and_back() -> None:
    knots = np.zeros(3, records.KNOT_DTYPE)
    knots["time_ns"] = [0, 10, 20]
    knots["position_counts"] = np.arange(12.0).reshape(3, 4)
    payload = knot_payload(5, 100, knots)
    assert len(payload) == 16 + 3 * 104
    assert struct.unpack_from("<IIII", payload) == (5, 100, 3, 0)
    head, view = knot_block(payload)
    assert int(head["path_id"]) == 5
    np.testing.assert_array_equal(view, knots)
