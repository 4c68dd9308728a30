"""tree.py: a tensor tree as a BSDF in any direction: constant in every cell, as Radiance looks it up."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin
from gonio.formats.tensor.flat import FlatTree
from gonio.formats.tensor.frame import Component, place_of, turned
from gonio.formats.tensor.square import disc_from_square
from gonio.formats.validity import Validity

Lookup = Callable[[FloatArray], FloatArray]  # values (m,) at places (m, dimensions)
_PEAK = 5.0  # a cell is named a peak from so many times the mean BSDF of its incident direction
_PEAK_GRID = 8  # one peak at most per cell of a grid of 8 x 8 over the hemisphere
_ROWS_AT_ONCE = 512


@dataclass(frozen=True)
class TreeScattering:
    """One band of a tensor tree file, in the frame of a sample whose front faces `front_faces` (Scattering).

    `rests`: where the file says that it rests on measurements; None: it does not say.
    """

    trees: dict[Component, FlatTree]
    channel: str
    front_faces: Side
    rests: Validity | None = None

    def bsdf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """BSDF [1/sr] (m,) of the cells; NaN where the file has no tree. Arguments as in Scattering."""
        return self.looked_up({component: tree.at for component, tree in self.trees.items()}, incident, outgoing, which)

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering; the cell's BSDF times |cos theta_s|."""
        return np.asarray(self.bsdf_per_sr(incident, outgoing, which) * np.abs(outgoing[:, 2]))

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering. An average over a cell is never called measured: INTERPOLATED, or what the file says."""
        there = ~np.isnan(self.bsdf_per_sr(incident, outgoing, which))
        found = np.full(len(outgoing), Origin.INTERPOLATED, dtype=np.uint8)
        if self.rests is not None:
            found = self.rests.origin(self.channel, incident, outgoing, which)
        return np.where(there, found, np.uint8(Origin.ABSENT))

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        into_room = self.front_faces == "interior"
        lit, leaves = (1.0 if front == into_room else -1.0 for front in (incident_front, outgoing_front))
        return any((c.incident_z, c.outgoing_z) == (lit, leaves) for c in self.trees)

    def features(self, incident: FloatArray) -> Features:
        """See Scattering: the brightest cells."""
        found = [
            self._peaks(component, tree, incident, np.arange(start, min(start + _ROWS_AT_ONCE, len(incident))))
            for component, tree in self.trees.items()
            for start in range(0, len(incident), _ROWS_AT_ONCE)
        ]
        if not found:
            return Features.none()
        return Features(
            np.concatenate([part.centre for part in found]),
            np.concatenate([part.sigma_rad for part in found]),
            np.concatenate([part.incident for part in found]),
        )

    def looked_up(
        self, at: dict[Component, Lookup], incident: FloatArray, outgoing: FloatArray, which: IndexArray | None
    ) -> FloatArray:
        """What `at` says of the places of pairs of directions, by component; NaN where it has none."""
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        source = turned(incident, self.front_faces)
        leaving = turned(outgoing, self.front_faces)
        # The horizon belongs to the sample's front, whichever way that faces.
        front_z = 1.0 if self.front_faces == "interior" else -1.0
        lit = np.where(incident[:, 2] >= 0.0, front_z, -front_z)[rows]
        out = np.where(outgoing[:, 2] >= 0.0, front_z, -front_z)
        result = np.full(len(outgoing), np.nan)
        for component, lookup in at.items():
            here = np.flatnonzero((lit == component.incident_z) & (out == component.outgoing_z))
            if len(here):
                place = place_of(source[rows[here]], leaving[here], self.trees[component].dimensions)
                result[here] = lookup(place)
        return result

    def _peaks(self, component: Component, tree: FlatTree, incident: FloatArray, rows: IndexArray) -> Features:
        source = turned(incident[rows], self.front_faces)
        lit = source[:, 2] * component.incident_z > 0.0
        rows, source = rows[lit], source[lit]
        if len(rows) == 0:
            return Features.none()
        split = tree.dimensions - 2
        normal = np.tile([0.0, 0.0, component.outgoing_z], (len(rows), 1))
        own = place_of(source, normal, tree.dimensions)[:, :split]
        row, corner, level, value = slices(tree, own)
        mean = np.bincount(row, value * 0.25**level, minlength=len(rows))
        bright = np.flatnonzero(value > _PEAK * mean[row])
        row, corner, level, value = row[bright], corner[bright], level[bright], value[bright]
        middle = corner + 0.5 * 0.5 ** level[:, None]
        part = np.floor(middle * _PEAK_GRID).astype(np.int64)
        key = (row * _PEAK_GRID + part[:, 0]) * _PEAK_GRID + part[:, 1]
        order = np.lexsort((-value, key))
        first = order[np.unique(key[order], return_index=True)[1]]
        xy = disc_from_square(middle[first])
        if split == 1:  # T3's directions are turned until -incident lies on +x; back again
            phi = np.arctan2(-source[row[first], 1], -source[row[first], 0])
            c, s = np.cos(phi), np.sin(phi)
            xy = np.stack((c * xy[:, 0] - s * xy[:, 1], s * xy[:, 0] + c * xy[:, 1]), axis=1)
        z = np.sqrt(np.maximum(1.0 - np.sum(xy**2, axis=1), 1e-12))
        unit = np.concatenate((xy, component.outgoing_z * z[:, None]), axis=1)
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        return Features(turned(unit, self.front_faces), np.sqrt(np.pi) * 0.5 ** level[first], rows[row[first]])


def slices(tree: FlatTree, incident: FloatArray) -> tuple[IndexArray, FloatArray, IndexArray, FloatArray]:
    """All cells of incident places (k, dimensions - 2): incident row (m,), lower corner (m, 2) in the outgoing square,
    level (m,), value (m,)."""
    split = tree.dimensions - 2
    row = np.arange(len(incident))
    node = np.zeros(len(incident), dtype=np.int64)
    corner = np.zeros((len(incident), 2))
    left = incident.copy()
    level = 0
    found = []
    halves = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    while len(row):
        grid = tree.child[node] < 0
        for log2 in np.unique(tree.log2[node[grid]]).tolist():
            at = np.flatnonzero(grid & (tree.log2[node] == log2))
            size = 1 << log2
            place = np.zeros(len(at), dtype=np.int64)
            for column in range(split):
                place = place * size + np.minimum((left[at, column] * size).astype(np.int64), size - 1)
            inner = np.arange(size * size)
            value = tree.values[tree.start[node[at]][:, None] + place[:, None] * size * size + inner]
            step = 0.5 ** (level + log2)
            offset = np.stack((inner // size, inner % size), axis=1) * step
            cells = (corner[at][:, None, :] + offset).reshape(-1, 2)
            found.append((np.repeat(row[at], size * size), cells, np.full(len(cells), level + log2), value.ravel()))
        at = np.flatnonzero(~grid)
        twice = 2.0 * left[at]
        upper = twice >= 1.0
        number = upper @ (1 << np.arange(split))
        branch = number[:, None] + (halves @ np.array([1 << split, 2 << split]))
        level += 1
        node = (tree.child[node[at]][:, None] + branch).ravel()
        corner = (corner[at][:, None, :] + halves * 0.5**level).reshape(-1, 2)
        row, left = np.repeat(row[at], 4), np.repeat(twice - upper, 4, axis=0)
    return (
        np.concatenate([part[0] for part in found]),
        np.concatenate([part[1] for part in found]),
        np.concatenate([part[2] for part in found]),
        np.concatenate([part[3] for part in found]),
    )


@dataclass(frozen=True)
class TristimulusTrees:
    """X or Z of a file with trees of Y, u' and v' (Scattering):

    X = Y 9 u' / (4 v'), Z = Y (12 - 3 u' - 20 v') / (4 v').
    """

    y: TreeScattering
    u: dict[Component, FlatTree]
    v: dict[Component, FlatTree]
    of_x: bool

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        u = self.y.looked_up({c: self.u[c].at for c in self.u}, incident, outgoing, which)
        v = self.y.looked_up({c: self.v[c].at for c in self.v}, incident, outgoing, which)
        share = (9.0 * u if self.of_x else 12.0 - 3.0 * u - 20.0 * v) / (4.0 * np.maximum(v, 1e-6))
        return np.asarray(self.y.dsf_per_sr(incident, outgoing, which) * np.maximum(share, 0.0))

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering."""
        return self.y.origin(incident, outgoing, which)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return self.y.covers(incident_front=incident_front, outgoing_front=outgoing_front)

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        return self.y.features(incident)
