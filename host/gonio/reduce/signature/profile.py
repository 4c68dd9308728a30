"""profile.py: the instrument signature: the free beam through the aperture, as the reference scan measured it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates, spline_filter

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.interpolate import Interpolation
from gonio.geometry.local_fit import local_fit

FloatArray = NDArray[np.float64]

About = Literal["through", "mirror"]

_HELD = 0.995  # of the light, within `radius_rad`
_RINGS = 24
_SLOPE_WIDTHS = 4.5  # radius of the fit for a slope, over the width of a cell
_STEP = 0.75  # of the lattice, over the width of a cell,
_LATTICE_MOST = 400  # but no more nodes than this along a side


@dataclass(frozen=True)
class BeamProfile:
    """The beam as a DSF of unit integral about its nominal direction: places x, y [rad] (n,), whose length is the angle
    from straight through, along the lab's X and Y as the light travels; value [1/sr], variance and solid angle."""

    x: FloatArray
    y: FloatArray
    per_sr: FloatArray
    variance_per_sr2: FloatArray
    solid_angle_sr: FloatArray

    @classmethod
    def of(cls, beam: Distribution) -> "BeamProfile":
        """From Dataset.beam, masked points left out. Raises ValueError for a beam without light."""
        used = beam.measured & (beam.solid_angle_sr > 0.0)
        polar, azimuth = np.radians(beam.theta_deg[used]), np.radians(beam.phi_deg[used])
        value, area = beam.dsf_per_sr[used], beam.solid_angle_sr[used]
        # P_i is 2 V - P1, and the cells alone read a beam high: at ten turns across it by 0.3 %.
        linear = beam.linear_solid_angle_sr
        total = float(value @ (2.0 * area - linear[used] if len(linear) else area))
        if not total > 0.0:
            raise ValueError("the beam scan holds no light: it has no profile")
        return cls(
            polar * np.cos(azimuth),
            polar * np.sin(azimuth),
            value / total,
            beam.variance_per_sr2[used] / total**2,
            area,
        )

    @property
    def noise_rel(self) -> float:
        """Standard deviation of the profile's sum from noise, relative."""
        return float(np.sqrt(self.solid_angle_sr**2 @ self.variance_per_sr2))

    @cached_property
    def centroid_rad(self) -> tuple[float, float]:
        """Of the light, off straight through."""
        light = self.per_sr * self.solid_angle_sr
        return float(light @ self.x / light.sum()), float(light @ self.y / light.sum())

    @cached_property
    def radius_rad(self) -> float:
        """About the centroid, holding 99.5 % of the light."""
        off = np.hypot(self.x - self.centroid_rad[0], self.y - self.centroid_rad[1])
        order = np.argsort(off)
        light = np.cumsum((self.per_sr * self.solid_angle_sr)[order])
        return float(off[order][np.searchsorted(light, _HELD * light[-1])])

    @cached_property
    def fwhm_rad(self) -> float:
        """Full width at half maximum: of the disc with the area that is above half of the top."""
        above = self.per_sr > 0.5 * self.per_sr.max()
        return 2.0 * float(np.sqrt(self.solid_angle_sr[above].sum() / np.pi))

    def radial(self) -> tuple[FloatArray, FloatArray]:
        """Radial profile about the centroid: angles [deg] of rings out to 1.5 radii, and the mean over each [1/sr]."""
        off = np.hypot(self.x - self.centroid_rad[0], self.y - self.centroid_rad[1])
        edge = np.linspace(0.0, 1.5 * self.radius_rad, _RINGS + 1)
        ring = np.digitize(off, edge) - 1
        inside = ring < _RINGS
        area = np.bincount(ring[inside], self.solid_angle_sr[inside], _RINGS)
        light = np.bincount(ring[inside], (self.per_sr * self.solid_angle_sr)[inside], _RINGS)
        seen = area > 0.0
        return np.degrees(0.5 * (edge[1:] + edge[:-1]))[seen], light[seen] / area[seen]

    def at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Profile [1/sr] at places [rad] (m,), smoothly interpolated; 0 outside the scan."""
        lattice = self._lattice
        places = np.stack(((x - lattice.x0) / lattice.step, (y - lattice.y0) / lattice.step))
        return np.asarray(map_coordinates(lattice.spline, places, order=3, prefilter=False, mode="constant"))

    @cached_property
    def _lattice(self) -> "_Lattice":
        """Cubic spline on a square lattice, through means over squares as wide as a cell: samples that lie close along
        the track, and a second scan over the same places, differ by noise alone. At the nodes stands the sum over the
        corners i of a triangle of weight_i (f_i + 1/2 slope_i (x - x_i)), which has any quadratic exactly."""
        width = float(np.sqrt(np.median(self.solid_angle_sr)))
        column, row = np.floor(self.x / width).astype(np.int64), np.floor(self.y / width).astype(np.int64)
        square = np.unique((column - column.min()) * (int(np.ptp(row)) + 1) + row - row.min(), return_inverse=True)[1]
        count = np.bincount(square)
        x, y, value = (np.bincount(square, v) / count for v in (self.x, self.y, self.per_sr))
        corner = _on_sphere(x, y)
        slope = local_fit(corner, value, np.zeros(len(x)), np.ones(len(x), dtype=bool), _SLOPE_WIDTHS * width).gradient
        extent = max(float(np.ptp(x)), float(np.ptp(y)))
        step = max(_STEP * width, extent / _LATTICE_MOST)
        # Two steps outside the scan, so that the spline ends on zeros.
        nodes = np.arange(-2.0, extent / step + 3.0) * step
        x0, y0 = float(x.min()), float(y.min())
        at_x, at_y = np.meshgrid(x0 + nodes, y0 + nodes, indexing="ij")
        middle = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
        inside = np.hypot(at_x - middle[0], at_y - middle[1]) <= np.hypot(x - middle[0], y - middle[1]).max()
        node = _on_sphere(at_x[inside], at_y[inside])
        found = Interpolation(corner, cut_at_horizon=False).at(node)
        rise = np.einsum("ijk,ijk->ij", np.nan_to_num(slope)[found.index], node[:, None] - corner[found.index])
        values = np.zeros_like(at_x)
        values[inside] = (found.weight * (value[found.index] + 0.5 * rise)).sum(axis=1)
        return _Lattice(x0 + nodes[0], y0 + nodes[0], step, np.asarray(spline_filter(values, order=3, mode="constant")))


@dataclass(frozen=True)
class _Lattice:
    """Coefficients of a cubic spline at x0 + i step, y0 + j step [rad]."""

    x0: float
    y0: float
    step: float
    spline: FloatArray


def _on_sphere(x: FloatArray, y: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) at places whose length is the angle from +z."""
    angle = np.hypot(x, y)
    sinc = np.sinc(angle / np.pi)
    return np.stack((x * sinc, y * sinc, np.cos(angle)), axis=1)


def beam_places(unit: FloatArray, incident_deg: tuple[float, float], about: About) -> tuple[FloatArray, FloatArray]:
    """Places x, y [rad] (n,) of sample-frame directions (n, 3) in the beam's own frame: where in the reference scan the
    light that goes there unscattered was seen. `mirror`: reflected in the sample's plane before.

    The lab's X and Y are the sample's e_theta and e_phi at the incident direction (axes 1 and 2 of CONVENTIONS.md).
    """
    theta, phi = np.radians(incident_deg)
    away = -unit_from_angles_deg(*incident_deg)
    e_theta = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    e_phi = np.array([-np.sin(phi), np.cos(phi), 0.0])
    seen = unit if about == "through" else unit * [1.0, 1.0, -1.0]
    x, y = seen @ e_theta, seen @ e_phi
    across = np.hypot(x, y)
    scale = np.where(across > 1e-12, np.arctan2(across, seen @ away) / np.maximum(across, 1e-12), 1.0)
    return x * scale, y * scale
