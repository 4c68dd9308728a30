"""cluster.py: jobs cut into ranges of photons and traced as Dask tasks: on processes of this machine or at a
scheduler."""

import logging
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster, as_completed

from gonio.simulate import _photons
from gonio.simulate.bundle import Bundle
from gonio.simulate.readings import AnyJob, MapPart, Part
from gonio.simulate.tracing import laboratory_of
from gonio.units.errors import GonioError, UsageError
from gonio.units.version import gonio_version

# Photons per task: about half a second of one core, and not more tasks per round than a scheduler likes.
_LEAST_PHOTONS = 1 << 20
_MOST_TASKS = 256
_LOST_WORKERS = 10  # that one task may outlive
_RETRIES = 3
_CONNECT_S = 20.0
_SILENT = logging.CRITICAL + 1  # after Ctrl-C the scheduler calls its lost connections critical


def trace_range(bundle: Bundle, job: AnyJob, photons: tuple[int, int], version: str) -> Part | MapPart:
    """The task: the photons first, count of a job, on one thread. Whole numbers come back."""
    if version != gonio_version():
        raise UsageError(f"a worker has gonio {gonio_version()}, this is {version}: install the same everywhere")
    return laboratory_of(bundle).trace(job, *photons, 1, _photons.Watch())


def dask_setup(_worker: Any) -> None:
    """Dask calls this in each worker process of our own: Ctrl-C is for the program that started them and ends them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _kept(value: Any) -> Any:
    """A task whose result others need: if its worker is lost the scheduler makes it again."""
    return value


class ClusterCrew:
    """Traces at a Dask scheduler. Sums are whole numbers, so the result does not depend on how the work was cut, on who
    did it, or on what had to be done twice because a worker was lost."""

    def __init__(self, client: Client, bundle: Bundle, least_photons: int = _LEAST_PHOTONS) -> None:
        self._client = client
        self._least_photons = least_photons
        self._bundle = client.submit(_kept, bundle, pure=False)
        self._jobs: dict[AnyJob, Any] = {}
        self._numbers: dict[str, int] = {}
        self._done = as_completed(with_results=True)

    def submit(self, number: int, job: AnyJob, first: int, count: int) -> None:
        """Have photons first ... first + count - 1 of a job traced, in several parts."""
        if job not in self._jobs:
            self._jobs[job] = self._client.submit(_kept, job, pure=False)
        size = max(self._least_photons, -(-count // _MOST_TASKS)) if job.divisible else count
        for start in range(first, first + count, size):
            photons = (start, min(size, first + count - start))
            task = self._client.submit(
                trace_range, self._bundle, self._jobs[job], photons, gonio_version(), pure=False, retries=_RETRIES
            )
            self._numbers[task.key] = number
            self._done.add(task)

    def next(self) -> tuple[int, Part | MapPart]:
        """The next part that is done. Raises GonioError where the workers cannot do it."""
        try:
            task, part = next(self._done)
        except KilledWorker as error:
            raise GonioError(
                f"the cluster lost {_LOST_WORKERS} workers over one task: is their memory enough?"
            ) from error
        number = self._numbers.pop(task.key)
        task.release()
        return number, part


@contextmanager
def connected(scheduler: str | None, workers: int) -> Iterator[Client]:
    """A client of the scheduler at an address, or of so many worker processes of our own. Raises UsageError."""
    warnings.filterwarnings("ignore", message="Sending large graph", category=UserWarning)
    settings = {
        "distributed.scheduler.allowed-failures": _LOST_WORKERS,
        "distributed.admin.tick.limit": "1h",
        "distributed.comm.timeouts.connect": f"{_CONNECT_S}s",
    }
    with dask.config.set(settings):
        if scheduler is None:
            try:
                cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=_SILENT,
                    preload=[__name__],
                )
            except (OSError, RuntimeError) as error:
                raise UsageError(
                    f"--workers {workers}: cannot start them ({error}): they need memory and a /dev/shm that takes "
                    "files; --threads does without"
                ) from error
            with cluster, Client(cluster) as client:
                yield client
            return
        try:
            client = Client(scheduler, timeout=_CONNECT_S)
        except (OSError, ValueError, TypeError) as error:
            raise UsageError(f"--scheduler {scheduler}: cannot connect: check address and scheduler") from error
        with client:
            try:
                client.wait_for_workers(1, timeout=_CONNECT_S)
            except TimeoutError as error:
                raise UsageError(f"--scheduler {scheduler}: has no workers: start dask worker {scheduler}") from error
            yield client
