"""rows.py: a line of a benchmark's table, the median time that stands in it, and the machine it was taken on."""

import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def seconds(work: Callable[[], object], runs: int) -> float:
    """Median wall time of `runs` calls."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def row(
    name: str, unit: str, ours: float, peer: float | None, peer_name: str, runs: int, *, high: bool
) -> dict[str, Any]:
    """One line of a table; `ratio` > 1 means that ours is better. A peer of None was not run."""
    ratio = None if peer is None else (ours / peer if high else peer / ours)
    return {
        "name": name,
        "unit": unit,
        "ours": ours,
        "peer": peer,
        "peer_name": peer_name,
        "ratio": ratio,
        "runs": runs,
    }


def machine() -> dict[str, Any]:
    """Processor and versions."""
    model = next((line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor())  # fmt: skip
    return {"cpu": model, "cores": os.cpu_count(), "python": platform.python_version(), "numpy": np.__version__}
