"""scattering.py: what models and simulation files are to the rest: a BSDF that answers in any pair of directions."""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, Polarisation, Side, Symmetry

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]


class Origin(IntEnum):
    """Where a value comes from. Numbers are stored in files, append only."""

    MEASURED = 0  # the incident direction was measured, and a point lies within reach of the outgoing one
    INTERPOLATED = 1  # between measured directions
    EXTRAPOLATED = 2  # beyond the measured directions, by the stated rule
    ABSENT = 3  # this pair of hemispheres was not measured: there is no value


@dataclass(frozen=True)
class Features:
    """Where a scattering function changes within a few degrees: p narrow peaks. Integrators look closely there.

    centre (p, 3): unit vectors; sigma_rad (p,): the smaller standard deviation; incident (p,): row of the incident
    directions asked for.
    """

    centre: FloatArray
    sigma_rad: FloatArray
    incident: IndexArray

    @staticmethod
    def none() -> "Features":
        return Features(np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64))


class Scattering(Protocol):
    """One channel of a sample's BSDF, in the sample frame of CONVENTIONS.md.

    Directions are unit vectors away from the sample. `incident` (k, 3) with `which` (m,): incident row of each of m
    outgoing directions (m, 3); None: k is 1 and all belong to it. Integrators ask for millions of directions at once
    with few distinct incident rows: implementations are vectorised over both and keep no Python loop over m.
    """

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """DSF [1/sr] (m,), not negative; NaN where the pair of hemispheres is absent."""
        ...

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """Origin (m,) of each value."""
        ...

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """Whether there is anything for light that arrives at and leaves from these sides of the sample."""
        ...

    def features(self, incident: FloatArray) -> Features:
        """Narrow peaks of the distributions of the incident directions (k, 3)."""
        ...


@dataclass(frozen=True)
class MeasuredIntegral:
    """A hemispherical integral that was measured: the truth that models and files are held against."""

    channel: str
    incident_theta_deg: float
    incident_phi_deg: float
    reflection: bool  # rho, else tau
    value: float
    u: float  # standard uncertainty (k = 1)


@dataclass
class Bsdf:
    """A sample's BSDF, from a model or a file: one Scattering per channel, with all that explains it."""

    channels: dict[str, Scattering]
    sample_name: str = ""
    manufacturer: str = ""
    front_faces: Side = "undeclared"
    symmetry: Symmetry = "undeclared"
    polarisation: Polarisation = "unknown"
    thickness_mm: float | None = None
    band_nm: dict[str, tuple[float, float]] = field(
        default_factory=dict
    )  # of channels, from and to (the same: one wavelength), where known
    measured: tuple[MeasuredIntegral, ...] = ()
    validity: tuple[str, ...] = ()  # sentences: what was measured, what is extrapolated and by which rule
    provenance: dict[str, Any] = field(default_factory=dict)  # plain JSON values

    def as_dataset(self, distributions: list[Distribution], provenance: dict[str, Any]) -> Dataset:
        """Points of this sample."""
        return Dataset(
            distributions,
            sample_name=self.sample_name,
            front_faces=self.front_faces,
            polarisation=self.polarisation,
            symmetry=self.symmetry,
            thickness_mm=self.thickness_mm,
            manufacturer=self.manufacturer,
            provenance=provenance,
        )


def wavelength_bands_nm(dataset: Dataset) -> dict[str, tuple[float, float]]:
    """Bsdf.band_nm of channels of a single wavelength that the dataset states: from it, to it."""
    return {d.channel: (d.wavelength_nm, d.wavelength_nm) for d in dataset.distributions if d.wavelength_nm is not None}
