"""campaign.py: all jobs of a simulation, each until its photons are traced or its error is small enough."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gonio.simulate import _photons
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import AnyJob, Job, MapPart, Part, Reading


@dataclass(frozen=True)
class Effort:
    """Photons per job; with `relative_error` > 0 as many as the median reading needs for it, `most_photons` at most."""

    photons: int
    relative_error: float = 0.0
    most_photons: int = 0


class Crew(Protocol):
    """Whoever traces: threads of this process or a cluster."""

    def submit(self, number: int, job: AnyJob, first: int, count: int) -> None:
        """Have photons first ... first + count - 1 of a job traced, in one part or, of a divisible one, in several."""

    def next(self) -> tuple[int, Part | MapPart]:
        """Number of a job and the next part of it that is done."""


def run(
    jobs: Sequence[Job], effort: Effort, half_angle_rad: float, crew: Crew, progress: PhotonProgress
) -> list[Reading]:
    """One reading per job."""
    parts = complete(jobs, effort, crew, progress)
    return [_map_reading(part) if isinstance(part, MapPart) else _reading(part, half_angle_rad) for part in parts]


def complete(jobs: Sequence[AnyJob], effort: Effort, crew: Crew, progress: PhotonProgress) -> list[Part | MapPart]:
    """All photons of each job. All jobs are under way at once; a job's next round begins when its last one is
    complete."""
    sums = [Part.nothing(job.apertures) for job in jobs]
    wanted = [effort.photons] * len(jobs)
    for number, job in enumerate(jobs):
        progress.want(effort.photons)
        crew.submit(number, job, 0, effort.photons)
    parts: dict[int, Part | MapPart] = {}
    while len(parts) < len(jobs):
        number, part = crew.next()
        progress.done(part.balance["photons"])
        if isinstance(part, MapPart):
            parts[number] = part
            continue
        sums[number].add(part)
        done = sums[number].balance["photons"]
        if done < wanted[number]:
            continue
        more = min(_further(sums[number], effort.relative_error), max(effort.most_photons - done, 0))
        if more == 0:
            parts[number] = sums[number]
            continue
        wanted[number] += more
        progress.want(more)
        crew.submit(number, jobs[number], done, more)
    return [parts[number] for number in range(len(jobs))]


def _further(part: Part, relative_error: float) -> int:
    """How many more photons an error needs. Follows from whole sums: it does not depend on who traced how much."""
    if not relative_error > 0.0:
        return 0
    _, _, further = _photons.precision(part.weight, part.square, part.hits, part.balance["photons"], relative_error)
    return further


def _reading(part: Part, half_angle_rad: float) -> Reading:
    sums = (part.weight, part.square, part.hits, part.balance["photons"])
    dsf, error, _, hits = _photons.estimate(*sums, half_angle_rad)
    median, _, _ = _photons.precision(*sums, 1.0)
    aperture_sr = 2.0 * math.pi * (1.0 - math.cos(half_angle_rad))
    return Reading(dsf, error, hits, median, part.balance, aperture_sr)


def _map_reading(part: MapPart) -> Reading:
    lit = part.dsf_per_sr > 0.0
    median = float(np.median(part.error_per_sr[lit] / part.dsf_per_sr[lit])) if lit.any() else 0.0
    return Reading(part.dsf_per_sr, part.error_per_sr, part.hits, median, part.balance)
