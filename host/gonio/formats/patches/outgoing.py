"""outgoing.py: adaptive cubature of distributions over cells of outgoing directions, many incident directions at once.

Cells are rectangles in polar angle and azimuth. Level by level all cells are evaluated in one call at NODES x NODES
Gauss nodes. A cell is divided where the highest Legendre modes of its values have not died away, and, unseen, where a
narrow peak that the scattering names is near and the nodes would be too far apart for it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.rules import NODES, gauss, last_modes

BoolArray = NDArray[np.bool_]

_MOST_LEVELS = 12
_WIDEST_SIGMA = 5.0  # of a cell beside a peak, in the peak's standard deviations
_REACH_SIGMA = 4.5  # how far from its centre a peak is looked after
_SHORT = 0.5  # an axis is divided too when its extent, or its mode, is over this share of the other's
# Error of a cell's integral over its last mode: the rule is exact far beyond it, so that this is cautious (on Gaussian
# peaks the estimate is ten times the error and more: tests/formats/test_double_averages.py).
_MODE_SHARE = 0.002


@dataclass(frozen=True)
class Cells:
    """n cells: row of the incident direction, number of the base cell, limits [rad] in polar angle and azimuth."""

    row: IndexArray
    base: IndexArray
    polar: FloatArray  # (n, 2) from, to
    azimuth: FloatArray  # (n, 2)

    def __len__(self) -> int:
        return len(self.row)

    def take(self, index: IndexArray | BoolArray) -> "Cells":
        return Cells(self.row[index], self.base[index], self.polar[index], self.azimuth[index])

    @staticmethod
    def joined(parts: list["Cells"]) -> "Cells":
        return Cells(
            *(np.concatenate([getattr(p, name) for p in parts]) for name in ("row", "base", "polar", "azimuth"))
        )

    def halved(self, axis: str) -> "Cells":
        """Both halves of each cell, along "polar" or "azimuth", next to each other."""
        limits: FloatArray = getattr(self, axis)
        middle = limits.mean(axis=1)
        twice = self.take(np.repeat(np.arange(len(self)), 2))
        new = np.repeat(limits, 2, axis=0)
        new[0::2, 1] = middle
        new[1::2, 0] = middle
        polar, azimuth = (new, twice.azimuth) if axis == "polar" else (twice.polar, new)
        return Cells(twice.row, twice.base, polar, azimuth)


@dataclass(frozen=True)
class Base:
    """The first cells of every row: limits [rad] (c, 2) each."""

    polar: FloatArray
    azimuth: FloatArray

    def of_rows(self, rows: int) -> Cells:
        count = len(self.polar)
        return Cells(
            np.repeat(np.arange(rows), count),
            np.tile(np.arange(count), rows),
            np.tile(self.polar, (rows, 1)),
            np.tile(self.azimuth, (rows, 1)),
        )


@dataclass(frozen=True)
class Done:
    """Cells that need no division: values (n, NODES, NODES) of DSF sin(polar), polar nodes first; error (n,) estimate
    of the cell's integral."""

    cells: Cells
    values: FloatArray
    error: FloatArray


def integrate(component: Component, incident: FloatArray, base: Base, tolerance: float) -> Iterator[Done]:
    """Cells that together cover `base` once for every incident direction (k, 3).

    Errors of a row are to be within `tolerance` of the row's sum. Cells that are not good enough after _MOST_LEVELS
    divisions come with the error they have.
    """
    centre, sigma, of_row = component.peaks(incident)
    order = np.argsort(of_row, kind="stable")
    peaks = _Peaks(centre[order], sigma[order], np.searchsorted(of_row[order], np.arange(len(incident) + 1)))
    active = base.of_rows(len(incident))
    total = np.zeros(len(incident))
    for level in range(_MOST_LEVELS + 1):
        last = level == _MOST_LEVELS
        if not last:
            active = _near_peaks_divided(component, active, peaks)
        values = _evaluated(component, incident, active)
        area = (active.polar[:, 1] - active.polar[:, 0]) * (active.azimuth[:, 1] - active.azimuth[:, 0])
        _, weight = gauss()
        integral = area * np.einsum("nab,a,b->n", values, weight, weight)
        found = total + np.bincount(active.row, integral, minlength=len(incident))
        along_polar, along_azimuth = _modes(values)
        error = _MODE_SHARE * area * (along_polar + along_azimuth)
        bad = error > tolerance * np.maximum(found[active.row], 1e-12) / len(base.polar)
        if last:
            bad[:] = False
        good = ~bad
        total += np.bincount(active.row[good], integral[good], minlength=len(incident))
        if good.any():
            yield Done(active.take(good), values[good], error[good])
        if not bad.any():
            return
        active = _divided(active.take(bad), along_polar[bad], along_azimuth[bad])


@dataclass(frozen=True)
class _Peaks:
    centre: FloatArray
    sigma_rad: FloatArray
    start: IndexArray  # (rows + 1,)


def _evaluated(component: Component, incident: FloatArray, cells: Cells) -> FloatArray:
    nodes, _ = gauss()
    polar = cells.polar.mean(axis=1)[:, None] + 0.5 * (cells.polar[:, 1] - cells.polar[:, 0])[:, None] * nodes
    azimuth = cells.azimuth.mean(axis=1)[:, None] + 0.5 * (cells.azimuth[:, 1] - cells.azimuth[:, 0])[:, None] * nodes
    shape = (len(cells), NODES, NODES)
    unit = component.outgoing(
        np.broadcast_to(polar[:, :, None], shape).reshape(-1), np.broadcast_to(azimuth[:, None, :], shape).reshape(-1)
    )
    values = component.values(incident, unit, np.repeat(cells.row, NODES * NODES))
    return np.asarray(values.reshape(shape) * np.sin(polar)[:, :, None])


def _modes(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean size (n,) of the last two Legendre modes along polar angle and azimuth, the last but one counted less."""
    _, weight = gauss()
    share = np.array([0.2, 1.0])
    polar = np.einsum("m,nmb,b->n", share, np.abs(np.einsum("ma,nab->nmb", last_modes(), values)), weight)
    azimuth = np.einsum("m,nma,a->n", share, np.abs(np.einsum("mb,nab->nma", last_modes(), values)), weight)
    return polar, azimuth


def _divided(cells: Cells, along_polar: FloatArray, along_azimuth: FloatArray) -> Cells:
    both = np.minimum(along_polar, along_azimuth) > _SHORT * np.maximum(along_polar, along_azimuth)
    polar = both | (along_polar >= along_azimuth)
    return _split(cells, polar, both | ~polar)


def _split(cells: Cells, polar: BoolArray, azimuth: BoolArray) -> Cells:
    """Cells halved along the axes that are marked (n,), in the order of their rows."""
    parts = [
        cells.take(polar & azimuth).halved("polar").halved("azimuth"),
        cells.take(polar & ~azimuth).halved("polar"),
        cells.take(azimuth & ~polar).halved("azimuth"),
        cells.take(~(polar | azimuth)),
    ]
    joined = Cells.joined(parts)
    return joined.take(np.argsort(joined.row, kind="stable"))


def _near_peaks_divided(component: Component, cells: Cells, peaks: _Peaks) -> Cells:
    """Halved until no cell within reach of a peak is wider than _WIDEST_SIGMA of it."""
    if not len(peaks.sigma_rad):
        return cells
    settled = []
    while len(cells):
        count = np.diff(peaks.start)[cells.row]
        cell = np.repeat(np.arange(len(cells)), count)
        first = np.repeat(np.cumsum(count) - count, count)
        peak = peaks.start[cells.row][cell] + np.arange(len(cell)) - first
        polar, azimuth = cells.polar.mean(axis=1), cells.azimuth.mean(axis=1)
        centre = component.outgoing(polar, azimuth)
        high = cells.polar[:, 1] - cells.polar[:, 0]
        wide = (cells.azimuth[:, 1] - cells.azimuth[:, 0]) * np.sin(np.minimum(cells.polar[:, 1], np.pi / 2))
        chord = np.linalg.norm(centre[cell] - peaks.centre[peak], axis=1)
        apart = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
        sigma = peaks.sigma_rad[peak]
        near = apart < 0.5 * np.hypot(high, wide)[cell] + _REACH_SIGMA * sigma
        least = np.full(len(cells), np.inf)
        np.minimum.at(least, cell[near], sigma[near])
        polar_too = high > _WIDEST_SIGMA * least
        azimuth_too = wide > _WIDEST_SIGMA * least
        more = polar_too | azimuth_too
        settled.append(cells.take(~more))
        cells = _split(cells.take(more), polar_too[more], azimuth_too[more])
    joined = Cells.joined(settled)
    return joined.take(np.argsort(joined.row, kind="stable"))
