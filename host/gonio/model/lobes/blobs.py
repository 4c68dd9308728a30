"""blobs.py: places that stand out of their surroundings, at several sizes, on a square grid with holes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

OCTAVES = 4
NOISE_FACTOR = 5.0  # standard deviations: there are some 50,000 places where noise alone could stand out
SIGMA_CELLS = 1.5  # standard deviation, in cells of its octave, of the blob that answers most


@dataclass(frozen=True)
class Blob:
    """row, column: place on the finest grid, in cells; cells: side of a cell of its octave, in cells of the finest;
    contrast: height above its surroundings."""

    row: float
    column: float
    cells: int
    contrast: float


def find_blobs(
    weight: FloatArray, value: FloatArray, level: FloatArray, variance: FloatArray, *, floor: float
) -> list[Blob]:
    """Local maxima of (fine mean - mean of the surroundings) at four octaves, highest contrast first.

    Square grids: weight (0: nothing there), mean value, level that contrast is held against, variance of the mean.
    Means are weighted, so holes and rims cost nothing. Left out: what is below the floor, a share of the level or
    the noise.
    """
    found: list[Blob] = []
    value, level = weight * value, weight * level
    variance = weight**2 * variance
    for octave in range(OCTAVES):
        if octave:
            weight, value, level, variance = (_halved(a) for a in (weight, value, level, variance))
        fine = [_blurred(a, 1) for a in (weight, value, level)]
        wide = [_blurred(_blurred(a, 2), 4) for a in fine[:2]]
        there = fine[0] > 1e-12
        safe = np.where(there, fine[0], 1.0)
        contrast = np.where(there, fine[1] / safe - wide[1] / np.where(wide[0] > 0, wide[0], 1.0), -np.inf)
        # a broad rise has to be higher to be a lobe, and not the ground's own shape
        share = 0.03 * (1 + octave)
        noise2 = _blurred_variance(variance) / safe**2
        least = np.maximum(np.maximum(share * fine[2] / safe, floor), NOISE_FACTOR * np.sqrt(noise2))
        for row, column in np.argwhere((contrast > least) & there & _is_top(contrast)):
            cells = 2**octave
            found.append(
                Blob(
                    (row + 0.5) * cells - 0.5,
                    (column + 0.5) * cells - 0.5,
                    cells,
                    float(contrast[row, column]),
                )
            )
    return sorted(found, key=lambda b: -b.contrast)


def _halved(a: FloatArray) -> FloatArray:
    """Sums of 2 x 2 cells."""
    rows, columns = a.shape
    padded = np.pad(a, ((0, rows % 2), (0, columns % 2)))
    return np.asarray(padded[::2, ::2] + padded[1::2, ::2] + padded[::2, 1::2] + padded[1::2, 1::2])


def _blurred(a: FloatArray, step: int) -> FloatArray:
    """[1 2 1] / 4 along both axes, over neighbours `step` cells away; nothing beyond the rim."""
    b = 2.0 * a
    b[step:] += a[:-step]
    b[:-step] += a[step:]
    c = 2.0 * b
    c[:, step:] += b[:, :-step]
    c[:, :-step] += b[:, step:]
    return np.asarray(c / 16.0)


def _blurred_variance(a: FloatArray) -> FloatArray:
    """Variance of what _blurred(., 1) makes of independent cells."""
    b = 4.0 * a
    b[1:] += a[:-1]
    b[:-1] += a[1:]
    c = 4.0 * b
    c[:, 1:] += b[:, :-1]
    c[:, :-1] += b[:, 1:]
    return np.asarray(c / 256.0)


def _is_top(a: FloatArray) -> NDArray[np.bool_]:
    """Where no neighbour is higher."""
    padded = np.pad(a, 1, constant_values=-np.inf)
    rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(a >= np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))
