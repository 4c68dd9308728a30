"""frame.py: the four components of a tensor tree, and where its cells lie in the sample's frame.

A tree's coordinates lie in [0, 1]. T4: the incident direction's place in the square, negated ((-x, -y), so that mirror
and straight-through directions keep their place), then the outgoing direction's. T3 (isotropic samples): the first is
(1 - sin(theta_i)) / 2, so only its lower half is used; the outgoing direction is turned about z until -incident lies on
+x. x and y are Radiance's for both sides (CONVENTIONS.md); "Front" is light from the exterior, Radiance's -z.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Scattering
from gonio.formats.tensor.square import IndexArray, cell_points, on_diagonal, square_from_disc
from gonio.formats.window.klems import LightSide, Process
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Component:
    """Light that arrives at one side of the sample and leaves from one."""

    process: Process
    side: LightSide

    @property
    def incident_z(self) -> float:
        """Sign of z, in Radiance's frame, of the incident direction."""
        return -1.0 if self.side == "Front" else 1.0

    @property
    def outgoing_z(self) -> float:
        return self.incident_z if self.process == "Reflection" else -self.incident_z

    def __str__(self) -> str:
        return f"{self.process} {self.side}"


COMPONENTS = tuple(Component(process, side) for process in ("Transmission", "Reflection") for side in ("Front", "Back"))


def turned(unit: FloatArray, front_faces: Side) -> FloatArray:
    """Unit vectors (..., 3) from the sample's frame to Radiance's, or back: half a turn about y, or nothing."""
    if front_faces == "interior":
        return unit
    if front_faces == "exterior":
        return np.asarray(unit * np.array([-1.0, 1.0, -1.0]))
    raise UsageError("it is not declared which way the sample's front faces: give --front exterior or --front interior")


def covered(scattering: Scattering, front_faces: Side) -> list[Component]:
    """Components for which the scattering function has values."""
    at_front = {z: bool(turned(np.array([0.0, 0.0, z]), front_faces)[2] > 0.0) for z in (-1.0, 1.0)}
    return [
        c
        for c in COMPONENTS
        if scattering.covers(incident_front=at_front[c.incident_z], outgoing_front=at_front[c.outgoing_z])
    ]


def place_of(incident: FloatArray, outgoing: FloatArray, dimensions: int) -> FloatArray:
    """Tree coordinates (m, dimensions) in [0, 1) of pairs of unit vectors (m, 3) in Radiance's frame."""
    if dimensions == 4:
        pair = (square_from_disc(-incident[:, :2]), square_from_disc(outgoing[:, :2]))
        place = np.concatenate(pair, axis=1)
    else:
        radius = np.hypot(incident[:, 0], incident[:, 1])
        at_normal = radius < 1e-12
        safe = np.where(at_normal, 1.0, radius)
        # Cosine and sine of the azimuth of -incident; at the normal atan2(-0, -0) has Radiance turn by half a circle.
        c = np.where(at_normal, -1.0, -incident[:, 0] / safe)
        s = np.where(at_normal, 0.0, -incident[:, 1] / safe)
        x, y = outgoing[:, 0], outgoing[:, 1]
        out = square_from_disc(np.stack((c * x + s * y, c * y - s * x), axis=1))
        place = np.concatenate((np.minimum(0.5 - 0.5 * radius, np.nextafter(0.5, 0.0))[:, None], out), axis=1)
    return np.clip(place, 0.0, np.nextafter(1.0, 0.0))


def incident_points(index: IndexArray, level: int, order: int, *, diagonal: bool) -> tuple[FloatArray, FloatArray]:
    """Points in incident cells (n, 1 or 2): Radiance's (x, y) and |z| as unit vectors (n, q, 3), weights (n, q).

    Weights sum to 1: they form the mean over the cell's projected solid angle (for T3, sin cos d(theta)).
    """
    if index.shape[1] == 2:
        points, weight = cell_points(index, level, order, diagonal=diagonal)
        weight = weight * points[:, :, 2]
        points[:, :, :2] *= -1.0
    else:
        node, gauss = np.polynomial.legendre.leggauss(order)
        outer = 1.0 - 2.0 * index[:, 0] / (1 << level)
        low, high = np.arcsin(np.maximum(outer - 2.0 / (1 << level), 0.0)), np.arcsin(outer)
        theta = low[:, None] + (high - low)[:, None] * (0.5 + 0.5 * node)
        points = np.stack((-np.sin(theta), np.zeros_like(theta), np.cos(theta)), axis=-1)
        weight = gauss * np.sin(2.0 * theta)
    return points, weight / weight.sum(axis=1, keepdims=True)


def incident_on_diagonal(index: IndexArray, level: int) -> NDArray[np.bool_]:
    """Which incident cells (n, 1 or 2) `incident_points` takes as two triangles."""
    if index.shape[1] == 2:
        return on_diagonal(index, level)
    return np.zeros(len(index), dtype=np.bool_)
