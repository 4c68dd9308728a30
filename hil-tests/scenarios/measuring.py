"""measuring.py: home, step scan, fly scan; outside they are compared with the virtual-time run of the same seed."""

import os
import subprocess
from pathlib import Path

from guest.bench import Bench
from scenarios.registry import scenario


@scenario()
def home(bench: Bench) -> None:
    bench.gonio("info-before", "info", "--json")
    bench.gonio("home", "home")
    bench.state("homed")
    bench.gonio("info-after", "info", "--json")
    # Once as the user's shell starts it, imports and all.
    command = [str(Path(os.environ["GONIO_BIN"])), "info", "--json", "--device", bench.tcp]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=90.0)
    bench.values["installed_gonio"] = {"status": done.returncode, "stdout": done.stdout, "stderr": done.stderr}


@scenario()
def step_scan(bench: Bench) -> None:
    bench.end(bench.scan("step.toml"))
    bench.until_safe()


@scenario()
def fly_scan(bench: Bench) -> None:
    """Over USB."""
    bench.end(bench.scan("fly.toml", device=bench.usb), 150.0)
    bench.until_safe()
