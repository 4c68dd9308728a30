"""cones.py: biconical integrals: what goes into a cone about a named direction."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.directions import angle_between_deg, mirror, retro, tangent_frame, through, unit_from_angles_deg
from gonio.reduce.integrals.quadrature import Weights, integral, side_weights
from gonio.reduce.integrals.results import Results

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

HALF_ANGLE_DEG = 7.0  # paper [1]: +-7 degrees about straight through
LEAST_SHARE = 0.9  # of the cone, that must be measured for a cone to be written
_EDGE_CELLS = 1.5  # the edge of a cone is this many cell radii wide, on either side
_COMPACT = 0.005  # of the cone: as long as the shares of discs add up to it so well they will do
_PLACES = 12_000  # in the cone, where they do not
_EDGE_PLACES = 4_000  # along its edge
_SMALL_PLACES = 4.0  # a cell of fewer places is small for the lattice
_LONGEST_DEG = 15.0  # from the edge to a point whose cell may cross it
_NAMED = {"mirror": mirror, "retro": retro, "through": through}


def direction_of(distribution: Distribution, name: str) -> tuple[float, float]:
    """Direction (theta, phi) in degrees of `mirror`, `retro` or `through`. Raises KeyError."""
    theta_deg, phi_deg = _NAMED[name](distribution.incident_theta_deg, distribution.incident_phi_deg)
    return float(theta_deg), float(phi_deg)


def cone_weights(
    distribution: Distribution, unit: FloatArray, axis: FloatArray, half_angle_deg: float, side: Weights | None = None
) -> Weights:
    """Weights of the points (n,), at `unit` (n, 3), for the integral over a cone about the unit vector `axis` (3,). The
    cone ends at theta = 90 degrees: it takes from the axis's own hemisphere. `side`: that hemisphere's weights.

    A compact cell along the edge counts by the share of a disc of its area. Where these do not add up to the cone
    (cells of a coarse track, or of a spiral's last turn, are far longer than wide, and cross the edge with one end)
    places in the cone are counted instead.
    """
    of_side = (unit[:, 2] >= 0.0) == (axis[2] >= 0.0)
    whole = side_weights(distribution, unit, of_side) if side is None else side
    cone_sr = cone_solid_angle_sr(abs(float(axis[2])), half_angle_deg)
    wide_deg = np.maximum(_EDGE_CELLS * _radius_deg(distribution.solid_angle_sr), 0.05 * half_angle_deg)
    farthest_deg = min(half_angle_deg + float(wide_deg.max()), 180.0)
    near = np.flatnonzero(of_side & (unit @ axis >= np.cos(np.radians(farthest_deg))))
    off_deg = angle_between_deg(unit[near], axis)
    share, edge = np.zeros(len(unit)), np.zeros(len(unit), dtype=bool)
    share[near] = _shares(distribution.solid_angle_sr[near], off_deg, half_angle_deg)
    edge[near] = np.abs(off_deg - half_angle_deg) <= wide_deg[near]
    if abs(float(share @ distribution.solid_angle_sr) / cone_sr - 1.0) > _COMPACT:
        share, edge = _counted(distribution, unit, of_side, axis, half_angle_deg)
    return whole.within(share, edge & distribution.measured)


def _shares(solid_angle_sr: FloatArray, off_deg: FloatArray, half_angle_deg: float) -> FloatArray:
    """Share (n,) of each cell that lies within the cone, of points `off_deg` (n,) from its axis: of a disc of the
    cell's area, centred at its point, what a straight edge leaves. That is the circular segment's area,
    1/2 + (asin t + t sqrt(1 - t^2)) / pi with t = distance to the edge / radius."""
    t = np.clip((half_angle_deg - off_deg) / np.maximum(_radius_deg(solid_angle_sr), 1e-12), -1.0, 1.0)
    return np.asarray(0.5 + (np.arcsin(t) + t * np.sqrt(1.0 - t * t)) / np.pi)


def _counted(
    distribution: Distribution, unit: FloatArray, of_side: BoolArray, axis: FloatArray, half_angle_deg: float
) -> tuple[FloatArray, BoolArray]:
    """Shares (n,) and which cells (n,) the edge crosses: those that are nearest to places along it. They count by the
    places of a lattice in the cone that are nearest to them, or, if they are small for it, by the share of a disc. The
    other cells are in the cone whole, or not at all."""
    near = np.flatnonzero(of_side & (unit @ axis >= np.cos(np.radians(min(half_angle_deg + _LONGEST_DEG, 180.0)))))
    share, edge = np.zeros(len(unit)), np.zeros(len(unit), dtype=bool)
    if not len(near):
        return share, edge
    omega = distribution.solid_angle_sr[near]
    tree = cKDTree(unit[near], balanced_tree=False)
    off_deg = angle_between_deg(unit[near], axis)
    place, place_sr = _lattice(axis, half_angle_deg)
    nearest = tree.query(place[(place[:, 2] >= 0.0) == (axis[2] >= 0.0)])[1]
    # A cell may end at its reach before its places do; two more than it holds are the lattice's own grain.
    counted = np.minimum(place_sr * np.bincount(nearest, minlength=len(near)), omega + 2.0 * place_sr)
    crosses = np.zeros(len(near), dtype=bool)
    crosses[tree.query(_circle(axis, half_angle_deg))[1]] = True
    small = omega < _SMALL_PLACES * place_sr
    of_crossing = np.where(small, _shares(omega, off_deg, half_angle_deg) * omega, counted)
    area = np.where(crosses, of_crossing, np.where(off_deg < half_angle_deg, omega, 0.0))
    share[near] = np.divide(area, omega, out=np.zeros(len(near)), where=omega > 0.0)
    edge[near] = crosses & (omega > 0.0)
    return share, edge


def _circle(axis: FloatArray, half_angle_deg: float) -> FloatArray:
    """Directions (m, 3) along the cone's edge, where it lies on the axis's side of theta = 90 degrees."""
    azimuth = np.arange(_EDGE_PLACES) * 2.0 * np.pi / _EDGE_PLACES
    polar = np.radians(half_angle_deg)
    about = np.stack(
        (np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.full(len(azimuth), np.cos(polar)))
    )
    circle = np.asarray(about.T @ tangent_frame(axis))
    return np.asarray(circle[(circle[:, 2] >= 0.0) == (axis[2] >= 0.0)])


def _lattice(axis: FloatArray, half_angle_deg: float) -> tuple[FloatArray, float]:
    """Places (m, 3), evenly spread over the cone (a spiral that turns by the golden angle), and the solid angle of
    each."""
    turn = np.arange(_PLACES)
    height = 1.0 - (1.0 - np.cos(np.radians(half_angle_deg))) * (turn + 0.5) / _PLACES
    across, azimuth = np.sqrt(1.0 - height**2), turn * np.pi * (3.0 - np.sqrt(5.0))
    places = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), height), axis=1) @ tangent_frame(axis)
    return np.asarray(places), float(2.0 * np.pi * (1.0 - np.cos(np.radians(half_angle_deg))) / _PLACES)


def _radius_deg(solid_angle_sr: FloatArray) -> FloatArray:
    """Of discs of these areas."""
    return np.asarray(np.degrees(np.sqrt(np.maximum(solid_angle_sr, 0.0) / np.pi)))


def cone(distribution: Distribution, direction_deg: tuple[float, float], half_angle_deg: float) -> Uncertain:
    """Integral of the DSF over the measured part of a cone about (theta, phi): biconical reflectance or transmittance
    for the beam's own cone of incidence. Raises ValueError for half angles outside 0 to 90 degrees."""
    if not 0.0 < half_angle_deg <= 90.0:
        raise ValueError(f"a cone's half angle lies between 0 and 90 degrees, not {half_angle_deg:g}")
    unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
    axis = unit_from_angles_deg(*direction_deg)
    return integral(distribution, cone_weights(distribution, unit, axis, half_angle_deg))


def named_cones(
    distribution: Distribution, unit: FloatArray, sides: dict[bool, Weights], half_angle_deg: float = HALF_ANGLE_DEG
) -> Results:
    """Entries "cone NAME HALF_ANGLE" about mirror, retro and through with their measured share, where at least
    LEAST_SHARE of the cone is measured. `sides`: weights of both hemispheres by whether z >= 0."""
    found = Results()
    for name in _NAMED:
        axis = unit_from_angles_deg(*direction_of(distribution, name))
        weights = cone_weights(distribution, unit, axis, half_angle_deg, sides.get(bool(axis[2] >= 0.0)))
        share = float(weights.cell_sr.sum()) / cone_solid_angle_sr(abs(float(axis[2])), half_angle_deg)
        if share < LEAST_SHARE:
            continue
        key = f"cone {name} {half_angle_deg:g}"
        found.put(key, integral(distribution, weights))
        found.values[f"{key}_measured_share"] = min(share, 1.0)
    return found


def cone_solid_angle_sr(axis_cosine: float, half_angle_deg: float) -> float:
    """Solid angle of the part of a cone that lies on its axis's side of the plane theta = 90 degrees; `axis_cosine` of
    the axis to the normal, 0 to 1. In closed form over the ring, by Gauss and Legendre over the polar angle."""
    half = np.radians(half_angle_deg)
    axis_sine = np.sqrt(max(1.0 - axis_cosine**2, 0.0))
    full = min(half, np.pi / 2.0 - np.arccos(min(axis_cosine, 1.0)))  # rings within this lie above the plane whole
    whole = 2.0 * np.pi * (1.0 - np.cos(full))
    if full >= half:
        return float(whole)
    node, weight = np.polynomial.legendre.leggauss(64)
    # The open arc grows from full like a square root: substituting polar = full + (half - full) s^2 makes it smooth.
    s = 0.5 * (node + 1.0)
    polar = full + (half - full) * s**2
    cut = -np.cos(polar) * axis_cosine / (np.sin(polar) * max(axis_sine, 1e-12))
    arc = 2.0 * np.arccos(np.clip(cut, -1.0, 1.0))
    return float(whole + 0.5 * weight @ (arc * np.sin(polar) * 2.0 * (half - full) * s))
