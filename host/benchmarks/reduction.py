"""reduction.py: gonio reduce as a user runs it, process start and file included, over scans of growing size."""

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from big_scan import write_big_scan
from rows import row
from scipy.spatial import SphericalVoronoi

from gonio.geometry.directions import unit_from_angles_deg

SIZES = (100_000, 500_000, 2_000_000, 10_000_000)
_PEER_MOST = 500_000  # samples: beyond, the peer alone takes minutes
_JOSTLE = 1e-7  # SphericalVoronoi refuses repeated points, and circles are cocircular


def reduction(sizes: tuple[int, ...] = SIZES) -> list[dict[str, Any]]:
    """Seconds and memory of the whole command; beside it what scipy needs for the cells of the same points alone."""
    rows = []
    for samples in sizes:
        with tempfile.TemporaryDirectory() as folder:
            raw, reduced = Path(folder) / "raw.mcap", Path(folder) / "reduced.h5"
            write_big_scan(raw, samples)
            runs = 3 if samples <= _PEER_MOST else 1
            times, memory_mib = zip(*(_run(raw, reduced) for _ in range(runs)), strict=True)
            peer = _cells_alone(reduced) if samples <= _PEER_MOST else None
        ours = float(np.median(times))
        rows.append(row(f"gonio reduce, {samples:,} samples", "s", ours, peer, "scipy's cells alone", runs, high=False))
        rows.append(row(f"its peak memory, {samples:,} samples", "MiB", max(memory_mib), None, "-", runs, high=False))
    return rows


def _run(raw: Path, reduced: Path) -> tuple[float, float]:
    """Wall time in s and peak memory in MiB of one run."""
    gonio = str(Path(sys.executable).with_name("gonio"))
    begin = time.perf_counter()
    silent = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    arguments = [gonio, "reduce", str(raw), "-o", str(reduced)]
    process = os.posix_spawn(gonio, arguments, os.environ, file_actions=silent)
    _, status, usage = os.wait4(process, 0)
    seconds = time.perf_counter() - begin
    if status != 0:
        raise SystemExit(f"gonio reduce of {raw} failed")
    return seconds, usage.ru_maxrss / 1024.0


def _cells_alone(reduced: Path) -> float:
    with h5py.File(reduced) as file:
        data = file["incident_0000/data"]
        unit = unit_from_angles_deg(data["theta"][...], data["phi"][...])
    unit += _JOSTLE * np.random.default_rng(3).standard_normal(unit.shape)
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    begin = time.perf_counter()
    SphericalVoronoi(unit).calculate_areas()
    return time.perf_counter() - begin


if __name__ == "__main__":
    for line in reduction(tuple(int(size) for size in sys.argv[1:]) or SIZES):
        sys.stdout.write(f"{line['name']:40} {line['ours']:10.3g} {line['unit']:4} peer {line['peer']}\n")
