"""symmetry.py: the symmetry that the user declares: which images of a measured direction it makes known, and whether
the data agree with it.

Isotropic: the sample may be turned about its normal at will; everything is turned to incident azimuth 0. Bilateral: it
equals its mirror image, left-right (x -> -x) or up-down (y -> -y). Quadrilateral: both. Up: half a turn about the
normal, not mirrored. None: only what was measured.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Symmetry
from gonio.model.nodes.points import SAME_DEG, Points, joined
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

SYMMETRIES = ("none", "isotropic", "bilateral", "quadrilateral", "up")
_SAME_RAD = np.radians(SAME_DEG)
_LEAST_PAIRS = 20
# Beyond this root mean square difference in units of its uncertainty, and this share of the integral, it is said.
_CONTRADICTED_U = 2.0
_CONTRADICTED_SHARE = 0.05

IDENTITY = (1, 1)
HALF_TURN = (-1, -1)
LEFT_RIGHT = (-1, 1)
UP_DOWN = (1, -1)


@dataclass(frozen=True)
class Images:
    """Signs of x and y, (1, 1) first, under which the sample looks the same; isotropic: besides any turn."""

    symmetry: Symmetry
    signs: tuple[tuple[int, int], ...]

    @property
    def isotropic(self) -> bool:
        """Whether everything is turned to azimuth 0."""
        return self.symmetry == "isotropic"

    def expand(self, incident: FloatArray) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
        """Of incident directions (n, 3) all that are known: whose image (e,), signs (e, 2), incident (e, 3). Measured
        ones come first; an image where another direction is known already is left out."""
        source, signs = list(range(len(incident))), [IDENTITY] * len(incident)
        known = [np.asarray(i) for i in incident]
        for sign in self.signs[1:]:
            for row, direction in enumerate(incident):
                image = direction * np.array([*sign, 1.0])
                if min(float(np.linalg.norm(image - other)) for other in known) > _SAME_RAD:
                    source.append(row)
                    signs.append(sign)
                    known.append(image)
        return np.array(source, dtype=np.int64), np.array(signs, dtype=np.float64).reshape(-1, 2), np.array(known)


def declared(symmetry: Symmetry | None, of_dataset: Symmetry) -> Symmetry:
    """What the user says, before what the dataset says. UsageError where neither does."""
    chosen = of_dataset if symmetry is None else symmetry
    if chosen == "undeclared":
        raise UsageError(
            "the sample's symmetry is not declared and is never guessed: give --symmetry "
            "isotropic, bilateral, quadrilateral, up or none"
        )
    if chosen not in SYMMETRIES:
        raise UsageError(f"--symmetry {chosen}: not one of {', '.join(SYMMETRIES)}")
    return chosen


def images_of(symmetry: Symmetry, points: list[Points]) -> Images:
    """The images; of a bilateral sample the mirror that the measured azimuths ask for.

    Measured between 0 and 180 degrees it is mirrored up-down, between 90 and 270 (or -90 and 90) left-right. Where both
    would do, it is the one that the data contradict less; where they do not tell, left-right.
    """
    if symmetry == "isotropic":
        return Images(symmetry, (IDENTITY, HALF_TURN))
    if symmetry == "quadrilateral":
        return Images(symmetry, (IDENTITY, LEFT_RIGHT, UP_DOWN, HALF_TURN))
    if symmetry == "up":
        return Images(symmetry, (IDENTITY, HALF_TURN))
    if symmetry == "none":
        return Images(symmetry, (IDENTITY,))
    incident = np.array([p.incident for p in points])
    possible = [
        mirror
        for mirror, across in ((LEFT_RIGHT, incident[:, 0]), (UP_DOWN, incident[:, 1]))
        if np.all(across > -_SAME_RAD) or np.all(across < _SAME_RAD)
    ] or [LEFT_RIGHT, UP_DOWN]
    if len(possible) > 1:
        found = [_difference(points, mirror) for mirror in possible]
        if found[0] is not None and found[1] is not None and found[1]["share"] < found[0]["share"]:
            possible.reverse()
    return Images(symmetry, (IDENTITY, possible[0]))


def compared_images(points: list[Points], images: Images) -> list[dict[str, Any]]:
    """Measured directions compared with the images of others at the same place; one entry per image that has pairs.

    pairs: of points; rms_u: root mean square difference in units of its standard uncertainty (noise of both, and what
    interpolation between points of the other costs); share: integral of |difference| over that of both; contradicted.
    """
    if images.isotropic:
        return [found for found in (_isotropic(points),) if found is not None]
    found = [(sign, _difference(points, sign)) for sign in images.signs[1:]]
    return [entry for _, entry in found if entry is not None]


def _isotropic(points: list[Points]) -> dict[str, Any] | None:
    """Directions of the same theta, turned to azimuth 0, with each other."""
    turned = [to_azimuth_0(p) for p in points]
    pairs = []
    for number, one in enumerate(turned):
        for other in turned[number + 1 :]:
            if np.linalg.norm(one.incident - other.incident) < _SAME_RAD and one is not other:
                pairs.append((one, other))
    return _summary(pairs, "turned about the normal")


def _difference(points: list[Points], sign: tuple[int, int]) -> dict[str, Any] | None:
    names = {LEFT_RIGHT: "mirrored left-right", UP_DOWN: "mirrored up-down", HALF_TURN: "half a turn"}
    pairs = []
    for number, one in enumerate(points):
        image = one.mirrored(np.array(sign, dtype=np.float64))
        for other in points[number:]:
            if np.linalg.norm(image.incident - other.incident) < _SAME_RAD:
                pairs.append((image, other))
    return _summary(pairs, names[sign])


def _summary(pairs: list[tuple[Points, Points]], name: str) -> dict[str, Any] | None:
    number, squares, absolute, both = 0, 0.0, 0.0, 0.0
    for image, other in pairs:
        difference, u, total, sr = _compared(image, other)
        number += len(difference)
        squares += float(np.sum((difference / u) ** 2))
        absolute += float(np.abs(difference) @ sr)
        both += float(0.5 * total @ sr)
    if number < _LEAST_PAIRS:
        return None
    rms_u, share = float(np.sqrt(squares / number)), absolute / max(both, 1e-300)
    return {
        "image": name,
        "pairs": number,
        "rms_u": rms_u,
        "share": share,
        "contradicted": bool(rms_u > _CONTRADICTED_U and share > _CONTRADICTED_SHARE),
    }


def _compared(image: Points, other: Points) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """At the image's points: difference from the mean of the other's three nearest points, weighted to their centre;
    its uncertainty; the sum of both; solid angle. Points of the image that the other does not surround are left out."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - slow to load, and seldom are there pairs to compare

    near = min(4, len(other.unit))
    distance, index = cKDTree(other.unit).query(image.unit, k=near)
    distance, index = distance.reshape(-1, near), index.reshape(-1, near)
    weight = 1.0 / (distance + 1e-9) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    value = np.sum(weight * other.dsf_per_sr[index], axis=1)
    noise = np.sum(weight**2 * other.variance_per_sr2[index], axis=1)
    spread = np.sum(weight * (other.dsf_per_sr[index] - value[:, None]) ** 2, axis=1)
    u = np.sqrt(image.variance_per_sr2 + noise + spread)
    reach = 2.0 * np.sqrt(np.median(other.solid_angle_sr))
    kept = distance[:, 0] < reach
    difference = image.dsf_per_sr - value
    return difference[kept], u[kept], (np.abs(image.dsf_per_sr) + np.abs(value))[kept], image.solid_angle_sr[kept]


def to_azimuth_0(points: Points) -> Points:
    """Turned about the normal until the light comes from azimuth 0."""
    x, y, z = points.incident
    if np.hypot(x, y) < 1e-9 or (x > 0.0 and abs(y) < 1e-15):
        return points
    return replace(points.turned(-float(np.arctan2(y, x))), incident=np.array([np.hypot(x, y), 0.0, z]))


def prepared(points: list[Points], images: Images) -> list[Points]:
    """The points as they are fitted: of an isotropic sample turned to azimuth 0 and joined, in order of theta."""
    if not images.isotropic:
        return points
    return sorted(joined([to_azimuth_0(p) for p in points]), key=lambda p: float(p.incident[0]))
