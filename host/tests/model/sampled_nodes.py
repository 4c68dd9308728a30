"""sampled_nodes.py: datasets, points and nodes of known functions for the tests of the fitted model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sampled_points import distribution, spread

from gonio.dataset.bsdf import Dataset
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.nodes.frames import level_axes, tangents
from gonio.model.nodes.node import Node

__all__ = ["MIRROR", "Moving", "dataset", "directions", "distribution", "gaussian", "node_with", "spread", "towards"]
FloatArray = NDArray[np.float64]
MIRROR = np.array([-1.0, -1.0, 1.0])


def directions(n: int, seed: int = 1) -> FloatArray:
    """Unit vectors (n, 3) all over the upper hemisphere; the last two: pole and horizon."""
    z, phi = np.random.default_rng(seed).random((2, n))
    phi *= 2.0 * np.pi
    z[-2:] = 1.0, 0.0
    across = np.sqrt(1.0 - z**2)
    return np.column_stack((across * np.cos(phi), across * np.sin(phi), z))


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
