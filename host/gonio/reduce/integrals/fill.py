"""fill.py: what the holes of a hemisphere would add: a smooth model of their surroundings, judged at places next to
them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import tangent_frame

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]

# A place farther than this from every measured one has no model.
FILL_REACH_DEG = 8.0
_SHALLOW_DEG = 1.0  # nearer than this the nearest measured value will do, where no deeper hole is about
_PATCH = 1.35  # radius of a patch over the depth of its deepest place
_RING = 0.9  # width of the ring of measured points about a patch, over its radius
_RING_LEAST_DEG = 2.0
_RING_MOST_DEG = 12.0
_PLACES = 8  # about a patch, where the model is tried
_LEAST_POINTS = 12  # of a quadratic
_CONDITION = 0.02  # smallest singular value of a design over its largest
_TREE_POINTS = 20_000  # of a hemisphere: more lie along tracks and tell nothing new about holes
_LATTICE = 20_000  # places on a hemisphere without points
_BETWEEN_TRACKS = 0.45  # of a cell's reach: 1/3 midway between tracks, more between scattered points
_UNCOVERED_LEAST = 1e-3  # of the hemisphere: less is rounding at the horizon


@dataclass(frozen=True)
class Fill:
    """`weight` (n,): what the model adds to the measured sum is sum weight DSF over measured points; `u`: its standard
    uncertainty as a guess, apart from the points' own. `edge`: what the model says beyond the outermost tracks, less
    what the measured sum has there. `unfilled_sr`: where there is no model."""

    weight: FloatArray
    u: float
    edge: float
    unfilled_sr: float


def fill_holes(distribution: Distribution, unit: FloatArray, side: BoolArray, *, edges: bool = True) -> Fill:
    """Holes of one hemisphere: the cells of masked points and what no cell covers; `unit` (n, 3), `side` (n,).

    The deepest place of a hole is the middle of a patch; a quadratic in plane coordinates, fitted by least squares to
    the ring of measured points about the patch, is its model (a plane or the mean where the ring has too few). To judge
    it, hole and ring are turned over the sphere to up to eight places next to the patch; what the model of the turned
    ring says is compared with the points that lie in the turned hole. Where the hole's own ring is rougher than those
    (a peak's flank, say) the errors grow in proportion. Their mean is taken as common to all patches, their scatter as
    each patch's own. Places within a degree of a measured one take its value, and the difference to the measured point
    as far on the other side as their error. A hole that cannot be tried counts with its whole value. Uncovered parts
    are filled whole or not at all. Where cells end at a reach, the outermost points own area up to there: with `edges`
    the model takes their place beyond half the distance of the tracks.
    """
    area = distribution.solid_angle_sr
    measured = np.flatnonzero(side & distribution.measured & (area > 0.0))
    masked = np.flatnonzero(side & ~distribution.measured & (area > 0.0))
    uncovered_sr = 2.0 * np.pi - float(area[side].sum())
    if uncovered_sr < _UNCOVERED_LEAST * 2.0 * np.pi:
        uncovered_sr = 0.0
    weight = np.zeros(len(unit))
    if not len(measured) or not (len(masked) or uncovered_sr):
        return Fill(weight, 0.0, 0.0, float(area[masked].sum()) + uncovered_sr)
    every = max(1, len(measured) // _TREE_POINTS)
    known = measured[::every]
    known_sr = np.add.reduceat(area[measured], np.arange(0, len(measured), every))
    tree = cKDTree(unit[known], balanced_tree=False)
    place, place_sr, owned = unit[masked], area[masked], np.zeros(len(masked), dtype=bool)
    unfilled_sr = 0.0
    if uncovered_sr:
        uncovered, edge = _uncovered_places(tree, place, uncovered_sr, bool(unit[measured[0], 2] >= 0.0))
        if not edges or not len(distribution.linear_solid_angle_sr):
            edge = edge[:0]
        if _angle_rad(tree.query(uncovered)[0]).max() > np.radians(FILL_REACH_DEG):
            unfilled_sr, uncovered = uncovered_sr, uncovered[:0]
        place = np.concatenate((place, uncovered, edge))
        place_sr = np.concatenate((place_sr, np.full(len(uncovered) + len(edge), 2.0 * np.pi / _LATTICE)))
        owned = np.arange(len(place)) >= len(place) - len(edge)
    if not len(place):
        return Fill(weight, 0.0, 0.0, unfilled_sr)
    depth = _angle_rad(tree.query(place)[0])
    far = depth > np.radians(FILL_REACH_DEG)
    unfilled_sr += float(place_sr[far].sum())
    holes = _Holes(place, place_sr, depth, unit[known], distribution.dsf_per_sr[known], known_sr, cKDTree(place), tree)
    left, beyond = ~far, np.zeros(len(unit))
    common, own2 = 0.0, 0.0
    while (deep := np.where(left, depth, 0.0)).max() > np.radians(_SHALLOW_DEG):
        middle = int(np.argmax(deep))
        off = _angle_rad(np.linalg.norm(place - place[middle], axis=1))
        within = np.flatnonzero(left & (off <= _PATCH * depth[middle]))
        left[within] = False
        points, per_place, rough = holes.model(place[middle], within)
        share = place_sr[within] @ per_place
        np.add.at(weight, known[points], share)
        np.add.at(beyond, known[points], np.where(owned[within], place_sr[within], 0.0) @ per_place)
        errors = holes.errors(place[middle], within, rough)
        if len(errors):
            common += float(errors.mean())
            own2 += float(errors.var())
        else:
            own2 += float(share @ holes.dsf[points]) ** 2
        # What their owners give to places that they own is in the measured sum already.
        mine = within[owned[within]]
        owner = known[tree.query(place[mine])[1]]
        for of in (weight, beyond):
            np.add.at(of, owner, -place_sr[mine])
    shallow = np.flatnonzero(left & ~owned)
    if len(shallow):  # here every measured point counts, not only the known ones
        all_tree = tree if every == 1 else cKDTree(unit[measured], balanced_tree=False)
        own, other = _nearest_and_beyond(all_tree, unit[measured], place[shallow])
        np.add.at(weight, measured[own], place_sr[shallow])
        dsf = distribution.dsf_per_sr[measured]
        common += float(place_sr[shallow] @ (dsf[own] - dsf[other]))
    at_edge = float(beyond[measured] @ distribution.dsf_per_sr[measured])
    return Fill(weight, float(np.hypot(common, np.sqrt(own2))), at_edge, unfilled_sr)


@dataclass(frozen=True)
class _Holes:
    """Places (m, 3) without a value, their solid angles and distances [rad] to the nearest measured point; the measured
    points (k, 3) about them, their DSF and cells; search trees of both."""

    place: FloatArray
    place_sr: FloatArray
    depth: FloatArray
    known: FloatArray
    dsf: FloatArray
    cell_sr: FloatArray
    place_tree: cKDTree
    known_tree: cKDTree

    def model(self, middle: FloatArray, within: IntArray) -> tuple[IntArray, FloatArray, float]:
        """Measured points (j,) and weights (places, j): the model at each place as a sum over their DSF; and how far
        the model misses the ring itself, root mean square [1/sr]."""
        reach = self._reach(middle, within)
        points = np.asarray(self.known_tree.query_ball_point(middle, _chord(reach)), dtype=np.intp)
        if not len(points):
            points = np.atleast_1d(self.known_tree.query(middle)[1])
        frame = tangent_frame(middle)
        places = _plane(self.known[points], frame, reach)
        operator = _operator(places, self.cell_sr[points])
        rough = _misfit(places, self.dsf[points], self.cell_sr[points], operator)
        terms = _terms(_plane(self.place[within], frame, reach))[:, : len(operator)]
        return points, terms @ operator, rough

    def errors(self, middle: FloatArray, within: IntArray, rough: float) -> FloatArray:
        """What the model misses (places,) at places next to the patch, scaled to the patch's solid angle; and, where
        the model misses the patch's own ring (by `rough`) by more than the rings there, up in that proportion."""
        size = _angle_rad(np.linalg.norm(self.place[within] - middle, axis=1)).max()
        reach, patch_sr = self._reach(middle, within), float(self.place_sr[within].sum())
        frame = tangent_frame(middle)
        found, roughs = [], []
        for azimuth in 2.0 * np.pi * np.arange(_PLACES) / _PLACES:
            towards = np.cos(azimuth) * frame[0] + np.sin(azimuth) * frame[1]
            step = 1.1 * (size + self.depth[within].max())
            there = np.cos(step) * middle + np.sin(step) * towards
            if there[2] * middle[2] < 0.0:
                continue
            points = np.asarray(self.known_tree.query_ball_point(there, _chord(reach)), dtype=np.intp)
            if len(points) < 2 * _LEAST_POINTS:
                continue
            # The surroundings of `there`, turned to lie about the middle.
            back = _turned(self.known[points], np.cross(towards, middle), step)
            to_hole, hole = self.place_tree.query(back)
            inside = to_hole < self.known_tree.query(back)[0]
            of_patch = inside & np.isin(hole, within)
            covered_sr = float(self.cell_sr[points][of_patch].sum())
            ring = points[~inside]
            if not 0.7 * patch_sr < covered_sr < 1.4 * patch_sr or len(ring) < _LEAST_POINTS:
                continue
            places = _plane(back[~inside], frame, reach)
            operator = _operator(places, self.cell_sr[ring])
            roughs.append(_misfit(places, self.dsf[ring], self.cell_sr[ring], operator))
            terms = _terms(_plane(back[of_patch], frame, reach))[:, : len(operator)]
            missed = terms @ (operator @ self.dsf[ring]) - self.dsf[points][of_patch]
            found.append(patch_sr * float(missed @ self.cell_sr[points][of_patch]) / covered_sr)
        usual = float(np.sqrt(np.mean(np.square(roughs)))) if roughs else 0.0
        return np.array(found) * (max(1.0, rough / usual) if usual > 0.0 else 1.0)

    def _reach(self, middle: FloatArray, within: IntArray) -> float:
        size = float(_angle_rad(np.linalg.norm(self.place[within] - middle, axis=1)).max())
        ring = np.clip(_RING * size, np.radians(_RING_LEAST_DEG), np.radians(_RING_MOST_DEG))
        return size + float(max(ring, self.depth[within].max() - size + np.radians(_RING_LEAST_DEG)))


def _nearest_and_beyond(tree: cKDTree, unit: FloatArray, place: FloatArray) -> tuple[IntArray, IntArray]:
    """For places (m, 3) the nearest of the points (n, 3) of the tree, and the one nearest to as far on its other
    side."""
    own = np.asarray(tree.query(place)[1], dtype=np.intp)
    beyond = 2.0 * unit[own] - place
    beyond /= np.linalg.norm(beyond, axis=1)[:, None]
    return own, np.asarray(tree.query(beyond)[1], dtype=np.intp)


def _uncovered_places(
    tree: cKDTree, masked: FloatArray, uncovered_sr: float, upwards: bool
) -> tuple[FloatArray, FloatArray]:
    """Directions of a lattice over the hemisphere: those that no cell covers (m, 3), and those beyond the outermost
    tracks that their points own (k, 3). `tree`: of the measured points; `masked` (j, 3).

    No point owns area beyond its reach, so what is not covered lies farthest from all points: as many places as make up
    the uncovered solid angle. The nearest of them tells the reach, 1.5 times the distance of the tracks: between tracks
    no place is farther from a point than a third of that.
    """
    turn = np.arange(_LATTICE)
    z = (turn + 0.5) / _LATTICE * (1.0 if upwards else -1.0)
    across, azimuth = np.sqrt(1.0 - z * z), turn * np.pi * (3.0 - np.sqrt(5.0))
    lattice = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=1)
    to_measured = tree.query(lattice)[0]
    to_masked = cKDTree(masked, balanced_tree=False).query(lattice)[0] if len(masked) else np.full(_LATTICE, np.inf)
    distance = np.minimum(to_measured, to_masked)
    count = max(1, round(uncovered_sr / (2.0 * np.pi) * _LATTICE))
    order = np.argsort(-distance)
    uncovered, rest = order[:count], order[count:]
    edge = rest[(distance[rest] > _BETWEEN_TRACKS * distance[uncovered[-1]]) & (to_measured[rest] < to_masked[rest])]
    return lattice[uncovered], lattice[edge]


def _operator(xy: FloatArray, weight: FloatArray) -> FloatArray:
    """Coefficients (t, j) of the model per value: quadratic (t = 6), plane (3) or mean (1), as the places carry it. By
    the normal equations: with six terms in units of the reach they lose nothing that matters, and cost a tenth."""
    terms = _terms(xy)
    for count in (6, 3, 1):
        design = terms[:, :count]
        weighted = design * weight[:, None]
        normal = design.T @ weighted
        eigenvalue = np.linalg.eigvalsh(normal)
        if count == 1 or (len(xy) >= 2 * count and eigenvalue[0] > _CONDITION**2 * eigenvalue[-1]):
            break
    return np.asarray(np.linalg.solve(normal, weighted.T))


def _misfit(xy: FloatArray, dsf: FloatArray, weight: FloatArray, operator: FloatArray) -> float:
    missed = _terms(xy)[:, : len(operator)] @ (operator @ dsf) - dsf
    return float(np.sqrt(weight @ missed**2 / weight.sum()))


def _terms(xy: FloatArray) -> FloatArray:
    x, y = xy[:, 0], xy[:, 1]
    return np.stack((np.ones_like(x), x, y, x * x, x * y, y * y), axis=1)


def _plane(unit: FloatArray, frame: FloatArray, reach: float) -> FloatArray:
    """Coordinates (n, 2) across the frame's pole, in units of the reach: linear in the direction, as a cosine is."""
    return np.asarray(unit @ frame[:2].T / reach)


def _turned(unit: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
    """Directions (n, 3) turned about the axis by the angle (O. Rodrigues, 1840)."""
    axis = axis / np.linalg.norm(axis)
    along = (unit @ axis)[:, None] * axis
    return np.asarray(along + np.cos(angle) * (unit - along) + np.sin(angle) * np.cross(axis, unit))


def _angle_rad(chord: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))


def _chord(angle_rad: float) -> float:
    return 2.0 * float(np.sin(0.5 * min(angle_rad, np.pi)))
