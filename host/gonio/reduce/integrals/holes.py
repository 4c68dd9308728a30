"""holes.py: where the holes of a hemisphere are: places without a value, which hole each is of, the points about it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_LATTICE = 20_000  # places on a hemisphere without points
_JOINED_RAD = 0.02  # places nearer than about twice this are of one hole
_RING = 1.0  # width of the ring of measured points about a hole, over the hole's depth
_RING_LEAST_RAD = np.radians(2.0)


@dataclass(frozen=True)
class Points:
    """Measured points (k, 3) of the hemisphere, their DSF, cells, and a search tree."""

    unit: FloatArray
    dsf: FloatArray
    cell_sr: FloatArray
    tree: cKDTree

    def nearest(self, places: FloatArray) -> tuple[FloatArray, IntArray]:
        """Angle [rad] from places (m, 3) to the nearest point, and its index."""
        chord, index = self.tree.query(places)
        return angle_rad(chord), np.asarray(index, dtype=np.intp)


def uncovered_places(points: Points, masked: FloatArray, uncovered_sr: float) -> FloatArray:
    """Directions (m, 3) of a lattice over the hemisphere that no cell covers. No point owns area beyond its reach, so
    they lie farthest from all points, masked ones (j, 3) too: as many as make up the uncovered solid angle."""
    turn = np.arange(_LATTICE)
    z = (turn + 0.5) / _LATTICE * (1.0 if points.unit[0, 2] >= 0.0 else -1.0)
    across, azimuth = np.sqrt(1.0 - z * z), turn * np.pi * (3.0 - np.sqrt(5.0))
    lattice = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=1)
    distance = points.nearest(lattice)[0]
    if len(masked):
        distance = np.minimum(distance, angle_rad(cKDTree(masked, balanced_tree=False).query(lattice)[0]))
    return lattice[np.argsort(-distance)[: max(1, round(uncovered_sr / (2.0 * np.pi) * _LATTICE))]]


def connected(place: FloatArray) -> IntArray:
    """Number (m,) of the hole that each place (m, 3) is in: boxes on a grid that touch or lie one apart are joined."""
    box, of = np.unique(np.floor(place / _JOINED_RAD).astype(np.int64), axis=0, return_inverse=True)
    pairs = cKDTree(box).query_pairs(2.3, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(box), len(box)))
    return np.asarray(connected_components(graph, directed=False)[1][of.ravel()], dtype=np.intp)


def ring_width_rad(depth: FloatArray) -> FloatArray:
    """Of the rings about holes of these depths (n,) [rad]."""
    return np.maximum(_RING * depth, _RING_LEAST_RAD)


def ring_about(
    points: Points, place: FloatArray, hole: IntArray, deepest: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Points (j,) about the holes, the hole that each is nearest to, and its angle [rad] to that hole's places."""
    width = ring_width_rad(deepest)
    # Some place is at most its depth from its nearest point, so a ring is never empty if it is that much wider.
    most = float((width + deepest).max())
    chord, at = cKDTree(place, balanced_tree=False).query(points.unit, distance_upper_bound=chord_of(most))
    near = np.flatnonzero(np.isfinite(chord))
    about, off = hole[at[near]], angle_rad(chord[near])
    kept = off <= (width + deepest)[about]
    return near[kept], about[kept], off[kept]


def angle_rad(chord: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))


def chord_of(angle_rad: float) -> float:
    return 2.0 * float(np.sin(0.5 * min(angle_rad, np.pi)))
