"""test_resume.py: what an interrupted log is held to have: never more than samples and poses reach."""

import hashlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_log import pose_payload, sample_payload

from gonio.acquire.resume import EDGE_NS, Measured, check_same_scan, covered_until_ns, digest, measured
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.segment_reader import Segment
from gonio.units.errors import UsageError

START_NS = 5_000_000_000  # of small_log's first sample and pose
PATHS = [{"path_id": 1, "kind": "move"}, {"path_id": 2, "kind": "coarse"}, {"path_id": 3, "kind": "peak"}]
MS = 1_000_000


def segment(events: list[pb.Event], *, seconds: float = 10.0, pose_seconds: float | None = None) -> Segment:
    """A segment whose samples (1 ms apart) and poses (2 ms apart) reach so far; only the last blocks are looked at."""
    samples = round(seconds * 1000)
    poses = round((seconds if pose_seconds is None else pose_seconds) * 500)
    return Segment(
        Path("raw.mcap"),
        "",
        {"paths": PATHS, "plan_sha256": "p", "instrument_sha256": "i"},
        [memoryview(sample_payload(samples - 1, count=1))] if samples else [],
        [memoryview(pose_payload(poses, count=1))] if poses else [],
        events,
    )


def path_event(at_ms: int, path_id: int, end: int, path_time_ms: int = 0) -> pb.Event:
    state = pb.PathState(path_id=path_id, end=end, path_time_ns=path_time_ms * MS)  # type: ignore[arg-type]
    return pb.Event(time_ns=START_NS + at_ms * MS, path=state)


def status_event(at_ms: int, path_id: int, path_time_ms: int) -> pb.Event:
    return pb.Event(time_ns=START_NS + at_ms * MS, status=pb.Status(path_id=path_id, path_time_ns=path_time_ms * MS))


def flight(path_id: int, begin_ms: int, last_ms: int) -> list[pb.Event]:
    """A path that runs, with a Status every 100 ms."""
    return [
        path_event(begin_ms, path_id, pb.PATH_RUNNING),
        *(status_event(at, path_id, at - begin_ms) for at in range(begin_ms + 100, last_ms + 1, 100)),
    ]


FLOWN = [*flight(1, 0, 900), path_event(1000, 1, pb.PATH_FINISHED, 1000), *flight(2, 1100, 4000)]


def test_coverage_is_the_lesser_of_samples_and_poses() -> None:
    assert covered_until_ns(segment([], seconds=10.0)) == START_NS + 10_000 * MS - EDGE_NS
    assert covered_until_ns(segment([], seconds=10.0, pose_seconds=4.0)) == START_NS + 4_000 * MS - EDGE_NS
    assert covered_until_ns(segment([], seconds=0.0)) == 0


def test_nothing_began() -> None:
    assert measured(segment([])) == Measured(frozenset(), None)
    assert measured(segment(FLOWN, seconds=0.0)) == Measured(frozenset(), None)


def test_stopped_on_the_path() -> None:
    events = [*FLOWN, path_event(4050, 2, pb.PATH_STOPPED, 2777)]
    assert measured(segment(events)) == Measured(frozenset({1}), (2, 2777 * MS))


@pytest.mark.parametrize("end", [pb.PATH_EXPIRED, pb.PATH_FAULT])
def test_expired_or_broken_off(end: int) -> None:
    assert measured(segment([*FLOWN, path_event(4050, 2, end, 2950)])).partial == (2, 2950 * MS)


def test_killed_host_goes_back_to_what_samples_reach() -> None:
    """Samples until 3.05 s: the Status at 3.0 s is the last that they cover, path time 1.9 s."""
    assert measured(segment(FLOWN, seconds=3.05)) == Measured(frozenset({1}), (2, 1900 * MS))


def test_end_that_samples_do_not_reach_is_no_end() -> None:
    events = [*FLOWN, path_event(4050, 2, pb.PATH_FINISHED, 2950)]
    assert measured(segment(events, seconds=4.06)).done == {1}
    assert measured(segment(events, seconds=4.06)).partial == (2, 2900 * MS)
    assert measured(segment(events, seconds=4.08)) == Measured(frozenset({1, 2}), None)


def test_move_is_made_again_whole() -> None:
    assert measured(segment(flight(1, 0, 800))) == Measured(frozenset(), None)


@given(st.floats(0.0, 12.0), st.floats(0.0, 12.0))
def test_never_more_than_is_there(seconds: float, pose_seconds: float) -> None:
    """Killed at any moment: the partial path's end, in controller time, has samples and poses beyond it."""
    events = [*FLOWN, path_event(4050, 2, pb.PATH_FINISHED, 2950), *flight(3, 4200, 9000)]
    part = measured(segment(events, seconds=seconds, pose_seconds=pose_seconds))
    begin_ms = {2: 1100, 3: 4200}
    reached_ms = min(round(seconds * 1000), round(pose_seconds * 500) * 2)
    if part.partial:
        path_id, path_time_ns = part.partial
        assert begin_ms[path_id] + path_time_ns // MS + EDGE_NS // MS <= reached_ms
        assert path_id not in part.done
    if 2 in part.done:
        assert reached_ms >= 4050


def test_other_plan_instrument_or_damage_is_refused() -> None:
    good = segment([])
    check_same_scan([good], "p", "i", Path("plan.toml"))
    with pytest.raises(UsageError, match=r"another plan plan\.toml"):
        check_same_scan([good], "q", "i", Path("plan.toml"))
    with pytest.raises(UsageError, match="another instrument file"):
        check_same_scan([good], "p", "j", Path("plan.toml"))
    good.damaged, good.problem = True, "raw.mcap: a damaged link frame"
    with pytest.raises(UsageError, match="cannot be resumed"):
        check_same_scan([good], "p", "i", Path("plan.toml"))


def test_digest_is_sha256() -> None:
    assert digest("abc") == digest(b"abc") == hashlib.sha256(b"abc").hexdigest()
