# _model: compiled evaluation and fits of models (host/native/model), and what gonio.model.fallback does like it.
import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Numbers = NDArray[np.int64]

def evaluate(
    slices: tuple[_Floats, _Numbers, _Numbers],
    lobes: tuple[_Floats, _Floats, _Floats, _Numbers],
    patches: tuple[_Numbers, _Floats],
    fields: tuple[_Numbers, _Floats, _Floats, _Floats, NDArray[np.bool_]],
    grids: tuple[NDArray[np.float32], _Numbers, _Numbers],
    unit: _Floats,
    which: _Numbers,
) -> _Floats:
    """DSF (m,) towards unit vectors (m, 3) in slices (m,), or all in the first where `which` is empty. The arrays in
    the order of slices.Slices: scale, lobe_start, field_start; lobe_frame, lobe_whitening, lobe_peak_per_sr,
    patch_start; patch_grid, patch_weight; field_grid, field_weight, field_matrix, field_shift, field_as_bsdf; and of
    slices.Grids: values, start, size. ValueError where sizes or indices do not agree."""

def fit_grid(
    position: _Floats, value: _Floats, variance: _Floats, weight: _Floats, half_width: float, size: int
) -> _Floats:
    """Nodes (size, size) of the grid through points (n, 2): see grid_fit.fit_grid."""

def grid_at(values: _Floats, half_width: float, position: _Floats) -> _Floats:
    """Bilinear value (n,) of nodes (s, s) at positions (n, 2), at the nearest rim where outside."""

def suitable_size(position: _Floats, half_width: float, most_cells: int) -> int:
    """Nodes per side, 2^p + 1, for points (n, 2): see grid_fit.suitable_size."""

def near_lobes(unit: _Floats, frame: _Floats, whitening: _Floats, reach: float) -> tuple[_Numbers, _Numbers, _Floats]:
    """Which of unit vectors (n, 3) lie within `reach` standard deviations along the longer axis of each lobe, of frames
    (l, 3, 3) and whitening (l, 2, 2) as slices.Slices has them: first item of each lobe (l + 1,), and over all lobes
    rows (m,), rising in each, and places v in whitened coordinates (m, 2)."""

def sorted_cells(
    unit: _Floats, value: _Floats, variance: _Floats, weight: _Floats, size: int, most: int
) -> tuple[_Numbers, _Numbers, _Numbers, _Floats, _Floats]:
    """Points (n, 3), (n,) of weights above zero sorted into the cells of a grid of size x size over Lambert's disc,
    [-1, 1]^2. Of the occupied cells: place row * size + column (c,), and the range of sorted points (c + 1,). Of the
    points that stay: their rows (m,), in a cell as they came, and weights (m,), which in each cell have the sum of all.
    Of the cells: sums (c, 6) of w, w v, w^2 variance and w times the unit vector over these. All stay, but of a cell
    with more than `most` every n-th, where the values differ by less than 0.8 of their mean, noise apart."""
