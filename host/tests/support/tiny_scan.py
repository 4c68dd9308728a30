"""tiny_scan.py: the smallest whole scan, for a scripted firmware: two paths, a dark, samples and poses in the log."""

from pathlib import Path

import numpy as np
from fake_firmware import FakeFirmware
from small_log import pose_payload, sample_payload

from gonio.acquire.control import ControlSocket
from gonio.acquire.interrupt import Interrupt
from gonio.acquire.operator import AssumedOperator
from gonio.acquire.scan import ScanRequest, scan
from gonio.link.device import parse_device
from gonio.plan.program import DarkStep, PathStep, Program, ShutterStep
from gonio.protocol.generated import records
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)


def tiny_path(path_id: int, count: int) -> PathStep:
    """A path of the arm from where it stands and on, count knots."""
    knots = np.zeros(count, records.KNOT_DTYPE)
    knots["time_ns"] = np.arange(count) * 50_000_000
    knots["position_counts"][:, 2] = np.arange(count) * 10.0
    return PathStep(path_id, "coarse", f"coarse {path_id}", knots, 30.0, 0.0)


def tiny_program() -> Program:
    return Program(steps=[DarkStep(0.2), ShutterStep(True), tiny_path(1, 130), tiny_path(2, 3), ShutterStep(False)])


def with_data(fake: FakeFirmware, tick: int) -> None:
    """A script: a block of samples and one of poses with every Status."""
    fake.put(records.FRAME_SAMPLES, sample_payload(tick))
    fake.put(records.FRAME_POSES, pose_payload(tick))


def run_tiny_scan(folder: Path, device: str, control: ControlSocket | None = None) -> Path:
    """Scan into folder/raw.mcap."""
    request = ScanRequest(
        program=tiny_program(),
        plan=folder / "plan.toml",
        plan_text=b"tiny",
        instrument=REFERENCE,
        device=parse_device(device),
        output=folder / "raw.mcap",
    )
    with Interrupt(control) as interrupt:
        return scan(request, AssumedOperator(), interrupt)
