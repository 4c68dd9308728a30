"""starts.py: where a lobe may be: what stands out of the ground and the lobes known so far, and a first guess at it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.model.hemisphere import folded, tangent_axes, tangent_from_unit, unit_from_disc
from gonio.model.lobes.blobs import SIGMA_CELLS, find_blobs
from gonio.model.lobes.found import BROADEST_RAD, Found
from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.least_squares import trust

FloatArray = NDArray[np.float64]

ZOOM_CELLS = 48  # along a side of the grid about a lobe
ZOOM_LIMIT = 20000


@dataclass(frozen=True)
class Start:
    """A place where a lobe may be: unit vector, standard deviation [rad] of what stands out, and its height."""

    centre: FloatArray
    sigma: float
    contrast: float

    def same_place(self, other: "Start") -> bool:
        """Whether the other is likely to be the same thing."""
        away = float(np.arccos(np.clip(self.centre @ other.centre, -1.0, 1.0)))
        alike = 0.4 < self.sigma / other.sigma < 2.5
        return away < (1.5 * max(self.sigma, other.sigma) if alike else 0.7 * min(self.sigma, other.sigma))


class Standing:
    """What stands above the ground and the lobes known so far: left (c,) of each cell, level and variance to hold it
    against."""

    def __init__(self, found: Found) -> None:
        scene = found.scene
        explained = found.explained()
        ground = _ground(found, explained)
        self.left = scene.cell_mean - explained - ground
        level = np.maximum(np.abs(scene.cell_mean), explained + np.maximum(ground, 0.0))
        # near the horizon a cosine's level is next to nothing: what stands out there must be something elsewhere too
        self.level = np.maximum(level, 0.3 * scene.middle)
        self.variance = np.maximum(scene.cell_variance, self._roughness(found) ** 2)

    def _roughness(self, found: Found) -> FloatArray:
        """Noise (c,) as cells side by side tell that differ, for data that declare none: a share of the level where
        that is less than a few times the noise that is the same everywhere."""
        first = np.flatnonzero(np.diff(found.scene.home) == 1)
        if not len(first):
            return np.zeros_like(self.level)
        steps = 1.05 * np.abs(self.left[first + 1] - self.left[first])  # 1.48 / sqrt 2: standard deviation of one
        everywhere = float(np.median(steps))
        share = float(np.median(steps / np.maximum(self.level[first], 1e-300)))
        return np.asarray(np.minimum(share * self.level, 3.0 * everywhere))


def starts_of(found: Found, standing: Standing, given_up: list[Start]) -> list[Start]:
    """What stands out on the whole hemisphere, highest first."""
    scene = found.scene
    weight = scene.cell_weight.copy()
    for start in given_up:
        # a spike that was no lobe would hide broad ones
        if start.sigma < 3.0 * scene.cell_rad:
            weight[scene.cell_unit @ start.centre > np.cos(2.0 * start.sigma)] = 0.0

    def grid(values: FloatArray) -> FloatArray:
        flat = np.zeros(scene.size**2)
        flat[scene.home] = values
        return flat.reshape(scene.size, scene.size)

    blobs = find_blobs(
        grid(weight), grid(standing.left), grid(standing.level), grid(standing.variance), floor=found.least_floor
    )
    starts = []
    for blob in blobs:
        disc = np.array([blob.column + 0.5, blob.row + 0.5]) * (2.0 / scene.size) - 1.0
        starts.append(Start(unit_from_disc(disc), SIGMA_CELLS * blob.cells * scene.cell_rad, blob.contrast))
    return _distinct(starts, given_up)


def starts_at(found: Found, standing: Standing, hints: tuple[FloatArray, ...], given_up: list[Start]) -> list[Start]:
    """Hints (unit vectors) where the mean of the nearest cells is above ground, lobes and noise, however little."""
    scene = found.scene
    starts = []
    for hint in hints:
        centre = folded(np.asarray(hint, dtype=np.float64))
        cells = scene.cells_near(centre, scene.cell_rad)
        if not len(cells):
            continue
        height = float(standing.left[cells].mean())
        noise = float(np.sqrt(standing.variance[cells].sum())) / len(cells)
        if height > max(3.0 * noise, 0.03 * float(standing.level[cells].mean())):
            starts.append(Start(centre, SIGMA_CELLS * scene.cell_rad, height))
    return _distinct(starts, given_up)


def starts_near(found: Found, lobe: Gauss, given_up: list[Start]) -> list[Start]:
    """What stands out about a narrow lobe where the points are dense: finer than the cells of the hemisphere."""
    pitch = found.scene.finest_near(lobe.centre)
    sigma = float(lobe.sigma[1])
    if pitch > 0.5 * found.scene.cell_rad or float(lobe.sigma[0]) > 3.0 * found.scene.cell_rad:
        return []
    cell = max(pitch, 0.4 * float(lobe.sigma[0]))
    half = 0.5 * ZOOM_CELLS * cell
    nodes = found.scene.points_near(found.scene.cells_near(lobe.centre, half), lobe.centre, half, ZOOM_LIMIT)
    left = nodes.value - sum((g.value(nodes.unit) for g in found.lobes), np.zeros(len(nodes)))
    axes = tangent_axes(lobe.centre)
    place = ((tangent_from_unit(axes, nodes.unit) + half) / cell).astype(np.int64).clip(0, ZOOM_CELLS - 1)
    key = place[:, 1] * ZOOM_CELLS + place[:, 0]
    weight = np.asarray(np.bincount(key, nodes.weight, ZOOM_CELLS**2), dtype=np.float64)
    safe = np.where(weight > 0.0, weight, 1.0)

    def grid(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(key, values, ZOOM_CELLS**2).reshape(ZOOM_CELLS, ZOOM_CELLS))

    shape = (ZOOM_CELLS, ZOOM_CELLS)
    divisor = safe.reshape(shape)
    blobs = find_blobs(
        weight.reshape(shape),
        grid(nodes.weight * left) / divisor,
        grid(nodes.weight * np.maximum(np.abs(nodes.value), np.abs(nodes.value - left))) / divisor,
        grid(nodes.weight**2 * nodes.variance) / divisor**2,
        floor=max(found.least_floor, 1e-4 * lobe.peak),
    )
    starts = []
    for blob in blobs:
        offset = (np.array([blob.column, blob.row]) + 0.5) * cell - half
        centre = np.cos(np.hypot(*offset)) * axes[2] + np.sinc(np.hypot(*offset) / np.pi) * (offset @ axes[:2])
        if float(np.hypot(*offset)) > 1.5 * sigma and centre[2] > 0.0:
            starts.append(Start(centre, SIGMA_CELLS * blob.cells * cell, blob.contrast))
    return _distinct(starts, given_up)


def _distinct(starts: list[Start], given_up: list[Start]) -> list[Start]:
    """Highest first, each place once."""
    chosen: list[Start] = []
    for start in sorted(starts, key=lambda s: -s.contrast):
        if not any(start.same_place(other) for other in (*chosen, *given_up)):
            chosen.append(start)
    return chosen


def _ground(found: Found, explained: FloatArray) -> FloatArray:
    """Smooth ground (c,) under the lobes: a quadratic on the disc that shuns what stands out."""
    means = found.scene.means(2)
    nodes = means.nodes
    value = nodes.value - means.of(explained)
    basis, in_cells = found.ground_basis()
    plain = trust(nodes, np.abs(nodes.value), found.least_floor)
    weight = plain
    coefficients: FloatArray = np.zeros(len(basis))
    for _ in range(4):
        weighted = basis * weight
        coefficients = np.asarray(np.linalg.lstsq(weighted @ basis.T, weighted @ value, rcond=1e-12)[0])
        off = np.abs(value - coefficients @ basis)
        typical = 3.0 * float(np.median(off)) + 1e-12 * found.scene.mean
        weight = plain / (1.0 + (off / typical) ** 2)
    return np.asarray(coefficients @ in_cells)


def guess(found: Found, start: Start) -> Gauss | None:
    """A lobe by moments of the squared rest, in windows that close in on it; None where there is too little.

    For a Gaussian p exp(-q / 2) the second moment weighted by its square is C / 2, and the integral of its cube over
    that of its square 2 p / 3.
    """
    radius = 2.5 * start.sigma
    near = found.scene.cells_near(start.centre, radius)
    nodes, beside, _ = found.nodes(near, start.centre, radius, start.sigma, ())
    if len(nodes) < 6:
        return None
    rest = nodes.value - beside
    fifth = len(rest) // 5
    rest = np.maximum(rest - np.partition(rest, fifth)[fifth], 0.0)
    centre = start.centre
    if start.sigma < 3.0 * found.scene.cell_rad:
        within = nodes.unit @ start.centre >= np.cos(1.5 * start.sigma)
        if within.any():
            centre = nodes.unit[np.argmax(np.where(within, rest, -np.inf))]
            radius = 1.5 * start.sigma
    covariance, peak, pitch = np.eye(2) * start.sigma**2, float(rest.max()), found.scene.pitch_rad
    for _ in range(5):
        away = nodes.unit @ centre
        tenth = float(np.partition(away, -min(10, len(away)))[-min(10, len(away))])
        inside = away >= min(np.cos(radius), tenth)
        pitch = float(np.sqrt(np.median(nodes.weight[away >= tenth])))
        w = nodes.weight[inside] * rest[inside] ** 2
        total = float(w.sum())
        if total <= 0.0:
            return None
        axes = tangent_axes(centre)
        u = tangent_from_unit(axes, nodes.unit[inside])
        mean = w @ u / total
        covariance = 2.0 * (((u - mean) * w[:, None]).T @ (u - mean)) / total
        peak = 1.5 * float(w @ rest[inside]) / total
        moved = centre + mean @ axes[:2]
        centre = folded(moved / np.linalg.norm(moved))
        radius = float(np.clip(2.5 * np.sqrt(np.linalg.eigvalsh(covariance)[1]), 1e-6, 2.5 * start.sigma))
    values, vectors = np.linalg.eigh(covariance)
    values = np.clip(values, (0.4 * pitch) ** 2, BROADEST_RAD**2)
    return Gauss.of(centre, (vectors * values) @ vectors.T, max(peak, found.least_floor))
