"""tracks.py: which lobes of different incident directions are the same lobe, and what it follows.

Between neighbours lobes are matched by linear assignment: distance in coordinates in which ideal directions stand
still, width and power. Matches make tracks; a track has at most one lobe per node. A lobe without partner fades.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from gonio.model.hemisphere import Follows, ideal
from gonio.model.nodes.frames import level_axes, tangents
from gonio.model.nodes.node import Node

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

FOLLOWS: tuple[Follows, ...] = ("opposite", "same", "fixed")
_UNMATCHED = 5.0  # cost of a lobe that stays alone: this many widths off, or e^(5/w) times wider or stronger
_SHARPNESS_RAD = np.radians(1.0)  # added to widths: so far a peak may stray between incident directions
_WIDTH_COST = 1.5  # per e-fold
_POWER_COST = 0.5


@dataclass(frozen=True)
class Lobes:
    """Lobes of a node or of its image, in the folded frame; arrays as in Node."""

    incident: FloatArray
    centre: FloatArray
    log_peak: FloatArray
    log_covariance: FloatArray
    offset: dict[Follows, FloatArray]  # (l, 2) from the ideal directions, in level axes there [rad]
    sigma_rad: FloatArray  # (l,) geometric mean
    power: FloatArray  # (l,)

    @staticmethod
    def of(node: Node, signs: FloatArray) -> "Lobes":
        """Of the image of a node under signs (2,) of x and y."""
        both = np.append(signs, 1.0)
        centre, incident = node.centre * both, node.incident * both
        return Lobes(
            incident,
            centre,
            node.log_peak,
            node.log_covariance * np.outer(signs, signs),
            {f: tangents(level_axes(ideal(f, incident)), centre).reshape(-1, 2) for f in FOLLOWS},
            np.exp(0.25 * np.trace(node.log_covariance, axis1=-2, axis2=-1)),
            node.power,
        )


@dataclass(frozen=True)
class Tracks:
    """lobe (nodes, tracks): index of the node's lobe that belongs to the track, -1: none; follows (tracks,)."""

    lobe: IndexArray
    follows: tuple[Follows, ...]


class Matches(Protocol):
    """Remembers matches of pairs of nodes: leaving one node out asks for most pairs again."""

    def __call__(self, first: int, second: int) -> list[tuple[float, int, int]]:
        """Cost and lobes of each matched pair."""
        ...


@dataclass
class Matcher:
    """Matches of pairs of these nodes, each computed once."""

    nodes: list[Lobes]
    _known: dict[tuple[int, int], list[tuple[float, int, int]]] = field(default_factory=dict)

    def __call__(self, first: int, second: int) -> list[tuple[float, int, int]]:
        """See Matches."""
        key = (first, second)
        if key not in self._known:
            self._known[key] = match(self.nodes[first], self.nodes[second])
        return self._known[key]


def match(a: Lobes, b: Lobes) -> list[tuple[float, int, int]]:
    """Cost and lobes (of a, of b) of each pair that belongs together."""
    n, m = len(a.log_peak), len(b.log_peak)
    if n == 0 or m == 0:
        return []
    width = np.sqrt(a.sigma_rad[:, None] ** 2 + b.sigma_rad**2 + _SHARPNESS_RAD**2)
    apart = np.min(
        [np.linalg.norm(a.offset[f][:, None] - b.offset[f][None], axis=2) for f in FOLLOWS],
        axis=0,
    )
    cost = apart / width
    cost += _WIDTH_COST * np.abs(np.log(a.sigma_rad[:, None] / b.sigma_rad))
    cost += _POWER_COST * np.abs(np.log(a.power[:, None] / b.power))
    # Every lobe may stay alone: a second row and column of its own.
    full = np.full((n + m, n + m), np.inf)
    full[:n, :m] = cost
    full[:n, m:] = np.where(np.eye(n, dtype=bool), _UNMATCHED / 2.0, 1e6)
    full[n:, :m] = np.where(np.eye(m, dtype=bool), _UNMATCHED / 2.0, 1e6)
    full[n:, m:] = 0.0
    pairs = zip(*linear_sum_assignment(full), strict=True)
    return [(float(cost[i, j]), int(i), int(j)) for i, j in pairs if i < n and j < m]


def track(nodes: list[Lobes], edges: IndexArray, matches: Matches) -> Tracks:
    """Tracks along edges (e, 2) between these nodes, the surest matches first."""
    start = np.concatenate(([0], np.cumsum([len(n.log_peak) for n in nodes]))).astype(np.int64)
    parent = list(range(int(start[-1])))
    members: list[dict[int, int]] = [{k: i} for k, n in enumerate(nodes) for i in range(len(n.log_peak))]

    def root(lobe: int) -> int:
        while parent[lobe] != lobe:
            parent[lobe] = parent[parent[lobe]]
            lobe = parent[lobe]
        return lobe

    found = [(cost, int(p), i, int(q), j) for p, q in edges for cost, i, j in matches(int(p), int(q))]
    for _, p, i, q, j in sorted(found):
        one, other = root(int(start[p]) + i), root(int(start[q]) + j)
        if one == other or members[one].keys() & members[other].keys():
            continue  # two lobes of one node are never the same
        parent[other] = one
        members[one] |= members[other]
    roots = [k for k in range(len(parent)) if root(k) == k]
    lobe = np.full((len(nodes), len(roots)), -1, dtype=np.int64)
    for column, k in enumerate(roots):
        for node, index in members[k].items():
            lobe[node, column] = index
    follows = tuple(_follows(nodes, members[k]) for k in roots)
    return Tracks(lobe, follows)


def _follows(nodes: list[Lobes], members: dict[int, int]) -> Follows:
    """The ideal direction from which the lobe's offset varies least; seen in one direction only: the nearest.

    A lobe at normal incidence, or one alone far from both, is at rest.
    """
    best: Follows = "fixed"
    least = np.inf
    for follows in FOLLOWS:
        offset = np.array([nodes[node].offset[follows][lobe] for node, lobe in members.items()])
        spread = np.sum((offset - offset.mean(axis=0)) ** 2, axis=1).mean()
        # Ties (one direction, or all at one theta) go to the ideal direction that the lobe lies at.
        score = float(spread + 1e-3 * np.mean(np.sum(offset**2, axis=1)))
        if score < least * (1.0 - 1e-9):
            best, least = follows, score
    return best
