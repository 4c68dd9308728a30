"""test_rawlog.py: what the writer wrote comes back; other MCAP readers can open it; nothing is overwritten."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from small_log import METADATA, frames, pose_payload, sample_payload, write_log

from gonio.protocol.generated import records
from gonio.rawlog.decode import decode_pose_blocks, decode_sample_blocks
from gonio.rawlog.layout import pack_metadata, unpack_metadata
from gonio.rawlog.reader import read_rawlog
from gonio.rawlog.segments import existing_segments, segment_path
from gonio.units.errors import UsageError


def test_there_and_back(tmp_path: Path) -> None:
    log = read_rawlog([write_log(tmp_path / "raw.mcap", blocks=3)])
    assert log.metadata == METADATA | {"paths": []}
    assert log.complete
    assert log.sample_number.tolist() == list(range(12))
    assert log.samples["high_counts"].tolist() == list(range(12))
    assert np.diff(log.sample_time_ns).tolist() == [1_000_000] * 11
    assert log.time_origin_ns.tolist() == [5_000_000_000]
    assert log.sample_settled.all()
    assert log.poses["sync_number"].tolist() == list(range(1, 10))
    assert [event.log.text for event in log.events] == ["block 0", "block 1", "block 2"]
    assert log.sample_blocks["block"].tolist() == [0, 1, 2]
    assert [request.WhichOneof("body") for request in log.segments[0].requests] == ["get_info"]


def test_mcaps_own_reader_opens_it(tmp_path: Path) -> None:
    """An independent reader sees the topics, and in the messages the frames as they came."""
    path = write_log(tmp_path / "raw.mcap", blocks=2)
    with path.open("rb") as file:
        rows = [(channel.topic, message.data) for _, channel, message in make_reader(file).iter_messages()]
    assert rows[0][0] == "/meta"
    assert [data for topic, data in rows if topic not in ("/meta", "/requests")] == frames(2)
    assert [topic for topic, _ in rows[2:5]] == ["/events", "/samples", "/poses"]


def test_existing_file_is_never_touched(tmp_path: Path) -> None:
    path = tmp_path / "raw.mcap"
    path.write_text("precious")
    with pytest.raises(UsageError, match="never overwritten"):
        write_log(path)
    assert path.read_text() == "precious"


def test_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be made"):
        write_log(tmp_path / "none" / "raw.mcap")


def test_segments_are_joined(tmp_path: Path) -> None:
    first = tmp_path / "raw.mcap"
    write_log(first, blocks=2, finish=False)
    write_log(segment_path(first, 2), blocks=1)
    paths = existing_segments(first)
    assert [path.name for path in paths] == ["raw.mcap", "raw.2.mcap"]
    log = read_rawlog(paths)
    assert log.sample_segment.tolist() == [0] * 8 + [1] * 4
    assert log.pose_segment.tolist() == [0] * 6 + [1] * 3
    assert log.event_segment == [0, 0, 1]
    assert log.complete  # the first was resumed
    assert len(set(log.sha256s)) == 2


def test_segments_of_other_scans_are_refused(tmp_path: Path) -> None:
    first = write_log(tmp_path / "raw.mcap")
    other = write_log(tmp_path / "other.mcap", metadata=METADATA | {"plan_sha256": "cc"})
    with pytest.raises(UsageError, match="of another scan"):
        read_rawlog([first, other])


def test_log_without_a_block(tmp_path: Path) -> None:
    log = read_rawlog([write_log(tmp_path / "raw.mcap", blocks=0)])
    assert len(log.samples) == len(log.poses) == 0
    assert log.samples.dtype == records.SAMPLE_DTYPE
    assert log.time_origin_ns.tolist() == [0]


def test_name_of_a_raw_log() -> None:
    with pytest.raises(UsageError, match=r"ends in \.mcap"):
        segment_path(Path("raw.h5"), 1)


@given(st.lists(st.tuples(st.integers(0, 7), st.booleans()), max_size=12))
def test_blocks_of_any_sizes(shapes: list[tuple[int, bool]]) -> None:
    """Against a plain loop: sizes that change, empty blocks, unsettled ones."""
    payloads = [
        sample_payload(number, count=count, window=200 if settled else 0, flags=0 if settled else 1)
        for number, (count, settled) in enumerate(shapes)
    ]
    decoded = decode_sample_blocks(payloads)
    numbers = [number * count + k for number, (count, _) in enumerate(shapes) for k in range(count)]
    assert decoded.number.tolist() == numbers
    assert decoded.samples["high_counts"].tolist() == numbers
    assert decoded.time_ns.tolist() == [5_000_000_000 + number * 1_000_000 for number in numbers]
    assert decoded.settled.tolist() == [settled for count, settled in shapes for _ in range(count)]


def test_poses_of_any_sizes() -> None:
    decoded = decode_pose_blocks([pose_payload(0, count=2), pose_payload(0, count=0), pose_payload(1, count=5)])
    assert decoded["sync_number"].tolist() == [1, 2, 6, 7, 8, 9, 10]


@given(st.dictionaries(st.text(), st.one_of(st.none(), st.floats(allow_nan=False, allow_infinity=False), st.text())))
def test_metadata_there_and_back(metadata: dict[str, object]) -> None:
    assert unpack_metadata(pack_metadata(metadata)) == metadata


def test_paths_of_all_segments(tmp_path: Path) -> None:
    first = tmp_path / "raw.mcap"
    write_log(first, metadata=METADATA | {"paths": [{"path_id": 1, "kind": "coarse"}]})
    write_log(segment_path(first, 2), metadata=METADATA | {"paths": [{"path_id": 1, "kind": "coarse"}, {"path_id": 7}]})
    assert [path["path_id"] for path in read_rawlog(existing_segments(first)).metadata["paths"]] == [1, 7]
