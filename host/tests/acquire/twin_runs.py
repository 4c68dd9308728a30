"""twin_runs.py: the real command line against the real twin: plans, starting, watching a log as it grows."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.segment_reader import Segment, read_segment
from gonio.units.errors import UsageError

SCENARIOS = Path(__file__).resolve().parents[3] / "sim" / "scenarios"
QUIET = """
seed = 3
[sample]
components = [{ kind = "lambertian", reflectance = 0.5 }]
"""
PLAN = """
[sample]
name = "white tile"
front_faces = "exterior"
symmetry = "none"
thickness_mm = 3.0
manufacturer = "gonio"
[beam]
kind = "focused"
diameter_mm = 10.0
divergence_deg = 1.0
[scan]
speed_deg_per_s = 30.0
incident = [[30, 0]]
[reference]
radius_deg = 2.0
pitch_deg = 0.5
[coarse]
pitch_deg = 12.0
sphere = "front"
[[peak]]
about = "mirror"
radius_deg = 4.0
pitch_deg = 0.5
for_incident = "all"
[dark]
duration_s = 1.0
"""
GIVE_UP_S = 120.0


def write_inputs(folder: Path, scenario: str = QUIET) -> tuple[Path, str]:
    """Plan and scenario files: the plan, and the device name of its twin."""
    plan, twin = folder / "plan.toml", folder / "scenario.toml"
    plan.write_text(PLAN)
    twin.write_text(scenario)
    return plan, f"twin:{twin}"


def start(folder: Path, *arguments: str | Path) -> subprocess.Popen[str]:
    """Start gonio as a user does; its control socket is in `folder`."""
    return subprocess.Popen(
        [sys.executable, "-m", "gonio.cli.main", *map(str, arguments)],
        env=os.environ | {"XDG_RUNTIME_DIR": str(folder)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(folder: Path, *arguments: str | Path) -> tuple[int, str, str]:
    """Run gonio to its end: status, standard output, standard error."""
    process = start(folder, *arguments)
    out, err = process.communicate(timeout=GIVE_UP_S)
    return process.returncode, out, err


def watch(process: subprocess.Popen[str], log: Path, reached: Callable[[Segment], bool]) -> None:
    """Read the growing log until `reached`; the scan must not end before."""
    while process.poll() is None:
        try:
            if reached(read_segment(log)):
                return
        except UsageError:
            pass  # not there yet, or its metadata is not whole yet
    raise AssertionError(f"the scan ended too early: {process.communicate()}")


def flying(kind: str, path_time_s: float) -> Callable[[Segment], bool]:
    """Is a path of this kind on its way, so far at least?"""

    def reached(segment: Segment) -> bool:
        ids = {path["path_id"] for path in segment.metadata["paths"] if path["kind"] == kind}
        last = next((e.status for e in reversed(segment.events) if e.HasField("status")), pb.Status())
        return last.path_id in ids and last.path_time_ns >= path_time_s * 1e9

    return reached


def twin_of(process: subprocess.Popen[str]) -> int:
    """A pidfd of the twin that a scan started; readable once the twin has ended."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) == 1
    return os.pidfd_open(int(children[0]))


def wait_for_end(pidfd: int) -> None:
    """Wait for a process by its pidfd."""
    try:
        assert select.select([pidfd], [], [], GIVE_UP_S)[0], "the twin did not end"
    finally:
        os.close(pidfd)


def journal(path: Path) -> dict[str, Any]:
    """The twin's account of how it ended."""
    content: dict[str, Any] = json.loads(path.read_text())
    return content


def path_ends(segment: Segment) -> list[int]:
    """How the log's paths ended, in order."""
    return [e.path.end for e in segment.events if e.HasField("path") and e.path.end != pb.PATH_RUNNING]
