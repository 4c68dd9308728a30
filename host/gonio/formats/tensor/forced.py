"""forced.py: cells of a tree that must be looked into whatever their points say, for a narrow peak lies there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import FloatArray, Scattering
from gonio.formats.tensor.frame import Component, incident_points, place_of, turned
from gonio.formats.tensor.square import IndexArray, packed

_MOST_INCIDENT_LEVEL = {3: 9, 4: 6}  # of T4 there would be 4^9 incident cells
_WIDEST = 1.5  # a cell no wider than this, in standard deviations, shows its peak to its own points
_RINGS = (1.0, 2.5, 4.0)  # about a peak that are marked, in standard deviations; a bright peak is seen so far out
_THROUGH = np.array([-1.0, -1.0, -1.0])
_SEEN_THROUGH = 1.5  # a peak seen through has at most this standard deviation, in widths of the finest cell


@dataclass(frozen=True)
class Forced:
    """Packed numbers of cells, sorted, per level: cells to be looked into, and cells that stay split (view-through)."""

    looked_into: tuple[IndexArray, ...]
    kept: tuple[IndexArray, ...]
    narrowest_rad: float | None  # standard deviation of the narrowest peak

    def among(self, index: IndexArray, level: int) -> IndexArray:
        """Which of a level's cells (n, dimensions) are to be looked into."""
        return _among(self.looked_into, index, level)

    def kept_among(self, index: IndexArray, level: int) -> IndexArray:
        """Which of a level's cells (n, dimensions) stay split."""
        return _among(self.kept, index, level)

    @property
    def view_through(self) -> bool:
        return any(len(keys) for keys in self.kept)


def no_forced() -> Forced:
    return Forced((), (), None)


def _among(keys: tuple[IndexArray, ...], index: IndexArray, level: int) -> IndexArray:
    if level >= len(keys) or len(keys[level]) == 0:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(np.isin(packed(index, level), keys[level]))


def forced_cells(
    scattering: Scattering, component: Component, front_faces: Side, dimensions: int, resolution: int
) -> Forced:
    """Cells about the peaks that a scattering function names, for the incident directions of the finest cells."""
    incident_level = min(resolution, _MOST_INCIDENT_LEVEL[dimensions])
    split = dimensions - 2
    side = np.arange(1 << incident_level) if split == 2 else np.arange(1 << (incident_level - 1))
    cells = np.stack([axis.ravel() for axis in np.meshgrid(*([side] * split), indexing="ij")], axis=1).astype(np.int64)
    points = np.concatenate(
        [
            incident_points(cells[i : i + 1024], incident_level, 1, diagonal=False)[0][:, 0]
            for i in range(0, len(cells), 1024)
        ]
    )
    incident_r = points * [1.0, 1.0, component.incident_z]
    incident = turned(incident_r, front_faces)
    features = scattering.features(incident)
    centre = turned(features.centre, front_faces)
    own = centre[:, 2] * component.outgoing_z > 1e-6
    centre, sigma, row = centre[own], features.sigma_rad[own], features.incident[own]
    if len(centre) == 0:
        return no_forced()
    # A cell of level l is 2 / 2^l wide in cosines, which is 1 / cos(theta) times as much in angle.
    cos = np.maximum(np.abs(centre[:, 2]), 0.1)
    wanted = np.clip(np.ceil(np.log2(2.0 / (_WIDEST * sigma * cos))), 0, resolution).astype(np.int64)
    cell_rad = np.sqrt(np.pi) / (1 << resolution)
    through = np.einsum("nk,nk->n", centre, incident_r[row] * _THROUGH)
    aside = np.arccos(np.clip(through, -1.0, 1.0))
    seen = (component.process == "Transmission") & (sigma <= _SEEN_THROUGH * cell_rad) & (aside < sigma + cell_rad)
    around, of = _places_about(centre, sigma, incident_r[row], dimensions)
    looked = _keys(around, wanted[of], incident_level, resolution)
    if not seen.any():
        return Forced(looked, (), float(sigma.min()))
    narrow = np.flatnonzero(seen)
    around, of = _places_about(
        centre[narrow], np.maximum(sigma[narrow], 0.6 * cell_rad), incident_r[row[narrow]], dimensions
    )
    kept = _keys(around, np.full(len(of), resolution), resolution, resolution)
    return Forced(tuple(np.union1d(a, b) for a, b in zip(looked, kept, strict=True)), kept, float(sigma.min()))


def _places_about(
    centre: FloatArray, sigma: FloatArray, incident: FloatArray, dimensions: int
) -> tuple[FloatArray, IndexArray]:
    """Tree coordinates (m, dimensions) of places on and about peaks (p, 3), and which peak each belongs to."""
    least = np.argmin(np.abs(centre), axis=1)
    first = np.cross(centre, np.eye(3)[least])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    axes = np.stack((first, np.cross(centre, first)), axis=1)  # two directions perpendicular to each
    turns = np.arange(16) * (np.pi / 8.0)
    offsets = np.concatenate([[[0.0, 0.0]], *(r * np.stack((np.cos(turns), np.sin(turns)), 1) for r in _RINGS)])
    angle = np.linalg.norm(offsets, axis=1)[None, :] * sigma[:, None]
    step = offsets / np.maximum(np.linalg.norm(offsets, axis=1, keepdims=True), 1e-300)
    across = np.einsum("ok,pkj->poj", step, axes)
    out = centre[:, None, :] * np.cos(angle)[..., None] + across * np.sin(angle)[..., None]
    of = np.repeat(np.arange(len(centre)), len(offsets))
    out = out.reshape(-1, 3)
    same_side = out[:, 2] * centre[of][:, 2] > 0.0
    out, of = out[same_side], of[same_side]
    return place_of(incident[of], out, dimensions), of


def _keys(place: FloatArray, wanted: IndexArray, incident_level: int, resolution: int) -> tuple[IndexArray, ...]:
    """Per level, the packed numbers of the cells that hold places (m, dimensions) and must be split on the way to their
    wanted level (m,)."""
    result: list[NDArray[np.int64]] = []
    for level in range(resolution):
        at = (wanted > level) & (level <= incident_level)
        index = np.floor(place[at] * (1 << level)).astype(np.int64)
        result.append(np.unique(packed(index, level)))
    return tuple(result)
