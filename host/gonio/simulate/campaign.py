"""campaign.py: all jobs of a simulation, each until its photons are traced or its error is small enough."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gonio.simulate import _photons
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import Job, MapPart, Part, Reading


@dataclass(frozen=True)
class Effort:
    """Photons per job; with `relative_error` > 0 as many as the median reading needs for it, `most_photons` at most."""

    photons: int
    relative_error: float = 0.0
    most_photons: int = 0


class Crew(Protocol):
    """Whoever traces: threads of this process or a cluster."""

    def submit(self, number: int, job: Job, first: int, count: int) -> None:
        """Have photons first ... first + count - 1 of a job traced, in one part or in several; in one
        where the estimator is not "fixed"."""

    def next(self) -> tuple[int, Part | MapPart]:
        """Number of a job and the next part of it that is done."""


def run(
    jobs: Sequence[Job], effort: Effort, half_angle_rad: float, crew: Crew, progress: PhotonProgress
) -> list[Reading]:
    """One reading per job. All jobs are under way at once; a job's next round begins when its last one is complete."""
    sums = [Part.nothing(len(job.directions)) for job in jobs]
    wanted = [effort.photons] * len(jobs)
    for number, job in enumerate(jobs):
        progress.want(effort.photons)
        crew.submit(number, job, 0, effort.photons)
    readings: dict[int, Reading] = {}
    while len(readings) < len(jobs):
        number, part = crew.next()
        progress.done(part.balance["photons"])
        if isinstance(part, MapPart):
            readings[number] = _map_reading(part)
            continue
        sums[number].add(part)
        done = sums[number].balance["photons"]
        if done < wanted[number]:
            continue
        reading, further = _reading(sums[number], half_angle_rad, effort.relative_error)
        more = min(further, max(effort.most_photons - done, 0))
        if more == 0:
            readings[number] = reading
            continue
        wanted[number] += more
        progress.want(more)
        crew.submit(number, jobs[number], done, more)
    return [readings[number] for number in range(len(jobs))]


def _reading(part: Part, half_angle_rad: float, relative_error: float) -> tuple[Reading, int]:
    """What the photons so far say, and how many more are needed. Both follow from whole sums: they do not depend on who
    traced how much."""
    photons = part.balance["photons"]
    sums = (part.weight, part.square, part.hits, photons)
    dsf, error, _, hits = _photons.estimate(*sums, half_angle_rad)
    median, _, further = _photons.precision(*sums, relative_error if relative_error > 0.0 else 1.0)
    return Reading(dsf, error, hits, median, part.balance), further if relative_error > 0.0 else 0


def _map_reading(part: MapPart) -> Reading:
    lit = part.dsf_per_sr > 0.0
    median = float(np.median(part.error_per_sr[lit] / part.dsf_per_sr[lit])) if lit.any() else 0.0
    return Reading(part.dsf_per_sr, part.error_per_sr, part.hits, median, part.balance)
