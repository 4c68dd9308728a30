"""radiance_sheet.py: a flat sheet of one of Radiance's materials, asked through rtrace."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.sim.radiance import run
from benchmarks.sim.scene import unit

FloatArray = NDArray[np.float64]
SOURCE_DEG = 0.05  # small: Radiance adds the source's solid angle / 4 pi to the square of a roughness
RADIANCE = 1e6
# Nothing sampled at random: the source alone, straight; highlights of rough materials belong to it.
DIRECT = ["rtrace", "-h", "-fda", "-ab", "0", "-dj", "0", "-ds", "0", "-dt", "0", "-dc", "1", "-ss", "0"]


def sheet(material: str, side_mm: float = 1e4, z_mm: float = 0.0) -> str:
    """A square of the material named `m`, which `material` defines."""
    a = side_mm
    return (
        f"{material}\nm polygon at{z_mm:g}\n0\n0\n12 {-a} {-a} {z_mm} {a} {-a} {z_mm} {a} {a} {z_mm} {-a} {a} {z_mm}\n"
    )


def _trace(scene: str, rays: FloatArray, options: list[str], where: Path) -> FloatArray:
    where.mkdir(parents=True, exist_ok=True)
    (where / "scene.rad").write_text(scene)
    (where / "scene.oct").write_bytes(run(["oconv", "-w", "scene.rad"], where).output)
    found = run([*DIRECT, *options, "scene.oct"], where, rays.astype(np.float64).tobytes()).output
    return np.array(found.split(), dtype=np.float64).reshape(len(rays), 3)[:, 0]


def dsf_per_sr(material: str, incident_deg: tuple[float, float], outgoing: FloatArray, where: Path) -> FloatArray:
    """DSF [1/sr] towards unit vectors (n, 3) on the lit side, the mirror image left out."""
    towards = unit(*incident_deg)
    lamp = f"void light lamp\n0\n0\n3 {RADIANCE} {RADIANCE} {RADIANCE}\nlamp source sun\n0\n0\n4 "
    lamp += " ".join(f"{value:.12g}" for value in (*towards, SOURCE_DEG)) + "\n"
    rays = np.concatenate([1000.0 * outgoing, -outgoing], 1)
    radiance = _trace(lamp + sheet(material), rays, ["-lr", "1", "-lw", "1e-9"], where)
    irradiance = RADIANCE * 2 * np.pi * (1 - np.cos(np.radians(SOURCE_DEG / 2)))
    return radiance * outgoing[:, 2] / (irradiance * towards[2])


def ideal_part(objects: str, theta_deg: float, *, through: bool, where: Path) -> float:
    """Share of the light along one ray that is reflected or goes through, by ideal paths alone, all followed."""
    pole = -1 if through else 1
    glow = f"void glow sky\n0\n0\n4 1 1 1 0\nsky source dome\n0\n0\n4 0 0 {pole} 180\n"
    towards = unit(theta_deg, 0.0)
    ray = np.concatenate([1000.0 * towards, -towards])[None]
    return float(_trace(glow + objects, ray, ["-lr", "40", "-lw", "1e-7", "-st", "0"], where)[0])
