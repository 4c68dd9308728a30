"""ours.py: one job on our photon map in a process of its own, for its peak memory: ours.py JOB.json > RESULT.

What a job asks for and gives: see the function of its name.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from directions import even_directions

from gonio.simulate import _photons

SOURCES = Path(__file__).resolve().parents[3]


def clock() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def took(start: tuple[float, float]) -> dict[str, float]:
    wall, cpu = clock()
    return {"wall_s": wall - start[0], "cpu_s": cpu - start[1]}


def goniophotometer(job: dict[str, Any], seed: int | None = None) -> _photons.Goniophotometer:
    scenario = _photons.Scenario(job["scenario"], str(SOURCES), {}, seed)
    theta, phi = scenario.incidents[0]
    return _photons.Goniophotometer(scenario, scenario.bands[0][0], theta, phi, embree=job.get("embree", False))


def walk(job: dict[str, Any]) -> dict[str, Any]:
    """`photons` through the sample, one aperture: the walk and little else. Share of the light that is stored."""
    twin = goniophotometer(job)
    start = clock()
    *_, balance = twin.read(even_directions(1), 1e-3, 0, job["photons"], job["threads"], _photons.Watch())
    return took(start) | {"stored_share": balance["stored"] / balance["emitted"], "lost": balance["lost"]}


def stored(job: dict[str, Any]) -> dict[str, Any]:
    """Set-up, photons, map and all `directions` readings; of the readings alone: time, median error and hits."""
    start = clock()
    twin = goniophotometer(job)
    held, balance = twin.store(0, job["photons"], job["threads"], _photons.Watch())
    directions = even_directions(job["directions"])
    half_angle = job["half_angle_rad"] or half_angle_for(held, directions[::97], job["relative_error"])
    reading = clock()
    dsf, error, _, hits = held.fixed(directions, half_angle, job["threads"])
    read = took(reading)
    lit = hits > 0
    return {
        "whole": took(start),
        "read": read,
        "half_angle_rad": half_angle,
        "median_hits": float(np.median(hits[lit])),
        "median_error": float(np.median(error[lit] / dsf[lit])),
        "lit": int(np.sum(lit)),
        "stored": balance["stored"] / 2**24,
        "map_mib": held.bytes / 2**20,
    }


def half_angle_for(held: _photons.HitMap, directions: np.ndarray, relative_error: float) -> float:
    """Aperture at which the median error of the lit readings is this."""
    low, high = 1e-3, 0.5
    for _ in range(12):
        middle = float(np.sqrt(low * high))
        dsf, error, _, hits = held.fixed(directions, middle, 2)
        lit = hits > 0
        if np.any(lit) and np.median(error[lit] / dsf[lit]) < relative_error:
            high = middle
        else:
            low = middle
    return high


def streamed(job: dict[str, Any]) -> dict[str, Any]:
    """Photons straight through all apertures: nothing is kept."""
    start = clock()
    twin = goniophotometer(job)
    directions = even_directions(job["directions"])
    weight, square, hits, balance = twin.read(
        directions, job["half_angle_rad"], 0, job["photons"], job["threads"], _photons.Watch()
    )
    dsf, error, _, _ = _photons.estimate(weight, square, hits, balance["photons"], job["half_angle_rad"])
    lit = hits > 0
    return {"whole": took(start), "median_error": float(np.median(error[lit] / dsf[lit]))}


def bias(job: dict[str, Any]) -> dict[str, Any]:
    """Integral of the readings over the sphere against the photons that arrived, per seed: relative differences."""
    directions = even_directions(job["directions"])
    differences = []
    for seed in range(1, job["seeds"] + 1):
        twin = goniophotometer(job, seed)
        held, balance = twin.store(0, job["photons"], job["threads"], _photons.Watch())
        dsf, *_ = held.fixed(directions, job["half_angle_rad"], job["threads"])
        integral = float(np.sum(dsf)) * 4 * np.pi / len(directions)
        differences.append(integral / (balance["stored"] / balance["emitted"]) - 1)
    return {"differences": differences}


def klems(job: dict[str, Any]) -> dict[str, Any]:
    """Whole Klems matrices, both sides lit: seconds; shares and standard errors (side, incident, 2 x outgoing)."""
    scenario = _photons.Scenario(job["scenario"], str(SOURCES), {}, job.get("seed"))
    start = clock()
    matrix = _photons.PatchMatrix(scenario, scenario.bands[0][0], np.array(job["patches"]))
    weight, square, photons = [], [], job["photons"]
    for front_lit in (True, False):
        for patch in range(len(job["patches"])):
            reflected, transmitted, _ = matrix.column(patch, front_lit, 0, photons, job["threads"], _photons.Watch())
            weight.append(np.concatenate([reflected[0], transmitted[0]]))
            square.append(np.concatenate([reflected[1], transmitted[1]]))
    shape = (2, len(job["patches"]), 2 * len(job["patches"]))
    mean = (np.array(weight).astype(np.float64) / 2**24 / photons).reshape(shape)
    second = (np.array(square).astype(np.float64) / 2**24 / photons).reshape(shape)
    np.savez(job["out"], share=mean, error=np.sqrt(np.maximum(second - mean**2, 0) / photons))
    return took(start)


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text())
    work = {f.__name__: f for f in (walk, stored, streamed, bias, klems)}[job["work"]]
    json.dump(work(job), sys.stdout)


main()
