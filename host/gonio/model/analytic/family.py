"""family.py: what a family of closed forms is: the BSDF of one component with named parameters."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray

Process = Literal["reflection", "transmission"]


@dataclass(frozen=True)
class Parameter:
    """A named parameter: the values from `lower` to `upper` have a meaning; `log`: fitted and interpolated as its
    logarithm."""

    name: str
    unit: str
    lower: float
    upper: float
    log: bool
    what: str


class Family(Protocol):
    """A family of isotropic distributions in the folded frame (model/hemisphere.py): both directions have z >= 0, and
    mirror reflection and straight transmission are both (-x, -y, z) of the incident direction.

    `values` (k, p): the parameters for each of k incident directions (k, 3); `which` (m,): row of each of m outgoing
    directions (m, 3). `per_direction`: the parameters may depend on theta_i; else one set holds for all.
    """

    @property
    def name(self) -> str: ...

    @property
    def source(self) -> str: ...

    @property
    def processes(self) -> tuple[Process, ...]: ...

    @property
    def parameters(self) -> tuple[Parameter, ...]: ...

    @property
    def per_direction(self) -> bool: ...

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """BSDF [1/sr] (m,)."""
        ...

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """Hemispherical reflectance or transmittance (k,)."""
        ...

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """Narrow peaks, folded frame."""
        ...

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """Parameters (s, p) to start a fit from; BSDF [1/sr] found about the mirror direction and far from it."""
        ...


def bounds(family: Family) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds (p,)."""
    return (np.array([p.lower for p in family.parameters]), np.array([p.upper for p in family.parameters]))


def row(family: Family, named: Mapping[str, float]) -> FloatArray:
    """Parameters (p,) in the family's order; KeyError where one is missing, ValueError outside the bounds."""
    values = np.array([float(named[p.name]) for p in family.parameters])
    lower, upper = bounds(family)
    if not np.all((values >= lower) & (values <= upper)):
        at = int(np.argmin((values >= lower) & (values <= upper)))
        raise ValueError(f"{family.parameters[at].name} {values[at]:g} is not from {lower[at]:g} to {upper[at]:g}")
    return values


def to_fitted(family: Family, values: FloatArray) -> FloatArray:
    """Parameters (..., p) as they are fitted and interpolated: logarithms where the family says so."""
    log = np.array([p.log for p in family.parameters])
    lower, upper = bounds(family)
    inside = np.clip(values, np.where(log, np.maximum(lower, 1e-300), lower), upper)
    return np.where(log, np.log(np.where(log, inside, 1.0)), inside)


def from_fitted(family: Family, fitted: FloatArray) -> FloatArray:
    """Inverse of `to_fitted`."""
    log = np.array([p.log for p in family.parameters])
    return np.where(log, np.exp(np.where(log, fitted, 0.0)), fitted)
