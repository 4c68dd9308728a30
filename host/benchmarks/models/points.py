"""points.py: datasets of known samples: points over the hemispheres in three arrangements, with and without noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag, Symmetry
from gonio.dataset.scattering import FloatArray, Scattering
from gonio.geometry.cells import cells
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.model.hemisphere import tangent_axes

CHANNEL = "visible"
_BELOW = np.array([1.0, 1.0, -1.0])
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))


@dataclass(frozen=True)
class Noise:
    """Gaussian noise of each point: sigma^2 = (relative DSF)^2 + constant^2."""

    relative: float = 0.01
    constant_per_sr: float = 0.002
    seed: int = 20

    def variance(self, dsf: FloatArray) -> FloatArray:
        """Of points with the true DSF (n,) [1/sr^2]."""
        return np.asarray((self.relative * dsf) ** 2 + self.constant_per_sr**2)


def fibonacci(count: int) -> FloatArray:
    """Unit vectors (count, 3), z > 0, evenly over the hemisphere's solid angle on a spiral."""
    number = np.arange(count)
    z = 1.0 - (number + 0.5) / count
    across = np.sqrt(1.0 - z**2)
    return np.column_stack((across * np.cos(_GOLDEN * number), across * np.sin(_GOLDEN * number), z))


def polar_grid(count: int) -> FloatArray:
    """About `count` unit vectors on a grid of equal steps of theta and phi, twice as many in phi as in theta."""
    rings = round(np.sqrt(count / 2.0))
    theta = (np.arange(rings) + 0.5) * 90.0 / rings
    phi = np.arange(2 * rings) * 180.0 / rings
    return unit_from_angles_deg(np.repeat(theta, len(phi)), np.tile(phi, rings))


def jittered(count: int) -> FloatArray:
    """About `count` unit vectors, one at random in each cell of a grid of equal solid angle."""
    rng = np.random.default_rng(3)
    rings = round(np.sqrt(count / 4.0))
    across = 4 * rings
    z = (np.repeat(np.arange(rings), across) + rng.random(rings * across)) / rings
    phi = (np.tile(np.arange(across), rings) + rng.random(rings * across)) / across * 2.0 * np.pi
    s = np.sqrt(1.0 - z**2)
    return np.column_stack((s * np.cos(phi), s * np.sin(phi), np.maximum(z, 1e-4)))


def cap(count: int, centre: FloatArray, half_angle_deg: float) -> FloatArray:
    """Unit vectors (count, 3), evenly on a spiral within `half_angle_deg` of the unit vector `centre` (3,)."""
    number = np.arange(count)
    z = 1.0 - (number + 0.5) / count * (1.0 - np.cos(np.radians(half_angle_deg)))
    across = np.sqrt(1.0 - z**2)
    turn = _GOLDEN * number
    return np.column_stack((across * np.cos(turn), across * np.sin(turn), z)) @ tangent_axes(centre)


def refined(count: int, centre: FloatArray, half_angle_deg: float = 7.5) -> FloatArray:
    """About `count` unit vectors, z > 0: half of them evenly over the hemisphere outside of a cap about `centre` (3,),
    half in it: as paper [0] merges its hemispherical scan with one of the retro-reflected peak (+-7.5 degrees)."""
    near = cap(count // 2, centre, half_angle_deg)
    rest = fibonacci(count - count // 2)
    outside = rest @ centre < np.cos(np.radians(half_angle_deg))
    return np.concatenate((rest[outside], near[near[:, 2] > 1e-3]))


def retro_refined(count: int, incident: FloatArray) -> FloatArray:
    """`refined` about the retro direction of the incident unit vector (3,)."""
    return refined(count, incident * np.array([1.0, 1.0, np.sign(incident[2])]))


# Where a dataset has its points: count and incident unit vector (3,) -> unit vectors (n, 3), z > 0.
Arrangement = Callable[[int, FloatArray], FloatArray]
ARRANGEMENTS: dict[str, Arrangement] = {
    "refined": retro_refined,
    "even": lambda count, _: fibonacci(count),
    "polar": lambda count, _: polar_grid(count),
    "jittered": lambda count, _: jittered(count),
}


def sampled(
    sample: Scattering,
    incident_deg: Sequence[tuple[float, float]],
    count: int,
    arrangement: Arrangement = ARRANGEMENTS["even"],
    *,
    noise: Noise | None = None,
    symmetry: Symmetry = "isotropic",
    name: str = "judge",
) -> Dataset:
    """A dataset of `sample` at incident (theta, phi) with about `count` points in each hemisphere that it covers
    (behind, the arrangement's mirror image). Solid angles are the points' cells; the front faces the interior."""
    rng = None if noise is None else np.random.default_rng(noise.seed)
    distributions = []
    for theta, phi in incident_deg:
        incident = unit_from_angles_deg([theta], [phi])
        upper = arrangement(count, incident[0])
        solid_angle_sr = cells(upper).solid_angle_sr
        sides = [s for s in (True, False) if sample.covers(incident_front=theta <= 90.0, outgoing_front=s)]
        outgoing = np.concatenate([upper if side else upper * _BELOW for side in sides])
        solid_angle = np.tile(solid_angle_sr, len(sides))
        truth = sample.dsf_per_sr(incident, outgoing)
        distributions.append(_distribution((theta, phi), outgoing, solid_angle, truth, noise, rng))
    return Dataset(
        distributions,
        sample_name=name,
        front_faces="interior",
        polarisation="unpolarised",
        symmetry=symmetry,
        thickness_mm=1.0,
        manufacturer="gonio",
        provenance={"made": "benchmarks/models: closed form or simulation"},
    )


def _distribution(
    incident_deg: tuple[float, float],
    outgoing: FloatArray,
    solid_angle: FloatArray,
    truth: FloatArray,
    noise: Noise | None,
    rng: np.random.Generator | None,
) -> Distribution:
    variance = np.zeros_like(truth) if noise is None else noise.variance(truth)
    value = truth if rng is None else truth + np.sqrt(variance) * rng.standard_normal(len(truth))
    theta, phi = angles_deg_from_unit(outgoing)
    n = len(truth)
    return Distribution(
        incident_theta_deg=incident_deg[0],
        incident_phi_deg=incident_deg[1],
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=value,
        variance_per_sr2=variance,
        signal=value.copy(),
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.full(n, PointFlag.SIMULATED, dtype=np.uint16),
        solid_angle_sr=solid_angle,
        time_ns=np.zeros(n, dtype=np.int64),
        channel=CHANNEL,
    )
