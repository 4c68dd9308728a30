"""tracing.py: photons of one job through the photon map in this process; and the local crew, which does so job by
job."""

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from threading import Lock

import numpy as np

from gonio.formats.window.klems import basis_named
from gonio.simulate import _photons
from gonio.simulate.bundle import Bundle, Unpacked
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import BALANCE, AnyJob, Job, MapPart, Part, PatchJob, added
from gonio.simulate.tables import Table
from gonio.units.instrument import reference_instrument_path

_LOOK_S = 0.1  # between two looks at the progress
_WIDEST = 10.0  # cap of the nearest hits over the detector's aperture
_FIRST = 4.0  # first cap of progressive readings over the detector's aperture
_BATCH = 1 << 20  # photons of one of their batches
_KEPT = 4  # scenes that stay built: the jobs of a campaign come in order


def embree_version() -> str:
    """That the photon map was built with."""
    return _photons.embree


def open_scenario(path: Path, tables: dict[str, Table], seed: int | None) -> _photons.Scenario:
    """Read a scenario with a photon-map sample. Raises UsageError."""
    native = {}
    for name, table in tables.items():
        native[name] = _photons.ScatterTable(table.cells, table.follow, table.isotropic)
        for entry in table.entries:
            native[name].add(entry.back, entry.theta_deg, entry.phi_deg, entry.reflected, entry.transmitted)
    return _photons.Scenario(str(path), str(reference_instrument_path().parents[1]), native, seed)


class Laboratory:
    """A bundle's scenario, opened per band, with the last few goniophotometers ready. For any number of threads."""

    def __init__(self, bundle: Bundle, path: Path) -> None:
        self._bundle = bundle
        self._path = path
        self._lock = Lock()
        self._scenario = lru_cache(maxsize=None)(self._open)
        self._ready = lru_cache(maxsize=_KEPT)(self._build)
        self._matrix = lru_cache(maxsize=_KEPT)(self._build_matrix)

    def scenario(self, band: str) -> _photons.Scenario:
        """The scenario with the tables of that band."""
        with self._lock:
            return self._scenario(band)

    def trace(self, job: AnyJob, first: int, count: int, threads: int, watch: _photons.Watch) -> Part | MapPart:
        """Photons `first` ... `first + count - 1` of a job."""
        if isinstance(job, PatchJob):
            with self._lock:
                matrix = self._matrix(job.band, job.basis)
            sides = matrix.column(job.patch, job.front_lit, job.first_photon + first, count, threads, watch)
            weight, square, hits = (np.concatenate(pair) for pair in zip(*sides[:2], strict=True))
            return Part(weight, square, hits, sides[2])
        with self._lock:
            goniophotometer = self._ready(job.band, job.incident_deg, job.mounted)
        half_angle = goniophotometer.aperture_half_angle_rad
        if job.estimator == "nearest":
            stored, balance = goniophotometer.store(first, count, threads, watch)
            dsf, error, _, hits = stored.nearest(job.directions, job.bandwidth, _WIDEST * half_angle, threads)
            return MapPart(dsf, error, hits, balance)
        if job.estimator == "progressive":
            return _progressive(goniophotometer, job, (first, count), threads, watch)
        weight, square, hits, balance = goniophotometer.read(job.directions, half_angle, first, count, threads, watch)
        return Part(weight, square, hits, balance)

    def half_angle_rad(self, band: str) -> float:
        """Of the detector's aperture."""
        with self._lock:
            return self._ready(band, (0.0, 0.0), False).aperture_half_angle_rad

    def depth_mm(self, band: str, basis: str) -> float:
        """Of the sample. Raises UsageError where light of whole patches cannot be traced through the scenario."""
        with self._lock:
            return self._matrix(band, basis).depth_mm

    def _open(self, band: str) -> _photons.Scenario:
        return open_scenario(self._path, self._bundle.tables.get(band, {}), self._bundle.seed)

    def _build(self, band: str, incident_deg: tuple[float, float], mounted: bool) -> _photons.Goniophotometer:
        return _photons.Goniophotometer(self._scenario(band), band, *incident_deg, mounted)

    def _build_matrix(self, band: str, basis: str) -> _photons.PatchMatrix:
        return _photons.PatchMatrix(self._scenario(band), band, np.array(basis_named(basis).bounds_deg))


def _progressive(
    goniophotometer: _photons.Goniophotometer, job: Job, photons: tuple[int, int], threads: int, watch: _photons.Watch
) -> MapPart:
    """Batches of a fixed size, one after the other: the same bits for any number of threads."""
    readings = _photons.ProgressiveReadings(job.directions, _FIRST * goniophotometer.aperture_half_angle_rad)
    first, count = photons
    balance = dict.fromkeys(BALANCE, 0)
    for start in range(first, first + count, _BATCH):
        if not watch.cancelled:
            stored, more = goniophotometer.store(start, min(_BATCH, first + count - start), threads, watch)
            readings.add(stored, threads)
            balance = added(balance, more)
    dsf, error, _, hits = readings.estimates()
    return MapPart(dsf, error, hits, balance)


_laboratories: dict[str, tuple[Unpacked, Laboratory]] = {}
_laboratories_lock = Lock()


def laboratory_of(bundle: Bundle) -> Laboratory:
    """The laboratory of a bundle that came from elsewhere; a process keeps the last one open."""
    with _laboratories_lock:
        digest = bundle.digest
        if digest not in _laboratories:
            _laboratories.clear()
            unpacked = Unpacked(bundle)
            _laboratories[digest] = unpacked, Laboratory(bundle, unpacked.scenario)
        return _laboratories[digest][1]


class LocalCrew:
    """Traces on threads of this process, one range after the other, each on all threads."""

    def __init__(self, laboratory: Laboratory, threads: int, progress: PhotonProgress) -> None:
        self._laboratory = laboratory
        self._threads = threads
        self._progress = progress
        self._waiting: deque[tuple[int, AnyJob, int, int]] = deque()

    def submit(self, number: int, job: AnyJob, first: int, count: int) -> None:
        """Have photons first ... first + count - 1 of a job traced; `number` comes back with the part."""
        self._waiting.append((number, job, first, count))

    def next(self) -> tuple[int, Part | MapPart]:
        """The next part that is done. Ctrl-C ends the tracing before it goes on its way."""
        number, job, first, count = self._waiting.popleft()
        watch = _photons.Watch()
        with ThreadPoolExecutor(1) as pool:
            future = pool.submit(self._laboratory.trace, job, first, count, self._threads, watch)
            try:
                while True:
                    try:
                        return number, future.result(_LOOK_S)
                    except TimeoutError:
                        self._progress.at(watch.photons)
            finally:
                watch.cancel()
