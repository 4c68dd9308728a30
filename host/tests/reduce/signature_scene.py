"""signature_scene.py: a closed-form sample and its beam as point lists with cells: what the signature tests look at."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.cells import cells
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, tangent_frame, unit_from_angles_deg
from gonio.geometry.pitch import reach_rad
from gonio.reduce.integrals.beam import Beam, measure_beam
from gonio.simulate.closed_form import Truth

FloatArray = NDArray[np.float64]

BEAM = """
[beam]
kind = "focused"
divergence_deg = 1.0
edge_deg = 0.3
"""


def truth_of(folder: Path, components: str) -> Truth:
    path = folder / "scene.toml"
    path.write_text(f"[sample]\ncomponents = [{components}]\n{BEAM}")
    return Truth.from_scenario(path)


def spiral(about_deg: tuple[float, float], radius_deg: float, pitch_deg: float, step_deg: float = 0.02) -> FloatArray:
    """Directions (n, 3) of an Archimedean spiral flown at constant speed."""
    length = (np.arange(int(np.pi * radius_deg**2 / pitch_deg / step_deg)) + 0.5) * step_deg
    polar_deg = np.sqrt(length * pitch_deg / np.pi)
    azimuth, polar = 2.0 * np.pi * polar_deg / pitch_deg, np.radians(polar_deg)
    e1, e2, pole = tangent_frame(unit_from_angles_deg(*about_deg))
    across = np.cos(azimuth)[:, None] * e1 + np.sin(azimuth)[:, None] * e2
    return np.asarray(np.sin(polar)[:, None] * across + np.cos(polar)[:, None] * pole)


def circles(pitch_deg: float, limit_deg: float = 180.0, step_deg: float = 0.5) -> FloatArray:
    """Directions (n, 3) on circles about the normal."""
    found = []
    for theta_deg in np.arange(0.5 * pitch_deg, limit_deg, pitch_deg):
        count = max(8, int(360.0 * np.sin(np.radians(theta_deg)) / step_deg))
        found.append(unit_from_angles_deg(theta_deg, np.arange(count) * 360.0 / count))
    return np.concatenate(found)


def distribution(
    incident_deg: tuple[float, float],
    unit: FloatArray,
    dsf_per_sr: FloatArray,
    path: NDArray[np.int64] | None = None,
    noise_per_sr: float = 0.0,
    seed: int = 1,
) -> Distribution:
    """Points with cells that end at 1.5 times their path's pitch; `path` None: of one path."""
    n = len(unit)
    number = np.zeros(n, dtype=np.int64) if path is None else path
    found = cells(unit, reach_rad=reach_rad(unit, number))
    theta_deg, phi_deg = angles_deg_from_unit(unit)
    dsf = dsf_per_sr + noise_per_sr * np.random.default_rng(seed).standard_normal(n)
    return Distribution(
        incident_theta_deg=incident_deg[0],
        incident_phi_deg=incident_deg[1],
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        dsf_per_sr=dsf,
        variance_per_sr2=np.full(n, noise_per_sr**2),
        signal=dsf.copy(),
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=found.solid_angle_sr,
        time_ns=np.zeros(n, dtype=np.int64),
        linear_solid_angle_sr=found.linear_sr,
        path=number.astype(np.int32),
    )


def beam_scan(truth: Truth, pitch_deg: float = 0.06, off_deg: float = 0.0) -> tuple[Beam, Distribution]:
    """The free beam of a scene, measured on a spiral; `off_deg`: its axis off straight through, along +X."""
    unit = spiral((180.0, 0.0), 2.0, pitch_deg)
    axis = unit_from_angles_deg(180.0 - off_deg, 0.0)
    signal = truth.beam_per_sr(angle_between_deg(unit, axis))
    beam = measure_beam(unit, signal, np.zeros(len(unit)), np.ones(len(unit), dtype=bool))
    found = distribution((0.0, 0.0), unit, signal / beam.p_i)
    found.theta_deg, found.phi_deg = beam.polar_deg, beam.azimuth_deg
    found.solid_angle_sr, found.linear_solid_angle_sr = beam.solid_angle_sr, beam.linear_sr
    found.p_i, found.p_i_u_rel = beam.p_i, beam.p_i_u_rel
    return beam, found
