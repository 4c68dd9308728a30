"""component.py: one component of a sample: a family whose parameters may depend on the incident polar angle."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray
from gonio.model.analytic.families import family_of
from gonio.model.analytic.family import Family, Process, from_fitted, row, to_fitted
from gonio.model.analytic.tie import Tie, smooth_in_theta

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_FEW = 32  # angles: more than that, and a family of surfaces looks its integrals up


@dataclass(frozen=True)
class Component:
    """A family with parameters `values` (n, p) at incident polar angles `theta_deg` (n,), ascending, folded frame.

    Between the angles parameters are interpolated smoothly, those that the family says as logarithms; beyond the last
    they stay. `tie`: the BSDF is multiplied by what makes its exact hemispherical integral equal to the tie's value, at
    every theta_i (of ABg: A is); families of surfaces to 1e-4 of it up to 85 degrees.
    """

    family: Family
    process: Process
    theta_deg: FloatArray
    values: FloatArray
    tie: Tie | None = None

    @staticmethod
    def of(family_name: str, process: Process, **parameters: float) -> "Component":
        """With the same parameters for all incident directions. Raises UsageError, KeyError, ValueError."""
        family = family_of(family_name)
        if process not in family.processes:
            raise ValueError(f"{family_name} has no {process}")
        return Component(family, process, np.zeros(1), row(family, parameters)[None, :])

    def parameters_at(self, theta_deg: FloatArray) -> FloatArray:
        """Parameters (k, p), before the tie."""
        fitted = smooth_in_theta(self.theta_deg, to_fitted(self.family, self.values), theta_deg)
        return from_fitted(self.family, fitted)

    def _resolved(self, incident: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Parameters (k, p), factor of the tie (k,), hemispherical integral (k,); each theta_i is worked out once."""
        theta = np.degrees(np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), incident[:, 2]))
        different, back = np.unique(np.round(theta, 9), return_inverse=True)
        angles, back = np.asarray(different, dtype=np.float64), back.reshape(-1)
        values = self.parameters_at(angles)
        if self.tie is None:
            return values[back], np.ones(len(theta)), np.full(len(theta), np.nan)
        dear = not self.family.per_direction and len(angles) > _FEW
        own = self._tabulated(angles) if dear else self._integral_of(values, angles)
        target = self.tie.at(angles)
        factor = np.where(own > 0.0, target / np.where(own > 0.0, own, 1.0), 0.0)
        return values[back], factor[back], target[back]

    def _integral_of(self, values: FloatArray, theta_deg: FloatArray) -> FloatArray:
        theta = np.radians(theta_deg)
        return self.family.integral(values, np.stack((np.sin(theta), np.zeros(len(theta)), np.cos(theta)), axis=-1))

    @cached_property
    def _table(self) -> "CubicSpline":
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - slow to load, and few models need it

        angles = np.arange(91.0)
        own = self._integral_of(self.parameters_at(angles), np.minimum(angles, 89.99))
        mirrored = np.concatenate((own[:0:-1], own))  # an even function of theta
        return CubicSpline(np.arange(-90.0, 91.0), mirrored)

    def _tabulated(self, theta_deg: FloatArray) -> FloatArray:
        """Integral (k,) of a family of surfaces, whose quadrature is too dear for thousands of angles: a cubic spline
        through whole degrees."""
        return np.asarray(self._table(theta_deg))

    def bsdf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray) -> FloatArray:
        """BSDF [1/sr] (m,); directions folded: z >= 0."""
        values, factor, _ = self._resolved(incident)
        return np.asarray(factor[which] * self.family.bsdf_per_sr(values, incident, outgoing, which))

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray) -> FloatArray:
        """DSF [1/sr] (m,), BSDF times cos(theta_s)."""
        return np.asarray(self.bsdf_per_sr(incident, outgoing, which) * outgoing[:, 2])

    def integral(self, theta_deg: FloatArray) -> FloatArray:
        """Hemispherical reflectance or transmittance (k,), exact, with the tie."""
        angles = np.asarray(theta_deg, dtype=np.float64)
        return self._integral_of(self.parameters_at(angles), angles) if self.tie is None else self.tie.at(angles)

    def factor(self, theta_deg: FloatArray) -> FloatArray:
        """What the tie multiplies the BSDF by (k,)."""
        theta = np.radians(theta_deg)
        return self._resolved(np.stack((np.sin(theta), np.zeros(len(theta)), np.cos(theta)), axis=-1))[1]

    def features(self, incident: FloatArray) -> Features:
        """Narrow peaks, folded."""
        values, factor, _ = self._resolved(incident)
        found = self.family.features(values, incident)
        there = factor[found.incident] > 0.0
        return Features(found.centre[there], found.sigma_rad[there], found.incident[there])

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "family": self.family.name,
            "process": self.process,
            "theta_deg": self.theta_deg.tolist(),
            "parameters": [p.name for p in self.family.parameters],
            "units": [p.unit for p in self.family.parameters],
            "values": self.values.tolist(),
            "tie": None if self.tie is None else self.tie.to_json(),
        }

    @staticmethod
    def from_json(stored: dict[str, Any]) -> "Component":
        """Inverse of `to_json`. Raises UsageError, LookupError, TypeError, ValueError."""
        family = family_of(stored["family"])
        names = list(stored["parameters"])
        order = [names.index(p.name) for p in family.parameters]
        theta = np.array(stored["theta_deg"], dtype=np.float64)
        values = np.array(stored["values"], dtype=np.float64)[:, order]
        if stored["process"] not in family.processes or not len(theta) or len(theta) != len(values):
            raise ValueError(f"{family.name}: process {stored['process']!r} or the number of angles does not fit")
        tie = None if stored.get("tie") is None else Tie.from_json(stored["tie"])
        return Component(family, stored["process"], theta, values, tie)
