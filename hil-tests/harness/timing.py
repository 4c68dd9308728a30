"""timing.py: the timing lane: one boot on counted instructions, at 500 Hz; the small host's account is the result."""

import json
import shutil
from pathlib import Path
from typing import Any

from harness.outcomes import BrokenRigError
from harness.rig import Rig
from harness.session import PROGRAMS, ROOT
from kernel.build import KernelError, kernel_image
from vm.boot import BootError, Machine, boot, last_lines
from vm.initrd import InitrdError

_HIL = Path(__file__).resolve().parents[1]
_HOST = "sim/gonio-bench-host"
_TOOLS = ("/usr/sbin/ip", "/usr/bin/chrt")


def run_timing_lane(rig: Rig, build: Path, results: Path) -> dict[str, Any]:
    """Boot, fly, and return the host's account. Raises BrokenRigError."""
    programs = {name.upper(): build / path for name, path in PROGRAMS.items()} | {"HOST": build / _HOST}
    named = {"GONIOD": programs["GONIOD"], "TWIN": programs["GONIO-TWIN-DEVICES"], "HOST": programs["HOST"]}
    for path in named.values():
        if not path.is_file():
            raise BrokenRigError(f"there is no {path}: run make build")
    scenario = rig.folder / "timing.toml"
    values: dict[str, object] = {**named, "SCENARIO": scenario, "SAMPLES": rig.settings["timing_samples"]}
    head = "".join(f"{name}={value}\n" for name, value in values.items()) + f"export GONIO_SOURCE_DIR={ROOT}\n"
    tools = [Path(tool) for tool in _TOOLS]
    protocol = ROOT / "protocol"
    preload = (*named.values(), *tools, scenario, protocol / "axes.toml", *sorted((protocol / "eds").iterdir()))
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    limit_s = float(rig.settings["timing_limit_s"])
    start = head + (_HIL / "vm" / "timing.sh").read_text()
    try:
        boot(Machine(kernel_image(), "timing", results, limit_s, preload, start))
    except (BootError, KernelError, InitrdError) as error:
        raise BrokenRigError(str(error)) from error
    logs = [results / name for name in ("serial.log", "log", "host.err", "goniod.err", "twin.err")]
    status = results / "host.status"
    if not status.is_file() or status.read_text().strip() != "0":
        raise BrokenRigError(f"the timing lane did not come to its end:\n{last_lines(logs)}")
    account: dict[str, Any] = json.loads((results / "host.json").read_text())
    return account
