"""rules.py: one-dimensional rules of the cubature: Gauss-Legendre with Legendre modes, Gauss-Kronrod pairs."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NODES = 4  # of a cell of outgoing directions, per axis

# Gauss-Kronrod pairs by Kronrod's count: nodes from the outermost to 0, their weights, and those of the Gauss rule that
# every second node belongs to (Kronrod 1965; Piessens et al., QUADPACK, 1983).
_KRONROD = {
    7: (
        (0.960491268708020283, 0.774596669241483377, 0.434243749346802558, 0.0),
        (0.104656226026467265, 0.268488089868333441, 0.401397414775962223, 0.450916538658474142),
        (0.555555555555555556, 0.888888888888888889),
    ),
    15: (
        (
            0.991455371120812639,
            0.949107912342758525,
            0.864864423359769073,
            0.741531185599394440,
            0.586087235467691130,
            0.405845151377397167,
            0.207784955007898468,
            0.0,
        ),
        (
            0.022935322010529225,
            0.063092092629978553,
            0.104790010322250184,
            0.140653259715525919,
            0.169004726639267903,
            0.190350578064785410,
            0.204432940075298892,
            0.209482141084727828,
        ),
        (0.129484966168869693, 0.279705391489276668, 0.381830050505118945, 0.417959183673469388),
    ),
}


@dataclass(frozen=True)
class Pair:
    """A rule and a coarser one on some of its nodes, on [-1, 1]; weights sum to 1. Arrays (n,)."""

    nodes: FloatArray
    fine: FloatArray
    coarse: FloatArray
    power: float  # the fine rule's error is about this power of the coarse one's: the ratio of their orders

    def error(self, apart: float, whole: float) -> float:
        """Estimated error of the fine rule, from the L1 distance between both and the sum that it is held against."""
        return whole * min(float((apart / whole) ** self.power), 1.0)


@cache
def kronrod(count: int) -> Pair:
    """The Gauss-Kronrod pair of 7 or 15 nodes."""
    half, fine, coarse = (np.array(part) for part in _KRONROD[count])
    of_gauss = np.zeros(len(half))
    of_gauss[1::2] = coarse
    gauss_points = count // 2
    power = (3 * gauss_points + 2 + gauss_points % 2 - 1) / (2 * gauss_points)  # degree + 1 of both
    return Pair(np.concatenate((-half, half[-2::-1])), _mirrored(fine) / 2.0, _mirrored(of_gauss) / 2.0, power)


def _mirrored(weights: FloatArray) -> FloatArray:
    return np.concatenate((weights, weights[-2::-1]))


@cache
def gauss(count: int = NODES) -> tuple[FloatArray, FloatArray]:
    """Nodes on [-1, 1] and weights with sum 1, (n,) each."""
    nodes, weights = legendre.leggauss(count)
    return nodes, weights / 2.0


@cache
def last_modes(count: int = NODES) -> FloatArray:
    """Weights (2, n) on values at Gauss nodes that give the coefficients of the two highest Legendre polynomials."""
    nodes, weights = gauss(count)
    return np.stack([(2 * k + 1) * weights * legendre.legval(nodes, np.eye(count)[k]) for k in (count - 2, count - 1)])


@cache
def moments_of_parts(parts: int, count: int = NODES) -> FloatArray:
    """Weights (n, parts, 2) on values at Gauss nodes that integrate the polynomial through them over equal parts of
    [-1, 1]: its integral, and its integral times the distance from the part's centre. Exact for the polynomial."""
    nodes, weights = gauss(count)
    degree = np.arange(count)
    modes = (2 * degree + 1)[:, None] * weights * np.stack([legendre.legval(nodes, np.eye(count)[k]) for k in degree])
    inner, inner_weights = gauss(count)
    half = 1.0 / parts
    centre = -1.0 + half * (2 * np.arange(parts) + 1)
    place = centre[:, None] + half * inner
    polynomial = np.stack([legendre.legval(place, np.eye(count)[k]) for k in degree])  # (degree, parts, inner)
    share = 2.0 * half * inner_weights
    first = np.einsum("kpi,i->kp", polynomial, share)
    second = np.einsum("kpi,i->kp", polynomial, share * half * inner)
    return np.asarray(np.einsum("kn,kpm->npm", modes, np.stack((first, second), axis=-1)))
