"""average.py: matrices of a WINDOW file as averages over both patches (CONVENTIONS.md, "WINDOW XML"):

B_oi = 1 / (L_o L_i)  integral over both patches of DSF cos(theta_i), L = integral of cos over a patch.
"""

from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from gonio.dataset.bsdf import Side, Symmetry
from gonio.dataset.scattering import FloatArray, IndexArray, Scattering
from gonio.formats.patches import pairs, turned
from gonio.formats.patches.hemispheres import Component
from gonio.formats.window.klems import KlemsBasis, LightSide, Process

TOLERANCE = 1e-4  # of a column's sum
Key = tuple[Process, LightSide]

_PROBES = 64  # pairs of directions by which a symmetry is confirmed
_ALIKE = 1e-6
# Signs of x and y under which a sample of that declared symmetry may be the same; each is tried.
_ALL = ((-1, 1), (1, -1), (-1, -1))
_MIRRORS: dict[Symmetry, tuple[tuple[int, int], ...]] = {
    "isotropic": _ALL,
    "bilateral": ((-1, 1), (1, -1)),
    "quadrilateral": _ALL,
    "up": ((-1, -1),),
    "none": (),
    "undeclared": (),
}


@dataclass
class PatchMatrices:
    """Values BSDF [1/sr] (outgoing, incident) of what the scattering covers; `error` (incident,): the estimated error
    of each column's sum."""

    matrices: dict[Key, FloatArray] = field(default_factory=dict)
    error: dict[Key, FloatArray] = field(default_factory=dict)


def average(
    scattering: Scattering,
    basis: KlemsBasis,
    front_faces: Side,
    *,
    tolerance: float = TOLERANCE,
    symmetry: Symmetry = "undeclared",
) -> PatchMatrices:
    """Averages of every pair of sides that the scattering covers, each column's sum within `tolerance` of itself.

    That is by estimate, from cells and their parts: `error` has it. Samples without symmetry, fitted to noisy points,
    were found within 6e-5 of a column's sum at 1e-4; the differences of single values then add up to about 1e-4.

    A declared symmetry saves work where the scattering has it, which is tried at some pairs of directions. Raises
    UsageError when `front_faces` is undeclared.
    """
    result = PatchMatrices()
    for side in get_args(LightSide):
        for process in get_args(Process):
            component = Component(scattering, process, side, front_faces)
            if not component.covered():
                continue
            key = (process, side)
            if symmetry == "isotropic" and turned.fits(basis) and _turns(component):
                result.matrices[key], result.error[key] = turned.matrix(component, basis, tolerance)
            else:
                images = _images(component, basis, symmetry)
                result.matrices[key], result.error[key] = _of_images(component, basis, tolerance, images)
    return result


def _of_images(
    component: Component, basis: KlemsBasis, tolerance: float, images: list[IndexArray]
) -> tuple[FloatArray, FloatArray]:
    """The first column of each set of columns that are images of each other; the others with their rows renamed."""
    every = np.arange(basis.size)
    first = np.flatnonzero(np.all([every <= image for image in images], axis=0)) if images else every
    values, error = pairs.matrix(component, basis, tolerance, first)
    for image in images:
        values[np.ix_(image, image[first])] = values[:, first]
        error[image[first]] = error[first]
    return values, error


def _images(component: Component, basis: KlemsBasis, symmetry: Symmetry) -> list[IndexArray]:
    """Patches (size,) that take the place of each under mirrors and half a turn that the sample has."""
    found = []
    for sign in _MIRRORS[symmetry]:
        image = _image_of_patches(basis, sign)
        if image is not None and _same(component, sign=sign):
            found.append(image)
    return found


def _image_of_patches(basis: KlemsBasis, sign: tuple[int, int]) -> IndexArray | None:
    """None where a ring of an odd number of patches has no image of its own."""
    parts = []
    for start, ring in zip(basis.ring_start[:-1], basis.rings, strict=True):
        if sign[0] < 0 and ring.patches % 2 and ring.patches > 1:
            return None
        # x -> -x is phi -> 180 - phi; y -> -y is phi -> -phi; both: 180 + phi.
        number = np.arange(ring.patches) * (sign[0] * sign[1]) + (ring.patches // 2 if sign[0] < 0 else 0)
        parts.append(start + number % ring.patches)
    return np.concatenate(parts).astype(np.int64)


def _turns(component: Component) -> bool:
    """Whether values stay when both directions are turned about the normal by the same angle."""
    return all(_same(component, turn_rad=np.radians(angle)) for angle in (17.0, 90.0, 211.0))


def _same(component: Component, *, turn_rad: float = 0.0, sign: tuple[int, int] = (1, 1)) -> bool:
    """Whether values stay, at some pairs, when both directions are turned, or x and y multiplied by signs."""
    rng = np.random.default_rng(20)
    polar_i, polar_o = np.arccos(np.sqrt(rng.random((2, _PROBES))))
    azimuth_i, azimuth_o = 2.0 * np.pi * rng.random((2, _PROBES))
    every = np.arange(_PROBES)
    incident, outgoing = component.incident(polar_i, azimuth_i), component.outgoing(polar_o, azimuth_o)
    factor = np.array([*sign, 1.0])
    after = component.values(
        component.incident(polar_i, azimuth_i + turn_rad) * factor,
        component.outgoing(polar_o, azimuth_o + turn_rad) * factor,
        every,
    )
    plain = component.values(incident, outgoing, every)
    return bool(np.allclose(plain, after, rtol=_ALIKE, atol=_ALIKE * np.abs(plain).max()))
