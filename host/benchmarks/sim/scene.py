"""scene.py: the virtual goniophotometer as a Radiance scene: beam, port, receiver sphere and a sample.

Lengths in mm, the sample frame of CONVENTIONS.md: source and port stand where the light comes from, so that long slats
lie along an axis, as octrees like it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
RECEIVER_MM = 1020.0
# The lamp's radiance: any number, it falls out.
RADIANCE = 1e6
# Radiance tells the source's light at the port by rays that the receiver would stop: the port stands just outside it.
PORT_OUTSIDE_MM = 1.0


@dataclass(frozen=True)
class Beam:
    """A distant source seen through a round port."""

    opening_deg: float = 0.5
    diameter_mm: float = 65.0

    @property
    def power(self) -> float:
        """Radiance times the cone's solid angle times the port's area: what mkpmap divides among its photons."""
        cone_sr = 2 * np.pi * (1 - np.cos(np.radians(self.opening_deg / 2)))
        return float(RADIANCE * cone_sr * np.pi * self.diameter_mm**2 / 4)


@dataclass
class Scene:
    """Materials and polygons of a sample, in its own frame."""

    materials: list[str] = field(default_factory=list)
    polygons: list[tuple[str, FloatArray]] = field(default_factory=list)  # modifier; corners (n, 3)
    receiver_mm: float = RECEIVER_MM
    modifiers: list[str] = field(default_factory=list)  # of the sample's own surfaces, kept out of the map

    def material(self, name: str, kind: str, *numbers: float, words: Sequence[str] = ()) -> None:
        """A primitive without modifier: Radiance's own kinds and their numbers."""
        values = " ".join(f"{value:.9g}" for value in numbers)
        text = " ".join([str(len(words)), *words])
        self.materials.append(f"void {kind} {name}\n{text}\n0\n{len(numbers)} {values}\n")
        self.modifiers.append(name)

    def sheet(self, name: str, half_side_mm: float, z_mm: float = 0.0) -> None:
        """A square across the normal, its front to +z."""
        a = half_side_mm
        corners = np.array([(-a, -a, z_mm), (a, -a, z_mm), (a, a, z_mm), (-a, a, z_mm)], dtype=np.float64)
        self.polygons.append((name, corners))

    def text(self, incident_deg: tuple[float, float], beam: Beam) -> str:
        """The whole scene with light from the incident direction."""
        towards = unit(*incident_deg)
        away = (self.receiver_mm + PORT_OUTSIDE_MM) * towards
        sun, port, aim = (" ".join(f"{value:.12g}" for value in v) for v in (towards, away, -towards))
        lines = [
            f"void light lamp\n0\n0\n3 {RADIANCE} {RADIANCE} {RADIANCE}\n",
            f"lamp source sun\n0\n0\n4 {sun} {beam.opening_deg:.9g}\n",
            "void antimatter port\n1 void\n0\n0\n",
            f"port ring stop\n0\n0\n8 {port} {aim} 0 {beam.diameter_mm / 2:.9g}\n",
            "void antimatter receiver\n1 void\n0\n0\n",
            f"receiver bubble ball\n0\n0\n4 0 0 0 {self.receiver_mm}\n",
            *self.materials,
        ]
        for number, (name, corners) in enumerate(self.polygons):
            values = " ".join(f"{value:.12g}" for value in corners.ravel())
            lines.append(f"{name} polygon s{number}\n0\n0\n{corners.size} {values}\n")
        return "\n".join(lines)

    def device_text(self, depth_mm: float) -> str:
        """The sample alone in genBSDF's frame: +z into the room and nothing beyond z = 0. Its front to the exterior."""
        lines = list(self.materials)
        for number, (name, corners) in enumerate(self.polygons):
            turned = corners * (-1.0, 1.0, -1.0) - (0.0, 0.0, depth_mm)
            values = " ".join(f"{value:.12g}" for value in turned.ravel())
            lines.append(f"{name} polygon s{number}\n0\n0\n{corners.size} {values}\n")
        return "\n".join(lines)


def unit(theta_deg: float, phi_deg: float) -> FloatArray:
    """Unit vector towards (theta, phi), shape (3,)."""
    theta, phi = np.radians([theta_deg, phi_deg])
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


@dataclass(frozen=True)
class ArcPiece:
    """A piece of a slat's profile in the plane (y, z); angles from +y towards +z."""

    y_mm: float
    z_mm: float
    radius_mm: float
    start_rad: float
    sweep_rad: float
    material: str

    def points(self, facets: int) -> FloatArray:
        """Ends of its facets, shape (facets + 1, 2). Each facet's corners are on the arc."""
        angle = self.start_rad + self.sweep_rad * np.linspace(0, 1, facets + 1)
        return np.stack([self.y_mm + self.radius_mm * np.cos(angle), self.z_mm + self.radius_mm * np.sin(angle)], 1)


@dataclass(frozen=True)
class LinePiece:
    """A straight piece of a slat's profile."""

    y0_mm: float
    z0_mm: float
    y1_mm: float
    z1_mm: float
    material: str

    def points(self, facets: int) -> FloatArray:
        """Its two ends: a plane needs no facets."""
        del facets
        return np.array([(self.y0_mm, self.z0_mm), (self.y1_mm, self.z1_mm)])


Piece = ArcPiece | LinePiece


def add_slats(
    scene: Scene,
    profile: Sequence[Piece],
    *,
    pitch_mm: float,
    slats: Sequence[float],
    half_length_mm: float,
    facets: int,
) -> None:
    """Slats of one profile along x, slat i shifted by i pitches along y. Arcs become `facets` flat strips each."""
    ends = np.array([-half_length_mm, half_length_mm, half_length_mm, -half_length_mm])
    for piece in profile:
        points = piece.points(facets)
        for slat in slats:
            shifted = points + np.array([slat * pitch_mm, 0.0])
            for (y0, z0), (y1, z1) in pairwise(shifted):
                corners = np.stack([ends, np.array([y0, y0, y1, y1]), np.array([z0, z0, z1, z1])], 1)
                scene.polygons.append((piece.material, corners))
