"""radiance.py: runs Radiance's programs (those that pyradiance carries) and says what they took."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path


@dataclass(frozen=True)
class Usage:
    """What a process and its children took."""

    wall_s: float
    cpu_s: float
    peak_mib: float  # of the largest single process
    output: bytes
    errors: str


def folder() -> Path | None:
    """Where pyradiance is, or None."""
    spec = find_spec("pyradiance")
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def environment() -> dict[str, str]:
    """With Radiance's programs on the path and its library where they look for it."""
    home = folder()
    if home is None:
        raise FileNotFoundError("pyradiance is not installed")
    path = f"{home / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}"
    return os.environ | {"PATH": path, "RAYPATH": f".{os.pathsep}{home / 'lib'}"}


def run(command: list[str], where: Path, feed: bytes = b"") -> Usage:
    """Runs to the end; RuntimeError with the program's own words if it fails. Input and output go through files."""
    source, sink, words, report = (where / name for name in ("feed.bin", "output.bin", "errors.txt", "report.json"))
    source.write_bytes(feed)
    launch = [sys.executable, "-S", str(Path(__file__).with_name("launch.py")), str(report), *command]
    with source.open("rb") as stdin, sink.open("wb") as stdout, words.open("wb") as stderr:
        subprocess.run(launch, cwd=where, stdin=stdin, stdout=stdout, stderr=stderr, env=environment(), check=True)
    took = json.loads(report.read_text())
    errors = words.read_text(errors="replace")
    if took["exit"]:
        raise RuntimeError(f"{command[0]}: exit status {took['exit']}: {errors.strip()[-500:]}")
    return Usage(took["wall_s"], took["cpu_s"], took["peak_mib"], sink.read_bytes(), errors)
