"""resolve.py: a component's nodes and the way between them, resolved for any incident direction.

Per lobe that nodes share (tracks.py): offset from the ideal direction that it follows, logarithm of the peak, and
matrix logarithm of the covariance are interpolated (log-Euclidean mean: Arsigny et al. 2006), by weights of the
triangle or line, or as monotone cubics. What is left beside a lobe is carried in its whitened coordinates, in
proportion to the peak. A lobe that a node lacks fades with that node's weight, by the logarithm as between two peaks:
of what the node shows in its place it may have as much without being seen. Backgrounds are blended at rest or, as
BSDF, in coordinates beta - beta0 (direction cosines from the ideal direction). Beyond the nodes all is held in the
coordinates it moves in.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from gonio.model.between.mesh import Line, Stencil, Triangles
from gonio.model.between.scheme import Scheme
from gonio.model.between.tracks import FOLLOWS, Lobes, Matcher, Matches, Tracks, track
from gonio.model.grid_fit import grid_at
from gonio.model.hemisphere import Follows, disc_from_unit, ideal
from gonio.model.nodes.coverage import BEYOND, look_up
from gonio.model.nodes.frames import along_tangents, level_axes, symmetric_function, tangents
from gonio.model.nodes.node import Node
from gonio.model.nodes.symmetry import Images
from gonio.model.slices import Grids, Slices

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

_MOST_LOG_PEAK = 40.0
_LEAST_LOG_LEVEL = -7.0  # 1e-3 of a peak


@dataclass
class Resolver:
    """Nodes with their images, connected: everything that interpolation needs. `source` (e,): node of each image,
    `signs` (e, 2), `incident` (e, 3); `kept`: images that are connected (`without`)."""

    nodes: list[Node]
    images: Images
    scheme: Scheme
    source: IndexArray = field(init=False)
    signs: FloatArray = field(init=False)
    incident: FloatArray = field(init=False)
    kept: IndexArray = field(init=False)

    def __post_init__(self) -> None:
        measured = np.array([node.incident for node in self.nodes]).reshape(-1, 3)
        self.source, self.signs, self.incident = self.images.expand(measured)
        lobes = [Lobes.of(self.nodes[k], s) for k, s in zip(self.source, self.signs, strict=True)]
        self._connect(lobes, np.arange(len(lobes)), Matcher(lobes))
        self._gather(lobes)
        self.grids, self._patch_of, self._background_of = self._grids()

    def without(self, node: int) -> "Resolver":
        """The same without this node and its images: they are neither neighbours nor matched. May be repeated."""
        other = object.__new__(Resolver)
        other.__dict__.update(self.__dict__)
        kept = self.kept[self.source[self.kept] != node]
        other._connect(self._lobes, kept, self._matches)
        other._gather(self._lobes)
        return other

    def with_scheme(self, scheme: Scheme) -> "Resolver":
        """The same nodes, interpolated another way."""
        other = object.__new__(Resolver)
        other.__dict__.update(self.__dict__)
        other.scheme = scheme
        return other

    def with_nodes(self, nodes: list[Node]) -> "Resolver":
        """The same but for the nodes' scales."""
        other = object.__new__(Resolver)
        other.__dict__.update(self.__dict__)
        other.nodes = nodes
        return other

    def _connect(self, lobes: list[Lobes], kept: IndexArray, matches: Matches) -> None:
        self._lobes, self._matches, self.kept = lobes, matches, kept
        incident = self.incident[kept]
        self.mesh: Line | Triangles = Line(incident) if self.images.isotropic else Triangles(incident)
        self.tracks: Tracks = (
            track(lobes, kept[self.mesh.edges], matches) if len(kept) else Tracks(np.zeros((0, 0), dtype=np.int64), ())
        )
        if len(kept) < len(lobes):  # lobes of nodes that are left out make tracks of their own: off
            on = np.any(self.tracks.lobe[kept] >= 0, axis=0)
            self.tracks = Tracks(
                self.tracks.lobe[:, on], tuple(f for f, o in zip(self.tracks.follows, on, strict=True) if o)
            )

    def _gather(self, lobes: list[Lobes]) -> None:
        """Parameters (e, tracks, ...) of the lobes; zeros where a node has none."""
        lobe, number = self.tracks.lobe, len(self.tracks.follows)
        shape = (len(lobes), number)
        self._log_peak = np.zeros(shape)
        self._offset = np.zeros((*shape, 2))
        self._log_covariance = np.zeros((*shape, 2, 2))
        for e, t in zip(*np.nonzero(lobe >= 0), strict=True):
            own, index = lobes[e], lobe[e, t]
            self._log_peak[e, t] = own.log_peak[index]
            self._offset[e, t] = own.offset[self.tracks.follows[t]][index]
            self._log_covariance[e, t] = own.log_covariance[index]
        self._log_level = np.zeros(shape)
        for e, t in zip(*np.nonzero(lobe < 0), strict=True):
            on = lobe[:, t] >= 0
            self._log_level[e, t] = self._log_level_at(lobes[e], e, self.tracks.follows[t], self._offset[on, t])

    def _log_level_at(self, lobes: Lobes, image: int, follows: Follows, offset: FloatArray) -> float:
        """Logarithm of the DSF [1/sr] that an image shows where a lobe that it lacks would be, at the mean of offsets
        (n, 2) from what it follows."""
        axes = level_axes(ideal(follows, lobes.incident))
        place = along_tangents(axes, offset.mean(axis=0))
        place[2] = max(float(place[2]), 0.0)
        u = tangents(level_axes(lobes.centre), np.broadcast_to(place, lobes.centre.shape))
        precision = np.linalg.inv(symmetric_function(lobes.log_covariance, np.exp))
        level = float(np.exp(lobes.log_peak - 0.5 * np.einsum("li,lij,lj->l", u, precision, u)).sum())
        node = self.nodes[self.source[image]]
        disc = disc_from_unit(place / np.linalg.norm(place)) * self.signs[image]
        level += float(grid_at(node.background.astype(np.float64), 1.0, disc[None])[0])
        return float(np.log(max(level, 1e-300)))

    def _grids(self) -> tuple[Grids, list[IndexArray], IndexArray]:
        """All grids; number of the patch of each lobe of each image, and of each node's background. A patch's image
        changes signs of its coordinates, which level axes allow; a background is turned when it is read."""
        arrays: list[NDArray[np.float32]] = [node.background for node in self.nodes]
        common = self._common()
        moving = [_resized(node.background, len(common)) - common for node in self.nodes]
        self._common_at = len(arrays)
        arrays += [common, *moving]
        patch_of = []
        known: dict[tuple[int, float, float], IndexArray] = {}
        for source, (x, y) in zip(self.source, self.signs, strict=True):
            key = (int(source), float(x), float(y))
            if key not in known:
                patches = [p[:: int(y), :: int(x)] for p in self.nodes[source].patch]
                known[key] = np.arange(len(arrays), len(arrays) + len(patches), dtype=np.int64)
                arrays.extend(patches)
            patch_of.append(known[key])
        return Grids.of([np.asarray(a) for a in arrays]), patch_of, np.arange(len(self.nodes), dtype=np.int64)

    def _common(self) -> NDArray[np.float32]:
        """What most directions have in common at rest: the median of their backgrounds and all images of them."""
        size = max(len(node.background) for node in self.nodes)
        each = [_resized(node.background, size) for node in self.nodes]
        every = [array[:: int(y), :: int(x)] for array in each for x, y in self.images.signs]
        return np.asarray(np.median(every, axis=0), dtype=np.float32)

    def locate(self, incident: FloatArray) -> Stencil:
        """Neighbours among the images of folded incident directions (k, 3)."""
        found = self.mesh.locate(incident)
        return Stencil(self.kept[found.node], found.weight, found.origin, found.at)

    def slices(self, incident: FloatArray, *, scaled: bool = True) -> Slices:
        """Resolved for folded incident directions (k, 3), without the bound of energy (energy.py); `scaled`: with the
        nodes' own scales."""
        turn, level = self._turn(incident), self._levelled(incident)
        stencil = self.locate(level)
        lobes = self._resolved_lobes(level, stencil, turn)
        scale = np.ones(len(level))
        if scaled:
            own = np.array([self.nodes[k].scale for k in self.source])
            scale = np.einsum("kc,kc->k", own[stencil.node], stencil.weight)
        fields = self._moving_fields(level, stencil, turn)
        return Slices(scale, *lobes, *(self._with_rest(*fields, turn) if self.scheme.rest else fields))

    def _turn(self, incident: FloatArray) -> FloatArray:
        """(k, 2, 2): x and y of a direction in the frame in which the nodes lie; only isotropic samples are turned."""
        turn = np.broadcast_to(np.eye(2), (len(incident), 2, 2)).copy()
        if self.images.isotropic:
            across = np.hypot(incident[:, 0], incident[:, 1])
            some = across > 1e-12
            cos = np.where(some, incident[:, 0] / np.where(some, across, 1.0), 1.0)
            sin = np.where(some, incident[:, 1] / np.where(some, across, 1.0), 0.0)
            turn = np.stack((np.stack((cos, sin), axis=-1), np.stack((-sin, cos), axis=-1)), axis=-2)
        return turn

    def _resolved_lobes(
        self, incident: FloatArray, stencil: Stencil, turn: FloatArray
    ) -> tuple[IndexArray, FloatArray, FloatArray, FloatArray, IndexArray, IndexArray, FloatArray]:
        node, weight = stencil.node, stencil.weight
        lobe = self.tracks.lobe[node].transpose(0, 2, 1)  # (k, tracks, 3)
        share = np.where(lobe >= 0, weight[:, None, :], 0.0)
        present = share.sum(axis=2)
        row, column = np.nonzero(present > 1e-9)
        start = np.searchsorted(row, np.arange(len(incident) + 1)).astype(np.int64)
        own = share[row, column]  # (l, 3)
        mean = own / present[row, column][:, None]
        at = node[row]
        if self.scheme.curve == "pchip" and isinstance(self.mesh, Line):
            log_peak, offset, log_covariance = self._on_curves(self.mesh, stencil.at[row], column)
        else:
            log_peak = np.einsum("lc,lc->l", mean, self._log_peak[at, column[:, None]])
            offset = np.einsum("lc,lcd->ld", mean, self._offset[at, column[:, None]])
            log_covariance = np.einsum("lc,lcde->lde", mean, self._log_covariance[at, column[:, None]])
        where = self._ideal(incident[row], column)
        centre = along_tangents(level_axes(where), offset)
        frame = level_axes(centre)
        frame[..., :2] = np.einsum("lij,ljk->lik", frame[..., :2], turn[row])
        whitening = symmetric_function(-0.5 * log_covariance, np.exp)
        peak = np.exp(np.minimum(log_peak, _MOST_LOG_PEAK))
        which, corner = np.nonzero(own > 1e-9)
        image = at[which, corner]
        index = lobe[row[which], column[which], corner]
        first = np.array([p[0] if len(p) else 0 for p in self._patch_of], dtype=np.int64)
        patch_weight = own[which, corner] * np.exp(
            np.minimum(log_peak[which] - self._log_peak[image, column[which]], _MOST_LOG_PEAK)
        )
        patch_start = np.searchsorted(which, np.arange(len(row) + 1)).astype(np.int64)
        total = present[row, column]
        absent = np.where(lobe < 0, weight[:, None, :], 0.0)[row, column]
        level = np.einsum("lc,lc->l", absent, self._log_level[at, column[:, None]])
        fade = _faded(total, level / np.maximum(absent.sum(axis=1), 1e-300) - log_peak)
        peak *= fade
        patch_weight *= (fade / total)[which]
        return start, frame, whitening, peak, patch_start, first[image] + index, patch_weight

    def _ideal(self, incident: FloatArray, column: IndexArray) -> FloatArray:
        result = np.empty_like(incident)
        follows = np.array([FOLLOWS.index(f) for f in self.tracks.follows], dtype=np.int64)[column]
        for number, name in enumerate(FOLLOWS):
            rows = follows == number
            result[rows] = ideal(name, incident[rows])
        return result

    def _on_curves(self, line: Line, at: FloatArray, column: IndexArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Parameters of lobes (l,) at angles (l,) on the line, by monotone cubics through all nodes of the track; held
        beyond its ends."""
        log_peak, offset, log_covariance = np.zeros(len(at)), np.zeros((len(at), 2)), np.zeros((len(at), 2, 2))
        images = self.kept[line.order]
        for t in np.unique(column):
            rows = column == t
            on = self.tracks.lobe[images, t] >= 0
            own, knots = images[on], line.angle[line.order][on]
            if len(own) == 1:
                values = (self._log_peak[own[0], t], self._offset[own[0], t], self._log_covariance[own[0], t])
            else:
                s = np.clip(at[rows], knots[0], knots[-1])
                values = (
                    PchipInterpolator(knots, self._log_peak[own, t])(s),
                    PchipInterpolator(knots, self._offset[own, t])(s),
                    PchipInterpolator(knots, self._log_covariance[own, t])(s),
                )
            log_peak[rows], offset[rows], log_covariance[rows] = values
        return log_peak, offset, log_covariance

    def _moving_fields(
        self, incident: FloatArray, stencil: Stencil, turn: FloatArray
    ) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
        row, corner = np.nonzero(stencil.weight > 1e-9)
        image = stencil.node[row, corner]
        start = np.searchsorted(row, np.arange(len(incident) + 1)).astype(np.int64)
        signs = self.signs[image]
        shift = self._towards(self.incident[image]) - self._towards(incident[row])
        # The image's grid is its node's, read at the mirrored place.
        matrix = signs[:, :, None] * turn[row]
        moves = np.full(len(row), self.scheme.background != "fixed")
        weight = stencil.weight[row, corner]
        return start, self._background_of[self.source[image]], weight, matrix, signs * shift, moves

    def _with_rest(
        self,
        start: IndexArray,
        grid: IndexArray,
        weight: FloatArray,
        matrix: FloatArray,
        shift: FloatArray,
        moves: NDArray[np.bool_],
        turn: FloatArray,
    ) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
        """Before the backgrounds of each direction, now without what they have in common, one that rests."""
        at = start[:-1]
        return (
            start + np.arange(len(start)),
            np.insert(grid + self._common_at + 1, at, self._common_at),
            np.insert(weight, at, 1.0),
            np.insert(matrix, at, turn, axis=0),
            np.insert(shift, at, 0.0, axis=0),
            np.insert(moves, at, False),
        )

    def _towards(self, incident: FloatArray) -> FloatArray:
        """Direction cosines (k, 2) in which backgrounds stand still."""
        if self.scheme.background == "fixed":
            return np.zeros((len(incident), 2))
        return ideal(self.scheme.background, incident)[:, :2]

    def origin(self, incident: FloatArray) -> NDArray[np.uint8]:
        """INTERPOLATED or EXTRAPOLATED (k,) of folded incident directions (k, 3)."""
        return self.locate(self._levelled(incident)).origin

    def reached(self, incident: FloatArray, xy: FloatArray, which: IndexArray) -> NDArray[np.uint8]:
        """coverage.WITHIN, BETWEEN or BEYOND (m,): the best that a neighbouring node has towards these x and y (m, 2),
        in the coordinates in which the background stands still."""
        level = self._levelled(incident)
        stencil = self.locate(level)
        start, _, _, matrix, shift, _ = self._moving_fields(level, stencil, self._turn(incident))
        row, corner = np.nonzero(stencil.weight > 1e-9)
        result = np.full(len(xy), BEYOND, dtype=np.uint8)
        number = start[which + 1] - start[which]
        for k in range(int(number.max(initial=0))):
            has = np.flatnonzero(number > k)
            item = start[which[has]] + k
            at = np.einsum("mij,mj->mi", matrix[item], xy[has]) + shift[item]
            length = np.linalg.norm(at, axis=1, keepdims=True)
            at = at / np.maximum(length, 1.0)
            source = self.source[stencil.node[row[item], corner[item]]]
            for node in np.unique(source):
                own = source == node
                found = look_up(self.nodes[node].coverage, at[own])
                result[has[own]] = np.minimum(result[has[own]], found)
        return result

    def _levelled(self, incident: FloatArray) -> FloatArray:
        """Isotropic: turned to azimuth 0."""
        if not self.images.isotropic:
            return incident
        across = np.hypot(incident[:, 0], incident[:, 1])
        return np.stack((across, np.zeros(len(across)), incident[:, 2]), axis=1)


def _faded(share: FloatArray, log_level: FloatArray) -> FloatArray:
    """Factor of a lobe's peak between nodes that have it, with weights that add up to `share`, and nodes that lack it
    and show exp(log_level) of the peak there: 1 at the former, 0 at the latter, between them as the logarithm goes,
    which for a level as high as the peak is `share` itself."""
    log_level = np.clip(log_level, _LEAST_LOG_LEVEL, -1e-6)
    return np.asarray(np.expm1(-share * log_level) / np.expm1(-log_level))


def _resized(array: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    """A square grid over the same square with as many nodes per side."""
    if len(array) == size:
        return array
    axis = np.linspace(-1.0, 1.0, size)
    place = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    return np.asarray(grid_at(array.astype(np.float64), 1.0, place).reshape(size, size), dtype=np.float32)
