"""readings.py: what is to be read (jobs) and what came of it (parts that add up, readings)."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gonio.formats.window.klems import basis_named

FloatArray = NDArray[np.float64]
CountArray = NDArray[np.uint64]

_COLUMN_BITS = 40  # photons of a column; scrambles of low-discrepancy points change every 2^32

BALANCE = (
    "photons",
    "emitted",
    "stored",
    "stored_front",
    "front_square",
    "back_square",
    "absorbed",
    "lost",
    "roulette",
)


@dataclass(frozen=True, eq=False)
class Job:
    """One incident direction and band, to be read at unit vectors (n, 3) of the sample frame. Not mounted: the free
    beam."""

    band: str
    incident_deg: tuple[float, float]
    mounted: bool
    directions: FloatArray
    estimator: str = "fixed"  # or nearest, progressive: read from stored maps
    bandwidth: int = 0  # hits, of nearest

    @property
    def apertures(self) -> int:
        """How many readings it has."""
        return len(self.directions)

    @property
    def divisible(self) -> bool:
        """Whether parts of its photons add up."""
        return self.estimator == "fixed"


@dataclass(frozen=True)
class PatchJob:
    """Light that fills one patch of an angle basis on one side, to be read by the patch that it leaves through: those
    of the lit side, then those of the other. Patches of both sides have their azimuth in the sample frame."""

    band: str
    basis: str  # as in gonio.formats.klems.BASES
    front_lit: bool
    patch: int

    @property
    def apertures(self) -> int:
        """How many readings it has."""
        return 2 * basis_named(self.basis).size

    @property
    def divisible(self) -> bool:
        """Whether parts of its photons add up."""
        return True

    @property
    def first_photon(self) -> int:
        """Every column has photons of its own: chance then differs from column to column, and sums over them gain."""
        return (self.patch + (0 if self.front_lit else basis_named(self.basis).size)) << _COLUMN_BITS


AnyJob = Job | PatchJob


@dataclass
class Part:
    """What a range of photons left in the apertures, in whole weights; arrays (n,). Parts add up to the same bits in
    any order."""

    weight: CountArray
    square: CountArray
    hits: CountArray
    balance: dict[str, int]

    @classmethod
    def nothing(cls, apertures: int) -> "Part":
        """No photon yet."""
        weight, square, hits = (np.zeros(apertures, dtype=np.uint64) for _ in range(3))
        return cls(weight, square, hits, dict.fromkeys(BALANCE, 0))

    def add(self, other: "Part") -> None:
        """Take in the photons of another range."""
        self.weight += other.weight
        self.square += other.square
        self.hits += other.hits
        self.balance = added(self.balance, other.balance)


@dataclass(frozen=True)
class MapPart:
    """What stored maps of all photons of a job say at its directions, arrays (n,). Such parts do not add up."""

    dsf_per_sr: FloatArray
    error_per_sr: FloatArray
    hits: CountArray
    balance: dict[str, int]


def added(one: dict[str, int], other: dict[str, int]) -> dict[str, int]:
    """Sum of two photon balances."""
    return {name: one[name] + other[name] for name in BALANCE}


@dataclass
class Reading:
    """Readings of one job, arrays (n,): irradiance r^2 over the emitted power, its standard error, hits in the
    aperture."""

    signal_per_sr: FloatArray
    error_per_sr: FloatArray
    hits: CountArray
    median_error: float = 0.0  # relative, over the lit readings
    balance: dict[str, int] = field(default_factory=dict)  # empty: a closed form, no photons
    aperture_sr: float = 0.0  # solid angle of each aperture; 0: not the same for all
