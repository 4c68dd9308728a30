"""analytic_cases.py: components with known parameters, points drawn from them, and integrals by scipy's own rules."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.geometry.cells import cells
from gonio.geometry.directions import angles_deg_from_unit
from gonio.model.analytic import Component

FloatArray = NDArray[np.float64]
ONE = np.zeros(1, dtype=np.int64)


def light(theta_deg: float, phi_deg: float = 0.0) -> FloatArray:
    """Unit vector (1, 3)."""
    t, p = np.radians(theta_deg), np.radians(phi_deg)
    return np.array([[np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]])


def hemisphere(n: int) -> FloatArray:
    """Unit vectors (n, 3) of equal solid angle on a golden spiral, z > 0."""
    z = (np.arange(n) + 0.5) / n
    phi = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(n)
    return np.stack((np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z), axis=-1)


def about(centre: FloatArray, radius_deg: float, n: int) -> FloatArray:
    """Unit vectors (n, 3) on a spiral within radius of a unit vector (3,), those above the horizon."""
    a = np.radians(radius_deg) * np.sqrt((np.arange(n) + 0.5) / n)
    phi = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(n)
    e1 = np.cross(centre, [0.0, 1.0, 0.0])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(centre, e1)
    unit = np.cos(a)[:, None] * centre + np.sin(a)[:, None] * (np.cos(phi)[:, None] * e1 + np.sin(phi)[:, None] * e2)
    return np.asarray(unit[unit[:, 2] > 0.001])


def integral_by_scipy(component: Component, theta_deg: float, centre: float | None = None) -> float:
    """Hemispherical integral in polar coordinates about the normal of the disc of direction cosines: the trapezoidal
    rule along circles (periodic, so it converges geometrically), scipy's adaptive rule across; `centre`: where along
    the radius the peak lies, if not at sin(theta)."""
    own = light(theta_deg)
    phi = 2.0 * np.pi * np.arange(4096) / 4096
    which = np.zeros(len(phi), dtype=np.int64)

    def ring(r: float) -> float:
        z = np.full(len(phi), np.sqrt(max(1.0 - r * r, 0.0)))
        outgoing = np.stack((r * np.cos(phi), r * np.sin(phi), z), axis=-1)
        return 2.0 * np.pi * float(component.bsdf_per_sr(own, outgoing, which).mean()) * r

    c = float(np.sin(np.radians(theta_deg))) if centre is None else centre
    breaks = sorted({0.0, 1.0, *(x for x in (c - 0.05, c, c + 0.05) if 0.0 < x < 1.0)})
    return sum(
        float(quad(ring, lower, upper, epsabs=1e-10, epsrel=1e-8, limit=100)[0]) for lower, upper in pairwise(breaks)
    )


def measured(
    parts: dict[bool, Component],
    theta_deg: float,
    *,
    noise: float = 0.0,
    n: int = 3000,
    seed: int = 1,
    phi_deg: float = 0.0,
    from_front: bool = True,
    channel: str = "visible",
) -> Distribution:
    """Points of components by reflection (True) or transmission (False), half on spirals about mirror and retro
    directions, with independent relative noise and its variance; rho_measured and tau_measured exact."""
    random = np.random.default_rng(seed)
    own = light(theta_deg, phi_deg)
    units, dsfs, rows = [], [], {}
    for reflection, component in parts.items():
        peaks = (about(own[0] * np.array(sign), 6.0, n // 4) for sign in ((-1.0, -1.0, 1.0), (1.0, 1.0, 1.0)))
        unit = np.concatenate((hemisphere(n // 2), *peaks))
        dsf = component.dsf_per_sr(own, unit, np.zeros(len(unit), dtype=np.int64))
        up = reflection == from_front
        units.append(unit * np.array([1.0, 1.0, 1.0 if up else -1.0]))
        dsfs.append(dsf)
        name = "rho" if reflection else "tau"
        rows[f"{name}_measured"] = float(component.integral(np.array([theta_deg]))[0])
        rows[f"{name}_u"] = 0.001
    unit, truth = np.concatenate(units), np.concatenate(dsfs)
    sigma = noise * truth + 1e-7
    theta, phi = angles_deg_from_unit(unit)
    count = len(truth)
    return Distribution(
        incident_theta_deg=theta_deg if from_front else 180.0 - theta_deg,
        incident_phi_deg=phi_deg,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=truth + (sigma * random.standard_normal(count) if noise else 0.0),
        variance_per_sr2=sigma**2,
        signal=truth,
        normalisation=np.ones(count),
        count=np.ones(count, dtype=np.int32),
        flags=np.full(count, PointFlag.MEASURED, dtype=np.uint16),
        solid_angle_sr=cells(unit).solid_angle_sr,
        time_ns=np.zeros(count, dtype=np.int64),
        channel=channel,
        integrals=rows,
    )


def dataset(*distributions: Distribution) -> Dataset:
    """Isotropic, as its user declared."""
    return Dataset(list(distributions), sample_name="closed form", symmetry="isotropic", front_faces="exterior")
