"""forward.py: a model's DSF as the instrument would see it: the model averaged over the measured free beam."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import tangent_frame, unit_from_angles_deg
from gonio.reduce.signature.profile import BeamProfile

FloatArray = NDArray[np.float64]
Model = Callable[[FloatArray], FloatArray]  # DSF [1/sr] (n,) towards unit vectors (n, 3)

_NODES = 400  # of the beam, at most: means over squares of its scan
_AT_ONCE = 1 << 19  # directions that the model is asked for in one call


def apply(
    beam: Distribution,
    model_dsf: Model,
    directions: FloatArray,
    incident_deg: tuple[float, float],
    nodes: int = _NODES,
) -> FloatArray:
    """DSF [1/sr] (n,) of the model as seen towards `directions` (n, 3) through beam and aperture: the sum over the
    beam's measured cells of model(direction turned by the cell's place off straight through) times the cell's share of
    the light.

    Only the beam's offsets are asked of the model, at the one incident direction: the DSF is taken to depend on the
    outgoing direction relative to the light's own, as a mirrored or transmitted lobe does within the beam. The beam's
    profile is carried along the great circle from straight through (mirrored: from the mirror direction), so that it
    keeps its orientation for directions about either; its centroid is taken as the incident direction that was read,
    and is not applied. The measured profile holds the aperture already. At most `nodes` means over squares of the
    scan stand for it. Raises ValueError for a beam without light.
    """
    profile = BeamProfile.of(beam)
    x, y, share = reduced(profile, nodes)
    result = np.empty(len(directions))
    step = max(1, _AT_ONCE // len(x))
    for start in range(0, len(directions), step):
        part = directions[start : start + step]
        asked = shifted(part, x, y, incident_deg)
        seen = np.asarray(model_dsf(asked.reshape(-1, 3))).reshape(asked.shape[:2])
        result[start : start + step] = seen @ share
    return result


def reduced(profile: BeamProfile, nodes: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places x, y [rad] (m,) about the centroid and shares (m,) of the light, which add up to 1: sums over the squares
    of a grid over the disc that holds the light, each at its own centroid, so that the first moments are kept. Squares
    with less than a millionth, and noise below zero, are left out."""
    x0, y0 = profile.centroid_rad
    x, y = profile.x - x0, profile.y - y0
    reach = 1.3 * profile.radius_rad
    inside = np.hypot(x, y) <= reach
    x, y = x[inside], y[inside]
    light = (profile.per_sr * profile.solid_angle_sr)[inside]
    side = max(int(np.sqrt(nodes * 4.0 / np.pi)), 3)
    width = 2.0 * reach / side
    square = np.minimum(((x + reach) / width).astype(np.intp), side - 1) * side
    square += np.minimum(((y + reach) / width).astype(np.intp), side - 1)
    total = np.bincount(square, light, side * side)
    kept = total > 1e-6 * total.sum()
    share = total[kept] / total[kept].sum()
    at_x = np.bincount(square, light * x, side * side)[kept] / total[kept]
    at_y = np.bincount(square, light * y, side * side)[kept] / total[kept]
    return at_x - share @ at_x, at_y - share @ at_y, share


def shifted(directions: FloatArray, x: FloatArray, y: FloatArray, incident_deg: tuple[float, float]) -> FloatArray:
    """Directions (n, m, 3): each of `directions` (n, 3) turned back by each place of the beam (m,).

    A part of the beam that travels off the axis by (x, y) scatters about a direction that is off by as much; what is
    seen towards d is the model's value as far from its own lobe as d is from that part's: at d shifted by (-x, -y).
    """
    frames = _frames(directions, incident_deg)
    angle = np.hypot(x, y)
    sinc = np.where(angle > 1e-12, np.sin(angle) / np.maximum(angle, 1e-12), 1.0)
    across = -(x * sinc)[None, :, None] * frames[:, None, 0] - (y * sinc)[None, :, None] * frames[:, None, 1]
    return np.asarray(across + np.cos(angle)[None, :, None] * frames[:, None, 2])


def _frames(directions: FloatArray, incident_deg: tuple[float, float]) -> FloatArray:
    """Frames (n, 3, 3), rows the beam's x and y at each direction and the direction itself. At straight through they
    are e_theta and e_phi of the incident direction (signature/profile.py), on the incident side their mirror images,
    and from there they are carried along great circles."""
    theta, phi = np.radians(incident_deg)
    e_theta = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    e_phi = np.array([-np.sin(phi), np.cos(phi), 0.0])
    through = -unit_from_angles_deg(*incident_deg)
    frames = np.empty((len(directions), 3, 3))
    frames[:, 2] = directions
    same_side = directions[:, 2] * through[2] >= 0.0
    for side, flip in ((same_side, 1.0), (~same_side, -1.0)):
        pole, axes = through * [1.0, 1.0, flip], np.stack((e_theta, e_phi)) * [1.0, 1.0, flip]
        d = directions[side]
        # Parallel transport from pole to d: v - (v . d) / (1 + pole . d) (pole + d); at the antipode any frame will do.
        denominator = 1.0 + d @ pole
        opposite = denominator < 1e-9
        for row, axis in enumerate(axes):
            along = (d @ axis) / np.where(opposite, 1.0, denominator)
            frames[side, row] = axis - along[:, None] * (pole + d)
        if opposite.any():
            where = np.flatnonzero(side)[opposite]
            frames[where, :2] = tangent_frame(-pole)[:2]
    return frames
