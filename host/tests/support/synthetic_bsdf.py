"""synthetic_bsdf.py: datasets with a known answer: Lambertian and Gaussian lobe, a masked zone; cells by scipy."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import SphericalVoronoi

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.reduce.integrals.hemispheres import integrals
from gonio.reduce.integrals.peaks import evaluated_peak

FloatArray = NDArray[np.float64]
SIGMA_DEG = 1.2


def sphere_points(count: int) -> FloatArray:
    """Fibonacci lattice, unit vectors (count, 3)."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    phi = np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - z**2)
    return np.stack((r * np.cos(phi), r * np.sin(phi), z), axis=1)


def spiral_about(theta_deg: float, phi_deg: float, radius_deg: float, pitch_deg: float) -> FloatArray:
    """Archimedean spiral about a direction, points one pitch apart, unit vectors (n, 3)."""
    n = int(np.pi * (radius_deg / pitch_deg) ** 2)
    r = radius_deg * np.sqrt((np.arange(n) + 0.5) / n)
    turn = 2 * np.pi * r / pitch_deg
    local = unit_from_angles_deg(r, np.degrees(turn))
    t, p = np.radians([theta_deg, phi_deg])
    about_y = np.array([[np.cos(t), 0, np.sin(t)], [0, 1, 0], [-np.sin(t), 0, np.cos(t)]])
    about_z = np.array([[np.cos(p), -np.sin(p), 0], [np.sin(p), np.cos(p), 0], [0, 0, 1]])
    return np.asarray(local @ (about_z @ about_y).T)


def distribution(
    incident: tuple[float, float],
    units: FloatArray,
    dsf: Callable[[FloatArray], FloatArray],
    *,
    masked_below_deg: float = 0.0,
    channel: str = "visible",
) -> Distribution:
    """Points with exact values; those within `masked_below_deg` of the source are masked as shadowed."""
    voronoi = SphericalVoronoi(units, 1.0)
    cells = voronoi.calculate_areas()
    theta, phi = angles_deg_from_unit(units)
    values = dsf(units)
    flags = np.zeros(len(units), dtype=np.uint16)
    shaded = angle_between_deg(units, unit_from_angles_deg(*incident)) < masked_below_deg
    flags[shaded] = PointFlag.SHADOWED
    values = np.where(shaded, np.nan, values)
    n = len(units)
    return Distribution(
        *incident,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=values,
        variance_per_sr2=np.where(shaded, np.nan, (0.002 * np.nan_to_num(values)) ** 2),
        signal=values * 1e5,
        normalisation=np.ones(n),
        count=np.full(n, 10, dtype=np.int32),
        flags=flags,
        solid_angle_sr=cells,
        time_ns=np.arange(n, dtype=np.int64) * 1_000_000,
        channel=channel,
        p_i=1e5,
        p_i_u_rel=0.001,
    )


def lobe_per_sr(units: FloatArray, about_deg: tuple[float, float], integral: float) -> FloatArray:
    """Gaussian lobe of SIGMA_DEG, its solid-angle integral given (small-angle normalisation)."""
    angle = np.radians(angle_between_deg(units, unit_from_angles_deg(*about_deg)))
    sigma = np.radians(SIGMA_DEG)
    return np.asarray(integral / (2 * np.pi * sigma**2) * np.exp(-0.5 * (angle / sigma) ** 2))


def lambert_and_mirror(
    incident_thetas_deg: tuple[float, ...] = (0.0, 30.0, 60.0),
    *,
    reflectance: float = 0.5,
    transmittance: float = 0.1,
    mirror: float = 0.2,
    coarse: int = 3000,
) -> Dataset:
    """Lambertian in reflection and transmission and a mirror lobe, isotropic, front facing the exterior."""
    parts = []
    for theta in incident_thetas_deg:
        about = (theta, 180.0)
        units = np.concatenate([sphere_points(coarse), spiral_about(*about, 6.0, 0.4)])

        def dsf(u: FloatArray, about: tuple[float, float] = about) -> FloatArray:
            diffuse = np.where(u[:, 2] > 0, reflectance, transmittance) / np.pi * np.abs(u[:, 2])
            return np.asarray(diffuse + lobe_per_sr(u, about, mirror) * (u[:, 2] > 0))

        parts.append(distribution((theta, 0.0), units, dsf, masked_below_deg=2.5))
    return Dataset(
        parts,
        sample_name="synthetic: Lambertian and mirror lobe",
        front_faces="exterior",
        polarisation="unpolarised",
        symmetry="isotropic",
        thickness_mm=3.0,
        manufacturer="gonio tests",
    )


def with_evaluation(d: Distribution, coarse: int = 3000) -> Distribution:
    """The distribution with its integrals and the fit of the spiral that `lambert_and_mirror` puts behind `coarse`."""
    d.integrals = integrals(d)
    name = f"mirror {d.incident_theta_deg:g}/{d.incident_phi_deg:g}"
    points = len(d.theta_deg)
    peak, results = evaluated_peak(d, slice(coarse, points), name)
    assert peak is not None
    results.into(d)
    d.integrals |= {f"peak {name} first_point": float(coarse), f"peak {name} points": float(points - coarse)}
    return d
