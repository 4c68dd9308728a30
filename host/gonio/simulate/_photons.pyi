"""The photon map (sim/optics) for Python; built from sim/python. Angles in the sample frame of CONVENTIONS.md.

A balance counts photons, and power in whole weights of 2^-24: emitted + roulette == stored + absorbed + lost, exactly.
stored_front is what of stored arrived at z >= 0; front_square and back_square are sums of squared weights.
Wrong input of the user raises gonio.units.errors.UsageError with one line.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Counts = NDArray[np.uint64]
_Balance = dict[str, int]  # the names of gonio.simulate.readings.BALANCE
_Estimates = tuple[_Floats, _Floats, _Floats, _Counts]

embree: str
"""Version of Embree that the module was built with."""

class Watch:
    """Progress of a run and the way to end it, from any thread."""

    def __init__(self) -> None: ...
    @property
    def photons(self) -> int:
        """Photons traced so far, over all runs that this watch was given to."""
    @property
    def cancelled(self) -> bool: ...
    def cancel(self) -> None:
        """End the run soon; it returns what it has, its balance counts the photons that were traced."""

class ScatterTable:
    """A BSDF from data, for materials of kind "tabulated": per hemisphere `cells` x `cells` values [1/sr] on equal
    squares of the Shirley-Chiu map of the direction cosines. `follow`: none, mirror, retro or through."""

    def __init__(self, cells: int, follow: str, isotropic: bool) -> None: ...
    def add(
        self, back: bool, theta_deg: float, phi_deg: float, reflected: _Floats | None, transmitted: _Floats | None
    ) -> None:
        """One incident direction, theta 0-90 from the normal of its side. Arrays (cells, cells), rows along y; None:
        none. ValueError for another shape."""

class Scenario:
    """A scenario file with a photon-map sample. `source_directory` holds protocol/axes.toml; `tables` by the file name
    in the scenario. `seed` None: the scenario's."""

    def __init__(
        self, path: str, source_directory: str, tables: Mapping[str, ScatterTable], seed: int | None = None
    ) -> None: ...
    @property
    def bands(self) -> list[tuple[str, float]]:
        """Name and wavelength [nm] of each."""
    @property
    def incidents(self) -> list[tuple[float, float]]:
        """theta, phi [degrees]."""
    @property
    def photons(self) -> int:
        """Per incident direction and band."""
    @property
    def relative_error(self) -> float:
        """Median that is asked for; 0: `photons` and no more."""
    @property
    def most_photons(self) -> int:
        """Where that ends; 0: not said."""
    @property
    def seed(self) -> int: ...
    @property
    def direction_step_deg(self) -> float: ...
    @property
    def radius_mm(self) -> float: ...
    @property
    def aperture_mm(self) -> float: ...
    @property
    def acceptance_deg(self) -> float: ...
    @property
    def estimator(self) -> str:
        """fixed, nearest or progressive."""
    @property
    def bandwidth(self) -> int:
        """Hits, of nearest."""
    def walk(self, band: str) -> str:
        """ "slats" where the fast walk serves the sample, else "embree"."""

class HitMap:
    """A stored photon map. Readings: DSF [1/sr], standard error [1/sr], half angle of the aperture [rad], hits; each
    (n,), for unit vectors `directions` (n, 3)."""

    @property
    def bytes(self) -> int: ...
    def fixed(self, directions: _Floats, half_angle_rad: float, threads: int) -> _Estimates:
        """A detector's aperture: unbiased."""
    def nearest(self, directions: _Floats, bandwidth: int, most_half_angle_rad: float, threads: int) -> _Estimates:
        """The cap that holds the nearest `bandwidth` hits."""

class ProgressiveReadings:
    """Readings at unit vectors `directions` (n, 3) with caps that shrink from batch to batch."""

    def __init__(self, directions: _Floats, first_half_angle_rad: float) -> None: ...
    def add(self, batch: HitMap, threads: int) -> None:
        """The next batch of photons. Batches of the same sizes in the same order give the same bits."""
    def estimates(self) -> _Estimates:
        """As HitMap's readings."""

class Goniophotometer:
    """One incident direction and one band, ready to trace. `mounted` False: the free beam. `embree`: not the fast
    walk."""

    def __init__(
        self,
        scenario: Scenario,
        band: str,
        theta_i_deg: float,
        phi_i_deg: float,
        mounted: bool = True,
        embree: bool = False,
    ) -> None: ...
    @property
    def aperture_half_angle_rad(self) -> float: ...
    def read(
        self, directions: _Floats, half_angle_rad: float, first: int, count: int, threads: int, watch: Watch
    ) -> tuple[_Counts, _Counts, _Counts, _Balance]:
        """Trace photons first ... first + count - 1 through apertures at the unit vectors `directions` (n, 3): sums of
        weights, of their squares and of hits, each (n,). Sums of disjoint ranges add up to the bits of the whole range,
        for any number of threads."""
    def store(self, first: int, count: int, threads: int, watch: Watch) -> tuple[HitMap, _Balance]:
        """Trace photons and keep what reaches the sphere."""

class PatchMatrix:
    """Columns of a BSDF matrix: light that fills a whole patch of directions, on one period of the sample.

    `patches_deg` (n, 4): theta from, theta to (about the normal of the side), azimuth from, width in azimuth; patches
    of one theta range are consecutive and equally wide.
    """

    def __init__(self, scenario: Scenario, band: str, patches_deg: _Floats, embree: bool = False) -> None: ...
    @property
    def depth_mm(self) -> float:
        """From the frontmost to the rearmost point of the sample."""
    def column(
        self, incident_patch: int, front_lit: bool, first: int, count: int, threads: int, watch: Watch
    ) -> tuple[tuple[_Counts, _Counts, _Counts], tuple[_Counts, _Counts, _Counts], _Balance]:
        """Sums of weights, squares and hits, each (n,), per outgoing patch: on the lit side, on the other side. Sum of
        weights / photons is the DSF integrated over the outgoing patch, averaged over the incident one."""

def estimate(weight: _Counts, square: _Counts, hits: _Counts, photons: int, half_angle_rad: float) -> _Estimates:
    """DSF [1/sr], its standard error, half angle and hits, each (n,), of sums over `photons` photons. ValueError where
    the shapes differ."""

def precision(
    weight: _Counts, square: _Counts, hits: _Counts, photons: int, relative_error: float
) -> tuple[float, int, int]:
    """Median relative standard error over the lit readings of such sums, how many are lit, and how many photons more
    bring that median to `relative_error` > 0."""
