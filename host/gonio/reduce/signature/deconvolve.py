"""deconvolve.py: a peak with the beam's and the aperture's share of its width taken out, and the noise that this costs.

Tikhonov's regularisation: of all distributions on a grid whose convolution with the measured beam fits the readings
as well as their noise lets one expect (V. A. Morozov's discrepancy principle), the one with the smallest squared
Laplacian; and once more for the residuals. It is linear in the readings, so their variance is carried through exactly.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import angles_deg_from_unit, mirror, through, unit_from_angles_deg
from gonio.reduce.signature.profile import About, BeamProfile, beam_places

FloatArray = NDArray[np.float64]

_MOST_CELLS = 900  # of the grid: the work grows with the third power
_PER_WIDTH = 5.0  # cells across the beam's full width at half maximum
_KERNEL_ERROR = 2e-3  # of the highest reading: what grid and measured profile leave of the kernel
_LEAST_POINTS = 50
_ROUNDS_TO_COME = 2.0  # times the next one: each adds about half of what the one before did
_HALVINGS = 40
_CLOSE = 0.02  # of the expected misfit


@dataclass(frozen=True)
class Deconvolved:
    """On a square grid about the patch's middle, arrays (m,): angles, DSF [1/sr], the standard deviation that the
    readings' noise leaves in it, and the size of what smoothing may still hide: what further rounds would add."""

    theta_deg: FloatArray
    phi_deg: FloatArray
    dsf_per_sr: FloatArray
    noise_per_sr: FloatArray
    smoothing_per_sr: FloatArray
    strength: float  # of the regularisation, found by the discrepancy principle
    misfit: float  # root mean square of the residuals over their standard deviation: 1 by the principle
    points: int
    spacing_deg: float

    @property
    def u_per_sr(self) -> FloatArray:
        """Noise and smoothing together."""
        return np.hypot(self.noise_per_sr, self.smoothing_per_sr)

    def record(self) -> dict[str, Any]:
        """For Dataset.provenance: method, strength, and the noise beside the readings' own."""
        top = int(np.argmax(self.dsf_per_sr))
        return {
            "method": "iterated Tikhonov, squared Laplacian, discrepancy principle",
            "strength": self.strength,
            "misfit": self.misfit,
            "points": self.points,
            "spacing_deg": self.spacing_deg,
            "height_per_sr": float(self.dsf_per_sr[top]),
            "height_noise_per_sr": float(self.noise_per_sr[top]),
            "height_smoothing_per_sr": float(self.smoothing_per_sr[top]),
        }


def deconvolve(distribution: Distribution, beam: Distribution, about: About, radius_deg: float) -> Deconvolved:
    """The DSF within `radius_deg` of the mirror or the through direction without the beam. Raises ValueError where too
    few points are measured there, or the radius is smaller than the beam's."""
    profile = BeamProfile.of(beam)
    radius = np.radians(radius_deg)
    if radius <= profile.radius_rad:
        raise ValueError(f"a patch of {radius_deg:g} degrees is no larger than the beam: nothing to deconvolve")
    incident = (distribution.incident_theta_deg, distribution.incident_phi_deg)
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    axis = unit_from_angles_deg(*(through if about == "through" else mirror)(*incident))
    near = np.flatnonzero(distribution.measured & (unit @ axis >= np.cos(radius)))
    if len(near) < _LEAST_POINTS:
        raise ValueError(f"{len(near)} points within {radius_deg:g} degrees are too few to deconvolve")
    x, y = beam_places(unit[near], incident, about)
    dsf = distribution.dsf_per_sr[near]
    variance = distribution.variance_per_sr2[near] + (_KERNEL_ERROR * float(dsf.max())) ** 2

    whole = radius + 1.3 * profile.radius_rad  # light from outside the patch comes into it
    spacing = max(profile.fwhm_rad / _PER_WIDTH, whole * float(np.sqrt(np.pi / _MOST_CELLS)))
    node_x, node_y, laplacian = _grid(whole, spacing)
    kernel = _kernel(profile, (x, y), (node_x, node_y), spacing)
    normal = np.asarray((kernel.T @ kernel.multiply(1.0 / variance[:, None])).todense())
    right = kernel.T @ (dsf / variance)
    rough = np.asarray((laplacian.T @ laplacian).todense())
    scale = float(np.trace(normal) / np.trace(rough))
    strength = _strength(normal, rough * scale, right, (kernel, dsf, variance))
    factor = cho_factor(normal + strength * scale * rough)
    found = _twice(factor, normal, right)
    misfit = float(np.sqrt(np.mean((dsf - kernel @ found) ** 2 / variance)))
    # The result is B K^T V^-1 times the readings, B = (2 - C N) C with C = (N + s R)^-1: its covariance is B N B^T.
    inverse = cho_solve(factor, np.eye(len(found)))
    operator = 2.0 * inverse - inverse @ normal @ inverse
    noise = np.sqrt(np.maximum(np.sum((operator @ normal) * operator, axis=1), 0.0))
    further = cho_solve(factor, right - normal @ found)
    kept = np.hypot(node_x, node_y) <= radius
    theta_deg, phi_deg = angles_deg_from_unit(_directions(node_x, node_y, incident, about))
    return Deconvolved(
        theta_deg=theta_deg[kept],
        phi_deg=phi_deg[kept],
        dsf_per_sr=found[kept],
        noise_per_sr=noise[kept],
        smoothing_per_sr=_ROUNDS_TO_COME * np.abs(further)[kept],
        strength=strength,
        misfit=misfit,
        points=len(near),
        spacing_deg=float(np.degrees(spacing)),
    )


def _grid(radius: float, spacing: float) -> tuple[FloatArray, FloatArray, csr_matrix]:
    """Places x, y [rad] (m,) of a square grid over a disc, and its Laplacian (m, m): each place less the mean of its
    neighbours, times their number."""
    half = int(np.ceil(radius / spacing))
    column, row = (v.ravel() for v in np.meshgrid(np.arange(-half, half + 1), np.arange(-half, half + 1)))
    inside = np.hypot(column, row) * spacing <= radius
    x: FloatArray = np.asarray(column[inside] * spacing, dtype=np.float64)
    y: FloatArray = np.asarray(row[inside] * spacing, dtype=np.float64)
    pairs = cKDTree(np.stack((x, y), axis=1)).query_pairs(1.1 * spacing, output_type="ndarray")
    a, b = np.concatenate((pairs, pairs[:, ::-1])).T
    beside = csr_matrix((np.ones(len(a)), (a, b)), shape=(len(x), len(x)))
    return x, y, csr_matrix(diags(np.asarray(beside.sum(axis=1)).ravel()) - beside)


def _kernel(
    profile: BeamProfile,
    place: tuple[FloatArray, FloatArray],
    node: tuple[FloatArray, FloatArray],
    spacing: float,
) -> csr_matrix:
    """Share (n, m) of each node's light in each reading; rows add up to 1."""
    x0, y0 = profile.centroid_rad
    places, nodes = np.stack(place, axis=1), np.stack(node, axis=1)
    reach = 1.3 * profile.radius_rad
    close = cKDTree(places).sparse_distance_matrix(cKDTree(nodes), reach + spacing, output_type="coo_matrix")
    off = places[close.row] - nodes[close.col]
    value = np.maximum(profile.at(off[:, 0] + x0, off[:, 1] + y0), 0.0)
    kernel = csr_matrix((value, (close.row, close.col)), shape=(len(places), len(nodes)))
    return csr_matrix(kernel.multiply(1.0 / np.asarray(kernel.sum(axis=1))))


def _strength(
    normal: FloatArray, rough: FloatArray, right: FloatArray, data: tuple[csr_matrix, FloatArray, FloatArray]
) -> float:
    """Strength of the regularisation at which the mean squared misfit is 1, by halving its logarithm; the least one
    tried where no strength fits as badly as that, the strongest where even that does."""
    kernel, dsf, variance = data
    low, high = -7.0, 5.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        found = _twice(cho_factor(normal + 10.0**middle * rough), normal, right)
        misfit = float(np.mean((dsf - kernel @ found) ** 2 / variance))
        if abs(misfit - 1.0) < _CLOSE:
            break
        low, high = (middle, high) if misfit < 1.0 else (low, middle)
        if high - low < 0.05:
            break
    return float(10.0**middle)


def _twice(factor: Any, normal: FloatArray, right: FloatArray) -> FloatArray:
    """The regularised solution, and what the same gives for its residuals added (iterated Tikhonov regularisation): it
    flattens a peak less."""
    once = cho_solve(factor, right)
    return np.asarray(once + cho_solve(factor, right - normal @ once))


def _directions(x: FloatArray, y: FloatArray, incident_deg: tuple[float, float], about: About) -> FloatArray:
    """Unit vectors (m, 3) of places in the beam's frame: the inverse of beam_places."""
    theta, phi = np.radians(incident_deg)
    e_theta = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    e_phi = np.array([-np.sin(phi), np.cos(phi), 0.0])
    angle = np.hypot(x, y)
    sinc = np.where(angle > 1e-12, np.sin(angle) / np.maximum(angle, 1e-12), 1.0)
    away = -unit_from_angles_deg(*incident_deg)
    unit = (x * sinc)[:, None] * e_theta + (y * sinc)[:, None] * e_phi + np.cos(angle)[:, None] * away
    return np.asarray(unit if about == "through" else unit * [1.0, 1.0, -1.0])
