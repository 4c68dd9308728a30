"""twin_runs.py: the real command line against the real twin: plans, runs, and what they leave behind."""

import json
import os
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.segment_reader import Segment

UNTIL = Path(__file__).with_name("scan_until.py")
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


def _gonio(folder: Path, command: list[str]) -> tuple[int, str, str]:
    """Run a command to its end, its control socket in `folder`: status, standard output, standard error."""
    done = subprocess.run(
        command,
        env=os.environ | {"XDG_RUNTIME_DIR": str(folder)},
        capture_output=True,
        text=True,
        timeout=GIVE_UP_S,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def run(folder: Path, *arguments: str | Path) -> tuple[int, str, str]:
    """Run gonio: status, standard output, standard error."""
    return _gonio(folder, [sys.executable, "-m", "gonio.cli.main", *map(str, arguments)])


def run_until(folder: Path, kind: str, path_time_s: float, action: str, *arguments: str | Path) -> tuple[int, str, str]:
    """Run gonio until a path of `kind` has been flown so long; then `action` comes (scan_until.py)."""
    return _gonio(folder, [sys.executable, str(UNTIL), kind, str(path_time_s), action, *map(str, arguments)])


def wait_for_end(pid: int) -> None:
    """Wait for a process that is not our child."""
    try:
        pidfd = os.pidfd_open(pid)
    except ProcessLookupError:
        return
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
