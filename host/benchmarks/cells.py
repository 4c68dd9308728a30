"""cells.py: spherical cells beside scipy's, and how time and memory grow over a real scan's path; rows of `make bench`.

Run alone it measures one size in a process of its own: `python cells.py POINTS` prints seconds and MiB as JSON.
"""

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rows import row, seconds
from scipy.spatial import SphericalVoronoi

from gonio.geometry.cells import cells, solid_angles_sr
from gonio.geometry.directions import unit_from_angles_deg
from gonio.plan.spiral import spiral

SIZES = (100_000, 500_000, 2_000_000, 10_000_000)
_PITCH_DEG = 0.1
_ALONG_DEG = 0.03


def scan_path(n: int) -> NDArray[np.float64]:
    """About n directions (n, 3): a quarter on a spiral about a peak, the others on circles of constant elevation in a
    tilted frame, a hundred times as far apart as their samples; encoders' noise of 0.0002 degrees."""
    radius_deg = np.sqrt(0.25 * n * _PITCH_DEG * _ALONG_DEG / np.pi)
    track = spiral(unit_from_angles_deg(40.0, 20.0), min(radius_deg, 60.0), _PITCH_DEG)
    along = np.linspace(0.0, track.length_deg[-1], n // 4)
    fine = np.stack([np.interp(along, track.length_deg, track.unit[:, k]) for k in range(3)], axis=1)
    coarse_pitch_deg = np.sqrt(41_253.0 / (0.75 * n) * 100.0)
    circles = []
    for k, elevation_deg in enumerate(np.arange(-89.0, 89.0, coarse_pitch_deg)):
        step_deg = 0.01 * coarse_pitch_deg / np.cos(np.radians(elevation_deg))
        azimuth_deg = np.arange(0.0, 360.0, step_deg)[:: 1 if k % 2 else -1]
        circles.append(unit_from_angles_deg(90.0 - elevation_deg, azimuth_deg))
    tilt = np.radians(35.0)
    frame = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tilt), np.sin(tilt)], [0.0, -np.sin(tilt), np.cos(tilt)]])
    points = np.concatenate((np.concatenate(circles) @ frame, fine))
    points += np.radians(2e-4) * np.random.default_rng(1).standard_normal(points.shape)
    return np.asarray(points / np.linalg.norm(points, axis=1)[:, None])


def measured(n: int) -> dict[str, float]:
    """Seconds for the cells of a path of n points, and what they add to the process's memory at its highest."""
    points = scan_path(n)
    reach = np.full(len(points), np.radians(10.0))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    found = cells(points, reach_rad=reach)
    wall_s = time.perf_counter() - start
    if abs(found.solid_angle_sr.sum() - 4.0 * np.pi) > 1e-2:
        raise SystemExit(f"the cells of {len(points)} points do not cover the sphere")
    return {"seconds": wall_s, "mib": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024}


def spherical_cells() -> list[dict[str, Any]]:
    """Lines of the table: random points against scipy, then a path of growing length, each in its own process."""
    points = np.random.default_rng(2).normal(size=(200_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]

    def peer() -> None:
        SphericalVoronoi(points).calculate_areas()

    lines = [
        row("spherical cells of 200,000 points", "s", seconds(lambda: solid_angles_sr(points), 3), seconds(peer, 3),
            "scipy SphericalVoronoi + areas", 3, high=False)
    ]  # fmt: skip
    for n in SIZES:
        run = subprocess.run([sys.executable, str(Path(__file__)), str(n)], check=True, capture_output=True)
        result = json.loads(run.stdout)
        lines.append(row(f"cells of a path of {n:,} points", "s", result["seconds"], None, "", 1, high=False))
        lines.append(row("  their memory", "MiB", result["mib"], None, "", 1, high=False))
    return lines


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measured(int(sys.argv[1]))) + "\n")
