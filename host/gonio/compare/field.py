"""field.py: what each side of a comparison says in any direction: a distribution by interpolation, a model directly."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.compare.arc import Arc
from gonio.compare.values import Spread, Values, modelled, values_of
from gonio.dataset.bsdf import Distribution
from gonio.dataset.scattering import Scattering
from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.interpolate import Interpolation
from gonio.geometry.local_fit import local_fit
from gonio.geometry.pitch import path_pitch_rad, reach_rad

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

INTERPOLATION = "interpolation"  # key of the effect; always one side's own
SAME_DEG = 1e-4  # directions nearer than this are one: under the resolution of any encoder
_NOTHING = 1e-9  # a corner with less weight than this does not count
# Radius of the curvature's fit, in pitches of the finest path; the fit itself widens it where points lie farther apart.
_FIT_PITCHES, _FINEST = 2.5, 0.02
_TRACK = 2.0  # successive points nearer than this many mean distances follow a track


@dataclass(frozen=True)
class At:
    """Values at n directions; `masked` (n,): there were points, but masked ones. `interpolation_per_sr` (n,): estimate
    of interpolated minus true DSF; None where nothing was interpolated."""

    values: Values
    masked: BoolArray
    interpolation_per_sr: FloatArray | None = None


class Field(Protocol):
    """One side of a comparison, in any direction."""

    def at(self, unit: FloatArray) -> At:
        """Values at directions (n, 3)."""
        ...


class PointField:
    """A distribution in any direction: linear interpolation on the Delaunay triangles of its points, or along the arc
    that they lie on. `like` has the same points and lends its triangles."""

    def __init__(self, distribution: Distribution, like: "PointField | None" = None) -> None:
        self.distribution = distribution
        self._like = like
        self.unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
        self.values = values_of(distribution)

    def has_points(self, unit: FloatArray) -> bool:
        """Whether its points are the directions (n, 3), one by one."""
        if len(unit) != len(self.unit):
            return False
        return bool(np.all(np.linalg.norm(unit - self.unit, axis=1) <= np.radians(SAME_DEG)))

    def at_points(self) -> At:
        """At its own points."""
        return At(self.values, ~self.distribution.measured)

    def at(self, unit: FloatArray) -> At:
        """At directions (n, 3). Each value carries the noise of the corners of its triangle, their effects, and the
        error of linear interpolation as an effect of its own."""
        weights = self._interpolation.at(unit)
        index, weight = weights.index, np.where(np.abs(weights.weight) > _NOTHING, weights.weight, 0.0)
        corners = self.values.dsf_per_sr[index]
        masked = np.any(np.isnan(corners) & (weight > 0.0), axis=1) & weights.inside
        valid = weights.inside & ~masked
        weight = np.where(valid[:, None], weight, 0.0)
        dsf = np.where(valid, _mean(corners, weight), np.nan)
        variance = _mean(self.values.variance_per_sr2[index], weight**2)
        effects = {
            name: np.where(valid, _mean(column[index], weight), np.nan) for name, column in self.values.effects.items()
        }
        error = np.where(valid, self._error(unit, index, weight, corners), np.nan)
        effects[INTERPOLATION] = error
        source = np.nan_to_num(self.values.variance_per_sr2)
        return At(Values(dsf, np.where(valid, variance, np.nan), effects, Spread(index, weight, source)), masked, error)

    @cached_property
    def _path(self) -> NDArray[np.int32]:
        """Path numbers (n,). Points of no known path are one path where the list follows a track (as rows of a table
        do): successive points are as near as points over the sphere would be. Else they are scattered, -1."""
        path, n = self.distribution.path, len(self.unit)
        if len(path):
            return path
        step = np.linalg.norm(np.diff(self.unit, axis=0), axis=1)
        follows = n > 1 and float(np.median(step)) <= _TRACK * np.sqrt(4.0 * np.pi / n)
        return np.full(n, 0 if follows else -1, dtype=np.int32)

    @cached_property
    def _interpolation(self) -> Interpolation | Arc:
        if self._like is not None:
            return self._like._interpolation
        if Arc.fits(self.unit):
            return Arc(self.unit)
        return Interpolation(self.unit, reach_rad=reach_rad(self.unit, self._path))

    @cached_property
    def _finest_rad(self) -> float:
        """Pitch of the finest path."""
        if self._like is not None:
            return self._like._finest_rad
        return float(np.quantile(path_pitch_rad(self.unit, self._path), _FINEST))

    @cached_property
    def _slopes(self) -> tuple[FloatArray, FloatArray]:
        """Gradient (n, 3) and second derivatives (n, 6) at every point, NaN where too few points lie about it. The two
        hemispheres are two functions: each is fitted to its own points."""
        used, values = self.distribution.measured, self.values
        if isinstance(self._interpolation, Arc):
            return self._interpolation.slopes(values.dsf_per_sr, used)
        gradient, hessian = np.full((len(used), 3), np.nan), np.full((len(used), 6), np.nan)
        for side in (self.unit[:, 2] >= 0.0, self.unit[:, 2] < 0.0):
            if side.any():
                own = values.dsf_per_sr[side], values.variance_per_sr2[side], used[side]
                fit = local_fit(self.unit[side], *own, radius_rad=_FIT_PITCHES * self._finest_rad)
                gradient[side], hessian[side] = fit.gradient, fit.hessian
        return gradient, hessian

    def _error(self, unit: FloatArray, index: NDArray[np.intp], weight: FloatArray, corners: FloatArray) -> FloatArray:
        """Interpolated minus true, (n,), of a function with the corners' slopes g and second derivatives H: with d_k
        the way to corner k and D = sum w_k d_k it is g D + sum w_k d_k H d_k / 2 - D H D, g and H being means over the
        corners. D is 0 but at the horizon, where a point stands for its mirror image. Where no slope is known: the
        corners' range."""
        all_gradients, all_hessians = self._slopes
        gradient, hessian = all_gradients[index], all_hessians[index]
        apart = self.unit[index] - unit[:, None, :]
        offset = _mean(apart, weight[:, :, None])
        bent = 0.5 * _twice(hessian, apart) - _twice(hessian, offset[:, None, :])
        steep = np.einsum("nkc,nc->nk", gradient, offset)
        unknown = np.any(np.isnan(bent) & (weight > 0.0), axis=1)
        low = np.min(np.where(weight > 0.0, corners, np.inf), axis=1)
        high = np.max(np.where(weight > 0.0, corners, -np.inf), axis=1)
        return np.where(unknown, high - low, _mean(bent + steep, weight))


class ModelField:
    """A model at one incident direction."""

    def __init__(self, model: Scattering, incident_theta_deg: float, incident_phi_deg: float) -> None:
        self._model, self._incident = model, unit_from_angles_deg([incident_theta_deg], [incident_phi_deg])

    def at(self, unit: FloatArray) -> At:
        """At directions (n, 3)."""
        dsf = self._model.dsf_per_sr(self._incident, unit)
        return At(modelled(dsf), np.zeros(len(unit), dtype=np.bool_))


def incident_read(distribution: Distribution) -> tuple[float, float]:
    """The incident direction that the axes read, or the nominal one where the dataset does not say."""
    found = distribution.integrals
    theta = found.get("incident_measured_theta_deg", distribution.incident_theta_deg)
    return theta, found.get("incident_measured_phi_deg", distribution.incident_phi_deg)


def _mean(values: FloatArray, weight: FloatArray) -> FloatArray:
    """sum w values over the corners (n, 3, ...), those of weight 0 left out, NaN or not."""
    return np.asarray(np.sum(np.where(weight != 0.0, values, 0.0) * weight, axis=1))


def _twice(hessian: FloatArray, way: FloatArray) -> FloatArray:
    """way . H . way (n, k) for ways (n, k or 1, 3) and H (n, k, 6) as LocalFit has it."""
    x, y, z = way[..., 0], way[..., 1], way[..., 2]
    products = np.stack((x * x, y * y, z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z), axis=-1)
    return np.asarray(np.sum(hessian * products, axis=-1))
