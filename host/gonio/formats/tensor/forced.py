"""forced.py: cells of a tree that must be looked into whatever their points say, for a narrow peak lies there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import FloatArray, Scattering
from gonio.formats.tensor.frame import Component, incident_points, place_of, turned
from gonio.formats.tensor.square import IndexArray, packed

_MOST_INCIDENT_LEVEL = {3: 10, 4: 6}  # of T4 there would be 4^10 incident cells
_WIDEST = 1.5  # a cell no wider than this, in standard deviations, shows its peak to its own points
_RINGS = (1.0, 2.5, 4.0)  # about a peak that are marked, in standard deviations; a bright peak is seen so far out
_ASIDE = 0.3  # of a cell's width that a peak moves within an incident cell, beside those that were asked for
_THROUGH = np.array([-1.0, -1.0, -1.0])
_SEEN_THROUGH = 1.5  # a peak seen through has at most this standard deviation, in widths of the finest cell
_TURNS = np.arange(16) * (np.pi / 8.0)
_AROUND = np.concatenate([[[0.0, 0.0]], *(r * np.stack((np.cos(_TURNS), np.sin(_TURNS)), 1) for r in _RINGS)])


@dataclass(frozen=True)
class Forced:
    """Packed numbers of cells, sorted, per level: cells to be looked into (at the finest level those wider than a peak
    in them), and cells that stay split, for one sees through."""

    looked_into: tuple[IndexArray, ...]
    kept: tuple[IndexArray, ...]
    seen_sigma_rad: float | None = None  # standard deviation of the widest peak that one sees through

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
    return Forced((), ())


def _among(keys: tuple[IndexArray, ...], index: IndexArray, level: int) -> IndexArray:
    if level >= len(keys) or len(keys[level]) == 0:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(np.isin(packed(index, level), keys[level]))


def forced_cells(
    scattering: Scattering, component: Component, front_faces: Side, dimensions: int, resolution: int
) -> Forced:
    """Cells about the peaks that a scattering function names, for incident directions of half the finest cells."""
    incident_level = min(resolution + 1, _MOST_INCIDENT_LEVEL[dimensions])
    rows = _incident_rows(incident_level, dimensions) * [1.0, 1.0, component.incident_z]
    centre, sigma, row = _peaks(scattering, rows, component, front_faces)
    if len(centre) == 0:
        return no_forced()
    cell_rad = np.sqrt(np.pi) / (1 << resolution)
    reach = _ASIDE * np.sqrt(np.pi) / (1 << (incident_level - 1)) / np.maximum(np.abs(centre[:, 2]), 0.1)
    place, of = _places_about(centre, sigma, reach, rows[row], dimensions)
    looked = _keys(place, _wanted_level(centre, sigma)[of], resolution)
    aside = np.arccos(np.clip(np.einsum("nk,nk->n", centre, rows[row] * _THROUGH), -1.0, 1.0))
    seen = (sigma <= _SEEN_THROUGH * cell_rad) & (aside < sigma + cell_rad)
    if component.process != "Transmission" or not seen.any():
        return Forced(looked, ())
    narrow = np.flatnonzero(seen)
    wide = np.maximum(sigma[narrow], 0.6 * cell_rad)
    place, of = _places_about(centre[narrow], wide, 0.0 * wide, rows[row[narrow]], dimensions)
    kept = _keys(place, np.full(len(of), resolution), resolution)
    return Forced(tuple(np.union1d(a, b) for a, b in zip(looked, kept, strict=True)), kept, float(sigma[narrow].max()))


def peak_places(
    scattering: Scattering, rows: FloatArray, component: Component, front_faces: Side, dimensions: int
) -> tuple[FloatArray, IndexArray, IndexArray]:
    """Of incident directions (k, 3) in Radiance's frame: tree coordinates (m, dimensions) of places on and about their
    peaks, the row of each place (m,), and the level (m,) whose cells are no wider than the peak there."""
    centre, sigma, row = _peaks(scattering, rows, component, front_faces)
    place, of = _places_about(centre, sigma, 0.0 * sigma, rows[row], dimensions)
    return place, row[of], _wanted_level(centre, sigma)[of]


def _incident_rows(level: int, dimensions: int) -> FloatArray:
    """A unit vector with z >= 0 in every incident cell of a level."""
    if dimensions == 3:
        cells = np.arange(1 << max(level - 1, 0), dtype=np.int64)[:, None]
    else:
        cells = np.stack([axis.ravel() for axis in np.indices((1 << level, 1 << level))], axis=1).astype(np.int64)
    return np.asarray(incident_points(cells, level, 1, diagonal=False)[0][:, 0])


def _peaks(
    scattering: Scattering, rows: FloatArray, component: Component, front_faces: Side
) -> tuple[FloatArray, FloatArray, IndexArray]:
    """Peaks of incident directions (k, 3), all in Radiance's frame, that leave from the component's side."""
    features = scattering.features(turned(rows, front_faces))
    centre = turned(features.centre, front_faces)
    own = centre[:, 2] * component.outgoing_z > 1e-6
    return centre[own], features.sigma_rad[own], features.incident[own]


def _wanted_level(centre: FloatArray, sigma: FloatArray) -> IndexArray:
    """Level (p,) whose cells are no wider than peaks. A cell of level l is 2 / 2^l wide in cosines, which is
    1 / cos(theta) times as much in angle."""
    cos = np.maximum(np.abs(centre[:, 2]), 0.1)
    return np.asarray(np.maximum(np.ceil(np.log2(2.0 / (_WIDEST * sigma * cos))), 0.0).astype(np.int64))


def _places_about(
    centre: FloatArray, sigma: FloatArray, reach: FloatArray, incident: FloatArray, dimensions: int
) -> tuple[FloatArray, IndexArray]:
    """Tree coordinates (m, dimensions) of places on and about peaks (p, 3), and which peak each belongs to; the rings
    are wider by `reach` (p,) [rad]."""
    least = np.argmin(np.abs(centre), axis=1)
    first = np.cross(centre, np.eye(3)[least])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    axes = np.stack((first, np.cross(centre, first)), axis=1)  # two directions perpendicular to each
    length = np.linalg.norm(_AROUND, axis=1)
    angle = length * sigma[:, None] + (length > 0.0) * reach[:, None]
    step = _AROUND / np.maximum(length, 1e-300)[:, None]
    across = np.einsum("ok,pkj->poj", step, axes)
    out = centre[:, None, :] * np.cos(angle)[..., None] + across * np.sin(angle)[..., None]
    of = np.repeat(np.arange(len(centre)), len(_AROUND))
    out = out.reshape(-1, 3)
    same_side = out[:, 2] * centre[of][:, 2] > 0.0
    out, of = out[same_side], of[same_side]
    return place_of(incident[of], out, dimensions), of


def _keys(place: FloatArray, wanted: IndexArray, resolution: int) -> tuple[IndexArray, ...]:
    """Per level to the finest, the packed numbers of the cells that hold places (m, dimensions) and are wider than
    those of their wanted level (m,)."""
    result: list[NDArray[np.int64]] = []
    for level in range(resolution + 1):
        index = np.floor(place[wanted > level] * (1 << level)).astype(np.int64)
        result.append(np.unique(packed(index, level)))
    return tuple(result)
