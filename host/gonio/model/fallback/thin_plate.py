"""thin_plate.py: holes of a grid spanned as a thin elastic plate would: what _model does (thin_plate.hpp)."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.ndimage import binary_dilation
from scipy.sparse.linalg import spsolve

FloatArray = NDArray[np.float64]

_MEMBRANE = 1e-3
_BEYOND = 0.25  # of the known values' range
_SOFT = 4  # nodes around a hole
_MEDIAN_OF_SQUARE = 0.4549364  # of a normal variable of variance 1
_LEAST_BENDING = 0.05  # of the second differences' variance is not noise
_STIFFEST = 1e-6  # of the bending's variance that a node is known to


def span_holes(nodes: FloatArray, known: NDArray[np.bool_], variance: FloatArray | None) -> FloatArray:
    """The nodes (s, s), those not known as the plate has them."""
    if np.all(known) or not np.any(known):
        return nodes
    size = len(nodes)
    one = sparse.identity(size, format="csr")
    first = one[1:] - one[:-1]
    second = first[1:, 1:] @ first
    bent = sparse.vstack((sparse.kron(one, second), sparse.kron(second, one)), format="csr")
    twist = sparse.kron(first, first)
    stretch = sparse.vstack((sparse.kron(one, first), sparse.kron(first, one)))
    energy = (bent.T @ bent + 2.0 * (twist.T @ twist) + _MEMBRANE * (stretch.T @ stretch)).tocsr()
    give = 0.0 if variance is None else _bending(bent, nodes.ravel(), known.ravel(), variance.ravel())
    moves = (binary_dilation(~known, np.ones((3, 3)), iterations=_SOFT) if give > 0.0 else ~known).ravel()
    right = -(energy[moves][:, ~moves] @ nodes.ravel()[~moves])
    left = energy[moves][:, moves]
    if variance is not None and give > 0.0:
        spring = np.where(known, give / np.maximum(variance, _STIFFEST * give), 0.0).ravel()[moves]
        left = left + sparse.diags(spring)
        right += spring * nodes.ravel()[moves]
    plate = nodes.ravel().copy()
    plate[moves] = spsolve(left.tocsc(), right)
    held = nodes[known]
    margin = _BEYOND * (held.max() - held.min())
    return np.where(known, nodes, np.clip(plate.reshape(size, size), held.min() - margin, held.max() + margin))


def _bending(bent: sparse.csr_matrix, nodes: FloatArray, known: NDArray[np.bool_], variance: FloatArray) -> float:
    """Variance of the second differences of the known nodes beyond what noise gives them."""
    within = (abs(bent) @ ~known) == 0
    if not np.any(within):
        return 0.0
    squares = np.sort((bent @ nodes)[within] ** 2)
    noises = np.sort((bent.power(2) @ variance)[within])
    middle = len(squares) // 2
    everything = squares[middle] / _MEDIAN_OF_SQUARE
    return float(max(everything - noises[middle], _LEAST_BENDING * everything))
