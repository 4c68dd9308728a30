"""fill.py: what the holes of a hemisphere would add: linear interpolation across them, and how far that may be off."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import tangent_frame
from gonio.geometry.interpolate import Interpolation
from gonio.reduce.integrals.holes import (
    Points,
    angle_rad,
    chord_of,
    connected,
    ring_about,
    ring_width_rad,
    uncovered_places,
)

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

# A place farther than this from every measured one is not filled.
FILL_REACH_DEG = 8.0
_KNOWN = 40_000  # points of a hemisphere that are looked at: more lie along tracks and tell nothing new about holes
_UNCOVERED_LEAST = 1e-3  # of the hemisphere: less is rounding at the horizon
_TRIED = 12  # of the largest holes,
_TRIED_DEPTH_RAD = np.radians(0.5)  # if they are that deep,
_TRIES = 6  # beside each of them
_LEAST_POINTS = 6  # of a ring
_SIGMA_PER_MEDIAN = 1.4826  # of the size of normal errors
_GRAZING = 1e-9


@dataclass(frozen=True)
class Fill:
    """`weight` (n,): the filled part is sum weight DSF over measured points; `u`: its standard uncertainty as a guess,
    apart from the points' own. `unfilled_sr`: farther than FILL_REACH_DEG from every measured point."""

    weight: FloatArray
    u: float
    unfilled_sr: float


def fill_holes(distribution: Distribution, unit: FloatArray, side: BoolArray) -> Fill:
    """Holes of one hemisphere: the cells of masked points and what no cell covers; `unit` (n, 3), `side` (n,).

    Filled by linear interpolation on the triangles of the measured points about the holes, and towards the horizon by
    their BSDF: no value leaves the range from 0 to those of the points about it. Uncovered parts are filled whole or
    not at all. The standard uncertainty of a hole is the largest of what four other ways would change:

    the nearest point's value instead; the median of the ring about the hole (a narrow peak beside the hole pulls the
    interpolation, but not the median); the ring's mean slope towards the hole, carried on into it (of a smooth lobe it
    is 4/3 of what interpolation misses: both go with the Laplacian); and what the same fill misses in holes of the
    same shape turned to places beside it, where the points know the truth: median of up to six tries at each of the
    twelve largest holes, in proportion larger where the hole's own ring is rougher.

    All this is worth nothing where a peak is masked whole: what nobody saw around the hole is in no model.
    """
    area = distribution.solid_angle_sr
    measured = np.flatnonzero(side & distribution.measured & (area > 0.0))
    masked = np.flatnonzero(side & ~distribution.measured & (area > 0.0))
    uncovered_sr = 2.0 * np.pi - float(area[side].sum())
    if uncovered_sr < _UNCOVERED_LEAST * 2.0 * np.pi:
        uncovered_sr = 0.0
    weight = np.zeros(len(unit))
    if len(measured) < _LEAST_POINTS or not (len(masked) or uncovered_sr):
        return Fill(weight, 0.0, float(area[masked].sum()) + uncovered_sr)
    every = -(-len(measured) // _KNOWN)
    known = measured[::every]
    known_sr = np.add.reduceat(area[measured], np.arange(0, len(measured), every))
    points = Points(unit[known], distribution.dsf_per_sr[known], known_sr, cKDTree(unit[known], balanced_tree=False))
    place, place_sr, unfilled_sr = unit[masked], area[masked], 0.0
    if uncovered_sr:
        uncovered = uncovered_places(points, place, uncovered_sr)
        if points.nearest(uncovered)[0].max() > np.radians(FILL_REACH_DEG):
            unfilled_sr, uncovered = uncovered_sr, uncovered[:0]
        place = np.concatenate((place, uncovered))
        place_sr = np.concatenate((place_sr, np.full(len(uncovered), uncovered_sr / max(len(uncovered), 1))))
    depth, nearest = points.nearest(place)
    filled = depth <= np.radians(FILL_REACH_DEG)
    unfilled_sr += float(place_sr[~filled].sum())
    if not filled.any():
        return Fill(weight, 0.0, unfilled_sr)
    place, place_sr, depth, nearest = place[filled], place_sr[filled], depth[filled], nearest[filled]
    hole = connected(place)
    count = int(hole.max()) + 1
    hole_sr, deepest = np.bincount(hole, place_sr), np.zeros(count)
    np.maximum.at(deepest, hole, depth)
    ring, about, off = ring_about(points, place, hole, deepest)
    index, share = _interpolated(points, ring, place)
    np.add.at(weight, known[index], share * place_sr[:, None])

    def per_hole(value: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(hole, place_sr * value, count), dtype=np.float64)

    dsf = points.dsf
    found = per_hole((share * dsf[index]).sum(axis=1))
    median, slope, rough = _ring_values(dsf[ring], points.cell_sr[ring], off, about, count)
    other = np.abs([found - per_hole(dsf[nearest]), found - hole_sr * median, slope * per_hole(depth)]).max(axis=0)
    for one in np.argsort(-hole_sr)[:_TRIED]:
        if deepest[one] >= _TRIED_DEPTH_RAD:
            missed = _missed(points, place[hole == one], float(hole_sr[one]), float(deepest[one]), float(rough[one]))
            other[one] = max(other[one], missed)
    return Fill(weight, float(np.linalg.norm(other)), unfilled_sr)


def _interpolated(points: Points, ring: IntArray, place: FloatArray) -> tuple[IntArray, FloatArray]:
    """Points (m, 3) and weights (m, 3) whose sum over their DSF is the value at places (m, 3).

    Between the last points and the horizon the interpolation has no triangles but with the points' mirror images, and
    would keep the DSF: there the BSDF is kept, so that the DSF falls with the cosine.
    """
    at = Interpolation(points.unit[ring]).at(place)
    index = ring[at.index]
    cosine = (at.weight * np.abs(points.unit[index, 2])).sum(axis=1)
    falls = np.minimum(1.0, np.abs(place[:, 2]) / np.maximum(cosine, _GRAZING))
    return index, at.weight * falls[:, None]


def _ring_values(
    dsf: FloatArray, weight: FloatArray, off: FloatArray, about: IntArray, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of the ring of each of `count` holes: median [1/sr], slope over the distance [1/(sr rad)], standard deviation;
    of points (j,) with their distances `off` from the hole `about` which they lie."""

    def mean(value: FloatArray) -> FloatArray:
        return np.bincount(about, weight * value, count) / np.maximum(np.bincount(about, weight, count), _GRAZING**2)

    order = np.lexsort((dsf, about))
    size = np.bincount(about, minlength=count)
    middle = np.cumsum(size) - size + size // 2
    median = np.where(size > 0, dsf[order][np.minimum(middle, len(dsf) - 1)], 0.0)
    from_mean, far = dsf - mean(dsf)[about], off - mean(off)[about]
    spread = mean(far**2)
    slope = np.where(spread > 0.0, mean(far * from_mean) / np.where(spread > 0.0, spread, 1.0), 0.0)
    return median, slope, np.sqrt(mean(from_mean**2))


def _missed(points: Points, place: FloatArray, hole_sr: float, depth: float, rough: float) -> float:
    """Size of what the fill misses in a hole of places (m, 3), from the same hole turned to places beside it: there it
    takes the points that lie nearer to one of its places than to a measured point. 0 where it fits nowhere."""
    middle = place.sum(axis=0)
    middle /= np.linalg.norm(middle)
    ring = float(ring_width_rad(np.array(depth)))
    size = float(angle_rad(np.linalg.norm(place - middle, axis=1)).max()) + depth + ring
    own_tree, frame, step = cKDTree(place), tangent_frame(middle), 2.2 * depth + 0.5 * ring
    found = []
    for azimuth in 2.0 * np.pi * np.arange(_TRIES) / _TRIES:
        towards = np.cos(azimuth) * frame[0] + np.sin(azimuth) * frame[1]
        there = np.cos(step) * middle + np.sin(step) * towards
        near = np.asarray(points.tree.query_ball_point(there, chord_of(size)), dtype=np.intp)
        if len(near) < 2 * _LEAST_POINTS:
            continue
        back = _turned(points.unit[near], np.cross(towards, middle), step)
        inside = own_tree.query(back)[0] < points.tree.query(back)[0]
        hidden, left = near[inside], near[~inside]
        covered_sr = float(points.cell_sr[hidden].sum())
        if not 0.7 * hole_sr < covered_sr < 1.4 * hole_sr or len(left) < _LEAST_POINTS:
            continue
        index, share = _interpolated(points, left, points.unit[hidden])
        missed = (share * points.dsf[index]).sum(axis=1) - points.dsf[hidden]
        larger = max(1.0, rough / max(float(points.dsf[left].std()), _GRAZING))
        found.append(larger * hole_sr * abs(float(missed @ points.cell_sr[hidden])) / covered_sr)
    return _SIGMA_PER_MEDIAN * float(np.median(found)) if found else 0.0


def _turned(unit: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
    """Directions (n, 3) turned about the unit vector `axis` by the angle (O. Rodrigues, 1840)."""
    along = (unit @ axis)[:, None] * axis
    return np.asarray(along + np.cos(angle) * (unit - along) + np.sin(angle) * np.cross(axis, unit))
