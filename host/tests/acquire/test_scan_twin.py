"""test_scan_twin.py: gonio scan against the twin when something happens to it: stops, kills, faults, resumes."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from twin_runs import SCENARIOS, journal, path_ends, run, run_until, wait_for_end, write_inputs

from gonio.acquire.resume import measured
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import RawLog, read_rawlog
from gonio.rawlog.segment_reader import read_segment
from gonio.rawlog.segments import existing_segments
from gonio.reduce.pipeline import reduce_rawlog
from gonio.units.instrument import load_instrument

pytestmark = pytest.mark.twin
REFERENCE = load_instrument(None)
EXPIRY_S = REFERENCE.cycle.expiry_ms * 1e-3


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole scan, undisturbed."""
    folder = tmp_path_factory.mktemp("unbroken")
    plan, device = write_inputs(folder)
    status, out, err = run(folder, "scan", plan, "-o", folder / "raw.mcap", "--device", device)
    assert (status, err) == (0, "")
    assert out.strip() == str(folder / "raw.mcap")
    return folder / "raw.mcap"


def measured_positions(log: RawLog) -> np.ndarray:
    """Axis counts (n, 4) of all poses while a measuring path was under way."""
    moves = {path["path_id"] for path in log.metadata["paths"] if path["kind"] == "move"}
    parts = []
    for index in range(len(log.segments)):
        poses = log.poses[log.pose_segment == index]
        begun: int | None = None
        for event, segment in zip(log.events, log.event_segment, strict=True):
            if segment != index or not event.HasField("path") or event.path.path_id in moves:
                continue
            if event.path.end == pb.PATH_RUNNING:
                begun = event.time_ns
            elif begun is not None:
                inside = (poses["sync_time_ns"] >= begun) & (poses["sync_time_ns"] <= event.time_ns)
                parts.append(poses["position_counts"][inside])
                begun = None
        if begun is not None:
            parts.append(poses["position_counts"][poses["sync_time_ns"] >= begun])
    return np.concatenate(parts)


def assert_same_directions(joined: RawLog, whole: RawLog) -> None:
    """Every position of the unbroken scan has one of the joined scan beside it, within the way of one SYNC at the axes'
    speed limit."""
    tolerance_counts = 30.0 * REFERENCE.cycle.sync_period_us * 1e-6 * REFERENCE.axes[0].counts_per_deg
    distance, _ = cKDTree(measured_positions(joined)).query(measured_positions(whole))
    assert distance.max() <= tolerance_counts


def mean_bsdf(log: RawLog) -> tuple[float, float]:
    """Mean and standard error of the tile's BSDF [1/sr]; it is Lambertian, so all directions have the same."""
    (distribution,) = reduce_rawlog(log).distributions
    good = distribution.measured & (distribution.theta_deg < 80.0)
    values = distribution.dsf_per_sr[good] / np.cos(np.radians(distribution.theta_deg[good]))
    return float(values.mean()), float(values.std() / np.sqrt(len(values)))


def assert_same_values(joined: RawLog, whole: RawLog) -> None:
    """The means agree within their noise (five standard errors)."""
    (ours, ours_u), (theirs, theirs_u) = mean_bsdf(joined), mean_bsdf(whole)
    assert abs(ours - theirs) <= 5.0 * np.hypot(ours_u, theirs_u)
    assert ours == pytest.approx(0.5 / np.pi, rel=0.02)  # the tile; a free beam at so coarse a pitch gives no more


def assert_ended_within_expiry(account: dict[str, Any]) -> None:
    """From full motion to standstill and darkness, expiry_ms after the host was lost at the latest, and for good."""
    lost = account["host_lost"]
    assert lost["max_speed_deg_per_s"] > 1.0
    assert lost["standstill_after_s"] <= EXPIRY_S
    assert lost["dark_after_s"] <= EXPIRY_S
    assert lost["max_speed_after_standstill_deg_per_s"] < 0.05
    assert account["at_rest"]
    assert not account["shutter_open"]


def resume(folder: Path, plan: Path, device: str, log: Path) -> RawLog:
    status, _, err = run(folder, "scan", plan, "-o", log, "--device", device, "--resume")
    assert (status, err) == (0, "")
    return read_rawlog(existing_segments(log))


def test_unbroken_scan_is_whole(unbroken: Path) -> None:
    log = read_rawlog([unbroken])
    assert log.problem is None
    assert log.segments[0].link_gap_frames == 0
    info = log.segments[0].info
    assert info is not None
    assert [node.device_type for node in info.nodes] == [0x00040192] * 4  # asked after boot: servo drives, CiA 402
    kinds = {path["path_id"]: path["kind"] for path in log.metadata["paths"]}
    assert measured(log.segments[0]).done == set(kinds)
    assert set(kinds.values()) == {"move", "reference", "coarse", "peak"}
    assert np.all(np.diff(log.sample_number.astype(np.int64)) == 1)
    assert np.all(np.diff(log.poses["sync_number"].astype(np.int64)) == 1)


def test_nothing_is_left_to_resume(unbroken: Path) -> None:
    folder = unbroken.parent
    arguments = ("scan", folder / "plan.toml", "-o", unbroken, "--device", f"twin:{folder / 'scenario.toml'}")
    status, _, err = run(folder, *arguments, "--resume")
    assert status == 2
    assert "complete" in err
    status, _, err = run(folder, *arguments)
    assert status == 2
    assert "never overwritten" in err
    assert existing_segments(unbroken) == [unbroken]


def test_same_seed_gives_the_same_bytes(unbroken: Path, tmp_path: Path) -> None:
    """Every sample and pose frame, byte for byte, however the two runs were scheduled."""
    plan, device = write_inputs(tmp_path)
    assert run(tmp_path, "scan", plan, "-o", tmp_path / "raw.mcap", "--device", device)[0] == 0
    first, second = read_segment(unbroken), read_segment(tmp_path / "raw.mcap")
    assert [bytes(p) for p in first.sample_payloads] == [bytes(p) for p in second.sample_payloads]
    assert [bytes(p) for p in first.pose_payloads] == [bytes(p) for p in second.pose_payloads]
    assert first.events == second.events


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_stops_on_the_path_and_resume_goes_on(unbroken: Path, tmp_path: Path, number: signal.Signals) -> None:
    plan, device = write_inputs(tmp_path)
    log, end = tmp_path / "raw.mcap", tmp_path / "journal.json"
    arguments = ("scan", plan, "-o", log, "--device", device, "--twin-journal", end)
    status, _, err = run_until(tmp_path, "coarse", 2.0, number.name, *arguments)
    assert status == 130
    assert err.count("\n") == 1
    assert "--resume" in err
    segment = read_segment(log)
    assert segment.complete
    assert path_ends(segment)[-1] == pb.PATH_STOPPED
    assert journal(end)["at_rest"]
    assert not journal(end)["shutter_open"]
    assert measured(segment).partial is not None
    joined = resume(tmp_path, plan, device, log)
    assert [part.metadata["parent"] for part in joined.segments] == [None, "raw.mcap"]
    assert_same_directions(joined, read_rawlog([unbroken]))


def test_killed_host(unbroken: Path, tmp_path: Path) -> None:
    """SIGKILL: within the expiry the arm stands on its path and the shutter is shut; all blocks are readable."""
    plan, device = write_inputs(tmp_path)
    log, end = tmp_path / "raw.mcap", tmp_path / "journal.json"
    arguments = ("scan", plan, "-o", log, "--device", device, "--twin-journal", end)
    status, out, _ = run_until(tmp_path, "coarse", 3.0, "SIGKILL", *arguments)
    assert status == -signal.SIGKILL
    wait_for_end(int(out))
    assert_ended_within_expiry(journal(end))
    segment = read_segment(log)
    assert not segment.complete
    assert not segment.damaged
    assert len(segment.sample_payloads) > 10
    joined = resume(tmp_path, plan, device, log)
    assert joined.problem is None
    assert_same_directions(joined, read_rawlog([unbroken]))
    assert_same_values(joined, read_rawlog([unbroken]))


def test_stop_from_another_process(tmp_path: Path) -> None:
    plan, device = write_inputs(tmp_path)
    log = tmp_path / "raw.mcap"
    status, out, err = run_until(tmp_path, "reference", 0.5, "stop", "scan", plan, "-o", log, "--device", device)
    assert status == 130
    assert f"stops {device}" in out  # said by the other process
    assert "gonio stop" in err
    assert path_ends(read_segment(log))[-1] == pb.PATH_STOPPED


def test_resumed_twice(unbroken: Path, tmp_path: Path) -> None:
    plan, device = write_inputs(tmp_path)
    log = tmp_path / "raw.mcap"
    arguments = ["scan", plan, "-o", log, "--device", device]
    for kind, extra in (("reference", []), ("coarse", ["--resume"])):
        assert run_until(tmp_path, kind, 1.0, "SIGINT", *arguments, *extra)[0] == 130
    joined = resume(tmp_path, plan, device, log)
    assert len(joined.segments) == 3
    assert_same_directions(joined, read_rawlog([unbroken]))


def test_resume_with_another_plan_is_refused(unbroken: Path, tmp_path: Path) -> None:
    plan, device = write_inputs(tmp_path)
    plan.write_text(plan.read_text().replace("pitch_deg = 12.0", "pitch_deg = 10.0"))
    status, _, err = run(tmp_path, "scan", plan, "-o", unbroken, "--device", device, "--resume")
    assert status == 2
    assert "another plan" in err


@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        ("fault_node_missing", ["node 3"]),
        ("fault_node_silent", ["node 3", "heartbeat"]),
        ("fault_emcy", ["node 2", "0x4310", "commanded", "measured"]),
        ("fault_blocked", ["node 3", "following error", "commanded", "measured"]),
        ("fault_sto", ["STO"]),
        ("fault_door", ["door"]),
        ("fault_emergency_stop", ["emergency stop"]),
    ],
)
def test_fault_is_status_3_and_one_sentence(tmp_path: Path, scenario: str, words: list[str]) -> None:
    plan, _ = write_inputs(tmp_path)
    log, end = tmp_path / "raw.mcap", tmp_path / "journal.json"
    device = f"twin:{SCENARIOS / scenario}.toml"
    status, _, err = run(tmp_path, "scan", plan, "-o", log, "--device", device, "--twin-journal", end)
    assert status == 3, err
    assert err.count("\n") == 1
    for word in words:
        assert word.lower() in err.lower()
    segment = read_segment(log)
    assert segment.problem is None
    faults = [event.fault for event in segment.events if event.HasField("fault")]
    assert faults
    assert faults[0].sentence in err
    last = [event.status for event in segment.events if event.HasField("status")][-1]
    assert last.state == pb.STATE_FAULT or last.position_known_mask != 0b1111
    assert journal(end)["at_rest"]
    assert not journal(end)["shutter_open"]


def test_hung_host_is_stopped_by_the_expiry(tmp_path: Path) -> None:
    """The scripted hung host: the path expires, the arm stands, the scan says so."""
    plan, _ = write_inputs(tmp_path)
    end = tmp_path / "journal.json"
    device = f"twin:{SCENARIOS / 'fault_host_silent.toml'}"
    status, _, err = run(tmp_path, "scan", plan, "-o", tmp_path / "raw.mcap", "--device", device, "--twin-journal", end)
    assert status == 3, err
    assert err.count("\n") == 1
    assert_ended_within_expiry(journal(end))


def test_info_and_home(tmp_path: Path) -> None:
    _, device = write_inputs(tmp_path)
    status, out, _ = run(tmp_path, "info", "--device", device, "--json")
    assert status == 0
    assert '"state": "unconfigured"' in out
    status, out, err = run(tmp_path, "home", "--device", device)
    assert (status, err) == (0, "")
    assert out.count(" deg\n") == 4
    assert os.listdir(tmp_path / "gonio") == []


def test_stop_before_anything_moves(tmp_path: Path) -> None:
    """A scan is reachable from its first moment: the stop waits in the control socket until it is heard."""
    plan, device = write_inputs(tmp_path)
    sockets = tmp_path / "gonio"
    log = tmp_path / "raw.mcap"
    command = [sys.executable, "-m", "gonio.cli.main", "scan", plan, "-o", log, "--device", device]
    environment = os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)}
    with subprocess.Popen(list(map(str, command)), env=environment, stderr=subprocess.PIPE, text=True) as scanning:
        while not list(sockets.glob("*.sock")):
            assert scanning.poll() is None
        status, out, _ = run(tmp_path, "stop")
        _, err = scanning.communicate(timeout=60)
    assert status == 0
    assert "stops" in out
    assert scanning.returncode == 130
    assert "gonio stop" in err
