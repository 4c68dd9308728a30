"""klems.py: Klems angle bases, and where our directions lie in them (CONVENTIONS.md, "WINDOW XML, Klems bases")."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.dataset.bsdf import Side
from gonio.units.errors import UsageError

LightSide = Literal["Front", "Back"]  # where the light arrives: Front is the exterior
Process = Literal["Transmission", "Reflection"]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Ring:
    """One ring of patches of equal size; patch 0 is centred on azimuth 0, then counter-clockwise."""

    nominal_theta_deg: float
    lower_deg: float
    upper_deg: float
    patches: int

    @property
    def projected_solid_angle_sr(self) -> float:
        """Integral of cos(theta) over one patch."""
        lower, upper = np.sin(np.radians([self.lower_deg, self.upper_deg]))
        return float(np.pi * (upper**2 - lower**2) / self.patches)


@dataclass(frozen=True)
class KlemsBasis:
    """A division of the hemisphere into rings of patches; patches are numbered ring by ring from the pole."""

    name: str  # as WINDOW XML names it
    rings: tuple[Ring, ...]

    @cached_property
    def size(self) -> int:
        return sum(ring.patches for ring in self.rings)

    @cached_property
    def ring_start(self) -> NDArray[np.int64]:
        """Index of each ring's first patch, shape (rings + 1,)."""
        return np.concatenate([[0], np.cumsum([ring.patches for ring in self.rings])]).astype(np.int64)

    @cached_property
    def projected_solid_angle_sr(self) -> FloatArray:
        """L of each patch, shape (size,); sums to pi."""
        return np.concatenate([np.full(ring.patches, ring.projected_solid_angle_sr) for ring in self.rings])

    @cached_property
    def centres_deg(self) -> FloatArray:
        """Nominal polar angle and azimuth of each patch, shape (size, 2)."""
        return np.array(
            [(r.nominal_theta_deg, 360.0 * i / r.patches) for r in self.rings for i in range(r.patches)],
            dtype=np.float64,
        )

    @cached_property
    def bounds_deg(self) -> FloatArray:
        """Polar angle from, to, azimuth from and width in azimuth of each patch, shape (size, 4)."""
        return np.array(
            [
                (r.lower_deg, r.upper_deg, 360.0 * (i - 0.5) / r.patches, 360.0 / r.patches)
                for r in self.rings
                for i in range(r.patches)
            ],
            dtype=np.float64,
        )

    def ring_of(self, polar_deg: ArrayLike) -> NDArray[np.int64]:
        """Ring index of polar angles 0-90 (from the hemisphere's own normal), shape as given."""
        upper = np.array([ring.upper_deg for ring in self.rings])
        found = np.searchsorted(upper, np.asarray(polar_deg, dtype=np.float64), side="right")
        return np.minimum(found, len(self.rings) - 1).astype(np.int64)

    def patch_of(self, polar_deg: ArrayLike, azimuth_deg: ArrayLike) -> NDArray[np.int64]:
        """Patch index of (polar 0-90, azimuth), broadcast shape."""
        ring = self.ring_of(polar_deg)
        count = np.array([r.patches for r in self.rings])[ring]
        within = np.floor(np.asarray(azimuth_deg, dtype=np.float64) * count / 360.0 + 0.5).astype(np.int64) % count
        return np.asarray(self.ring_start[ring] + within)


def basis_from_rings(
    name: str, nominal_deg: Sequence[float], bounds_deg: Sequence[float], counts: Sequence[int]
) -> KlemsBasis:
    """A basis from nominal polar angles (r,), ring limits (r + 1,) from 0 to 90, and patches per ring (r,)."""
    if len(bounds_deg) != len(counts) + 1 or len(nominal_deg) != len(counts) or not counts:
        raise UsageError(f"angle basis {name}: rings, limits and counts do not fit together")
    steps = np.diff(np.asarray(bounds_deg, dtype=np.float64))
    if bounds_deg[0] != 0 or abs(bounds_deg[-1] - 90) > 1e-6 or not np.all(steps > 0) or min(counts) < 1:
        raise UsageError(f"angle basis {name}: ring limits must rise from 0 to 90 degrees and every ring needs a patch")
    rings = zip(nominal_deg, bounds_deg[:-1], bounds_deg[1:], counts, strict=True)
    return KlemsBasis(name, tuple(Ring(float(t), float(lo), float(hi), int(n)) for t, lo, hi, n in rings))


BASES: dict[str, KlemsBasis] = {
    "klems-full": basis_from_rings(
        "LBNL/Klems Full",
        (0, 10, 20, 30, 40, 50, 60, 70, 82.5),
        (0, 5, 15, 25, 35, 45, 55, 65, 75, 90),
        (1, 8, 16, 20, 24, 24, 24, 16, 12),
    ),
    "klems-half": basis_from_rings(
        "LBNL/Klems Half",
        (0, 13, 26, 39, 52, 65, 80.75),
        (0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90),
        (1, 8, 12, 16, 20, 12, 8),
    ),
    "klems-quarter": basis_from_rings(
        "LBNL/Klems Quarter", (0, 18, 36, 54, 76.5), (0, 9, 27, 45, 63, 90), (1, 8, 12, 12, 8)
    ),
}


def basis_named(name: str) -> KlemsBasis:
    """Basis by the name that the command line uses; UsageError names the choices."""
    if name not in BASES:
        raise UsageError(f"no angle basis {name!r}; choose one of {', '.join(BASES)}")
    return BASES[name]


def to_radiance_deg(theta_deg: ArrayLike, phi_deg: ArrayLike, front_faces: Side) -> tuple[FloatArray, FloatArray]:
    """Directions of ours in Radiance's frame (+z into the room, +y up). The turn is its own inverse.

    Shapes as given. Raises UsageError when `front_faces` is undeclared.
    """
    theta = np.asarray(theta_deg, dtype=np.float64)
    phi = np.asarray(phi_deg, dtype=np.float64)
    if front_faces == "interior":
        return theta.copy(), phi % 360.0
    if front_faces == "exterior":
        return 180.0 - theta, (180.0 - phi) % 360.0
    raise UsageError("it is not declared which way the sample's front faces: give --front exterior or --front interior")


def incident_place(theta_r_deg: float, phi_r_deg: float) -> tuple[LightSide, float, float]:
    """Side, polar angle and column azimuth of an incident direction (towards the source) in Radiance's frame."""
    azimuth = (phi_r_deg + 180.0) % 360.0
    return ("Front", 180.0 - theta_r_deg, azimuth) if theta_r_deg > 90 else ("Back", theta_r_deg, azimuth)


def process_of(side: LightSide, outgoing_to_interior: bool) -> Process:
    """Transmission or reflection, from where the light arrives and where it leaves."""
    return "Transmission" if (side == "Front") == outgoing_to_interior else "Reflection"


def direction_of_patch_deg(
    basis: KlemsBasis, process: Process, side: LightSide, *, row: int, column: int, front_faces: Side
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Incident and outgoing direction (theta, phi) of ours at the centres of a matrix element's patches."""
    polar_i, azimuth_i = basis.centres_deg[column]
    polar_o, azimuth_o = basis.centres_deg[row]
    theta_i = 180.0 - polar_i if side == "Front" else polar_i
    to_interior = (side == "Front") == (process == "Transmission")
    theta_o = polar_o if to_interior else 180.0 - polar_o
    theta, phi = to_radiance_deg([theta_i, theta_o], [azimuth_i + 180.0, azimuth_o], front_faces)
    return (float(theta[0]), float(phi[0])), (float(theta[1]), float(phi[1]))
