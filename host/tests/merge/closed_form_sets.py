"""closed_form_sets.py: datasets of known scattering for the tests of merging, in memory, noise and effects drawn."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag, Polarisation
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, tangent_frame, unit_from_angles_deg
from gonio.merge.points import path_numbers, taken, units
from gonio.merge.sources import Source, sources_of
from gonio.reduce.coverage import cells_of_paths

FloatArray = NDArray[np.float64]
Truth = Callable[[FloatArray], FloatArray]
RETRO_30 = unit_from_angles_deg(30.0, 0.0)


def lambertian(rho: float = 0.6) -> Truth:
    """DSF of a white reflector."""
    return lambda unit: rho / np.pi * np.maximum(unit[:, 2], 0.0)


def lobe(height: float, sigma_deg: float, centre: FloatArray, ground: float = 0.05) -> Truth:
    """A Gaussian lobe on a Lambertian ground."""

    def dsf(unit: FloatArray) -> FloatArray:
        angle = angle_between_deg(unit, centre)
        return lambertian(ground * np.pi)(unit) + height * np.exp(-0.5 * (angle / sigma_deg) ** 2)

    return dsf


def rings(step_deg: float, start_deg: float = 0.0) -> FloatArray:
    """Front hemisphere in the order flown: circles about the normal, samples half as far apart as the circles."""
    parts = []
    for theta in np.arange(0.5 * step_deg + start_deg, 90.0, step_deg):
        n = max(8, round(720.0 / step_deg * np.sin(np.radians(theta))))
        parts.append(unit_from_angles_deg(np.full(n, theta), 360.0 * np.arange(n) / n))
    return np.concatenate(parts)


def spiral(centre: FloatArray, radius_deg: float, pitch_deg: float) -> FloatArray:
    """From the centre outwards, samples half a pitch apart."""
    turns = radius_deg / pitch_deg
    n = int(2.0 * np.pi * turns**2)
    azimuth = 2.0 * np.pi * turns * np.sqrt(np.arange(n) / n)
    e1, e2, pole = tangent_frame(centre)
    polar = np.radians(pitch_deg * azimuth / (2.0 * np.pi))
    ring = np.cos(azimuth)[:, None] * e1 + np.sin(azimuth)[:, None] * e2
    return np.asarray(np.sin(polar)[:, None] * ring + np.cos(polar)[:, None] * pole)


def distribution(
    unit: FloatArray,
    truth: Truth,
    *,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    incident: tuple[float, float] = (30.0, 0.0),
    name: str = "coarse 30/0",
    effects: dict[str, float] | None = None,
    drawn: dict[str, float] | None = None,
    floor: float = 1e-4,
    channel: str = "visible",
) -> Distribution:
    """Values of `truth` at `unit` (n, 3), with relative noise on a floor; `effects` are relative columns, `drawn` how
    many standard deviations each is off."""
    exact = truth(unit)
    n = len(exact)
    sigma = noise * exact + (floor if noise else 0.0)
    values = exact + (rng.standard_normal(n) * sigma if rng is not None else 0.0)
    columns = {key: u * exact for key, u in (effects or {}).items()}
    for key, times in (drawn or {}).items():
        values = values + times * columns[key]
    theta, phi = angles_deg_from_unit(unit)
    found = Distribution(
        incident_theta_deg=incident[0],
        incident_phi_deg=incident[1],
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=values,
        variance_per_sr2=sigma**2,
        signal=1000.0 * values,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=np.zeros(n),
        time_ns=1000 * (1 + np.arange(n, dtype=np.int64)),
        channel=channel,
        p_i=1000.0,
        effects=columns,
        path=np.zeros(n, dtype=np.int32),
        paths=(name,),
    )
    return with_cells(found)


def with_cells(d: Distribution) -> Distribution:
    """Cells as the reduction makes them."""
    unit = units(d)
    found = cells_of_paths(unit, path_numbers(d))
    return replace(d, solid_angle_sr=found.solid_angle_sr, linear_solid_angle_sr=found.linear_sr)


def masked(d: Distribution, where: NDArray[np.bool_], flag: PointFlag = PointFlag.SHADOWED) -> Distribution:
    """With some points masked."""
    found = replace(d, flags=np.where(where, np.uint16(flag), d.flags).astype(np.uint16))
    for values in (found.dsf_per_sr, found.variance_per_sr2, *found.effects.values()):
        values[where] = np.nan
    return found


def dataset(
    *distributions: Distribution, raw: str = "", polarisation: Polarisation = "unpolarised", sample: str = "tile"
) -> Dataset:
    """A dataset whose raw log has the hash `raw`."""
    provenance = {"raw_sha256": [raw]} if raw else {}
    return Dataset(list(distributions), sample_name=sample, polarisation=polarisation, provenance=provenance)


def sources(*datasets: Dataset, same_mount: bool = False) -> list[Source]:
    """As files named a.h5, b.h5 ..."""
    names = "abcdefghij"
    named = [(f"{name}.h5", f"sha-{name}", found) for name, found in zip(names, datasets, strict=False)]
    return sources_of(named, same_mount=same_mount)


def part(d: Distribution, chosen: NDArray[np.bool_]) -> Distribution:
    """Some of the points as a set of their own, with cells of its own."""
    return with_cells(taken(d, chosen))
