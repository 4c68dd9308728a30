"""request.py: what is asked of a simulation, and what comes of it."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gonio.dataset.bsdf import Dataset


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


@dataclass(frozen=True)
class Request:
    """`like`: a dataset whose points are to be simulated. None elsewhere: as the scenario says. Work is done on
    `threads` of this process, or on `workers` processes, or at a Dask `scheduler`."""

    scenario: Path
    like: Path | None = None
    photons: int | None = None
    relative_error: float | None = None
    seed: int | None = None
    threads: int = field(default_factory=usable_cores)
    workers: int = 0
    scheduler: str | None = None


@dataclass(frozen=True)
class Simulated:
    """A dataset, the photon balance over all of it (empty for a closed form), and what the user should know."""

    dataset: Dataset
    balance: dict[str, int]
    remarks: list[str]
    distributions: list[dict[str, Any]]  # per distribution: direction, channel, band, photons, error; plain JSON
