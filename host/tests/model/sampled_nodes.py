"""sampled_nodes.py: datasets, points and nodes of known functions for the tests of the fitted model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.model.frames import level_axes, tangents
from gonio.model.nodes import Node
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
MIRROR = np.array([-1.0, -1.0, 1.0])


def spread(number: int) -> FloatArray:
    """Unit vectors (n, 3) over the upper hemisphere, equal areas, on Fibonacci's spiral."""
    k = np.arange(number) + 0.5
    z, phi = 1.0 - k / number, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)


def distribution(
    theta_i: float, phi_i: float, unit: FloatArray, dsf: FloatArray, variance: FloatArray | None = None
) -> Distribution:
    """Of points that share the hemisphere equally."""
    number = len(unit)
    theta, phi = angles_deg_from_unit(unit)
    return Distribution(
        incident_theta_deg=theta_i,
        incident_phi_deg=phi_i,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=dsf,
        variance_per_sr2=np.zeros(number) if variance is None else variance,
        signal=dsf,
        normalisation=np.ones(number),
        count=np.ones(number, dtype=np.int32),
        flags=np.zeros(number, dtype=np.uint16),
        solid_angle_sr=np.full(number, 2.0 * np.pi / number),
        time_ns=np.zeros(number, dtype=np.int64),
    )


def dataset(
    function: Callable[[FloatArray, FloatArray], FloatArray],
    incident_deg: Sequence[tuple[float, float]],
    *,
    number: int = 3000,
    symmetry: Any = "isotropic",
    noise: float = 0.0,
) -> Dataset:
    """Of a function of one incident unit vector (3,) and outgoing ones (n, 3); for light from behind and leaving
    there, `function` gets what lies there. `noise`: relative standard deviation, known to the file."""
    random = np.random.default_rng(7)
    unit = spread(number)
    parts = []
    for theta, phi in incident_deg:
        incident = unit_from_angles_deg(theta, phi)
        own = unit if theta <= 90.0 else unit * np.array([1.0, 1.0, -1.0])
        dsf = function(incident, own)
        sigma = noise * np.abs(dsf)
        parts.append(distribution(theta, phi, own, dsf + sigma * random.standard_normal(number), sigma**2))
    return Dataset(parts, sample_name="known", symmetry=symmetry)


def gaussian(unit: FloatArray, centre: FloatArray, peak: float, sigma_deg: float) -> FloatArray:
    """A round lobe."""
    angle = np.degrees(np.linalg.norm(tangents(level_axes(centre), unit), axis=-1))
    return np.asarray(peak * np.exp(-0.5 * (angle / sigma_deg) ** 2))


@dataclass(frozen=True)
class Moving:
    """A lobe that leaves the mirror direction by `lag` per radian of theta_i, widens and weakens with theta_i, and one
    at rest; over diffuse light. Isotropic but for the resting lobe, which lies at the normal."""

    lag: float = 0.1

    def __call__(self, incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr] (n,)."""
        theta, phi = np.arccos(incident[2]), np.arctan2(incident[1], incident[0])
        off = (1.0 + self.lag) * theta
        centre = np.array([-np.sin(off) * np.cos(phi), -np.sin(off) * np.sin(phi), np.cos(off)])
        moving = gaussian(outgoing, centre, 8.0 * np.exp(-theta), 4.0 + 3.0 * theta)
        return 0.3 / np.pi * outgoing[:, 2] + moving + gaussian(outgoing, np.array([0.0, 0.0, 1.0]), 1.0, 8.0)


def node_with(incident: FloatArray, lobes: Sequence[tuple[FloatArray, float, float]]) -> Node:
    """A node of round lobes (centre, peak [1/sr], sigma [deg]) and nothing else."""
    number = len(lobes)
    log = np.array([np.eye(2) * 2.0 * np.log(np.radians(sigma)) for _, _, sigma in lobes]).reshape(-1, 2, 2)
    return Node(
        incident=np.asarray(incident, dtype=np.float64),
        centre=np.array([centre for centre, _, _ in lobes], dtype=np.float64).reshape(-1, 3),
        log_peak=np.log([peak for _, peak, _ in lobes]) if number else np.zeros(0),
        log_covariance=log,
        patch=tuple(np.zeros((2, 2), dtype=np.float32) for _ in lobes),
        background=np.zeros((2, 2), dtype=np.float32),
        coverage=np.zeros((64, 64), dtype=np.uint8),
        points=100,
        integral=1.0,
        stated=float("nan"),
        stated_u=float("nan"),
    )


def towards(theta_deg: float, phi_deg: float = 0.0) -> FloatArray:
    """Unit vector (3,)."""
    return unit_from_angles_deg(theta_deg, phi_deg)
