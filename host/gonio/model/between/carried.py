"""carried.py: lobes at an incident direction that its points cannot show, carried over from its neighbours.

A lobe whose top lies where nothing was measured, such as the mirror lobe behind the detector's head at normal
incidence, is unknown there, not absent: without it everything about that direction would fade towards a hole.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.between.resolve import Resolver
from gonio.model.hemisphere import disc_from_unit, tangent_axes
from gonio.model.lobe import Lobe
from gonio.model.nodes.coverage import BETWEEN, SIZE, WITHIN
from gonio.model.nodes.node import Ground, Node, build_node
from gonio.model.nodes.points import Points

FloatArray = NDArray[np.float64]

_TOP_SEEN = 0.8  # of the peak: where a point sees so much the lobe would have been found
_FLANK = 0.05  # of the peak: points that see more tell whether the lobe may be there
_AGREES = 0.5  # of the light that the lobes would give there; less contradicts them
_PRESENT = 0.99  # weight of the neighbours that have the lobe
_SAME_SIGMAS = 2.0  # as near as this an own lobe is the one that was expected
_LEAST_COSINE = 0.02  # a lobe below the horizon stays there


def hidden_lobes(resolver: Resolver, number: int, points: Points) -> tuple[Lobe, ...]:
    """Lobes that the neighbours of node `number` lead to expect there, that its points do not show and, as far as they
    see flanks, do not contradict."""
    other, node = resolver.without(number), resolver.nodes[number]
    if len(other.kept) == 0:
        return ()
    missing = [g for g in _expected(other, node.incident) if g.centre[2] > _LEAST_COSINE and not _has(node, g)]
    heights = [(lobe, lobe.dsf_per_sr(points.unit) / lobe.peak_per_sr) for lobe in missing]
    hidden = [(lobe, height) for lobe, height in heights if float(height.max(initial=0.0)) < _TOP_SEEN]
    if not hidden:
        return ()
    near = np.any([height > _FLANK for _, height in hidden], axis=0)
    seen = float(points.dsf_per_sr[near] @ points.solid_angle_sr[near])
    given = sum(float(lobe.peak_per_sr * (h[near] @ points.solid_angle_sr[near])) for lobe, h in hidden)
    return tuple(lobe for lobe, _ in hidden) if seen >= _AGREES * given else ()


def _expected(other: Resolver, incident: FloatArray) -> list[Lobe]:
    """Of the tracks that all neighbours have."""
    stencil = other.locate(incident[None])
    present = np.where(other.tracks.lobe[stencil.node[0]] >= 0, stencil.weight[0][:, None], 0.0).sum(axis=0)
    slices = other.slices(incident[None], scaled=False)
    found = []
    for row, share in enumerate(present[present > 1e-9]):
        if share < _PRESENT:
            continue
        frame, root = slices.lobe_frame[row], np.linalg.inv(slices.lobe_whitening[row])
        turn = tangent_axes(frame[2])[:2] @ frame[:2].T @ root
        found.append(Lobe(frame[2].copy(), turn @ turn.T, float(slices.lobe_peak_per_sr[row])))
    return found


def _has(node: Node, lobe: Lobe) -> bool:
    """Whether one of the node's own lobes is the expected one."""
    away = np.arccos(np.clip(node.centre @ lobe.centre, -1.0, 1.0))
    return bool(np.any(away < _SAME_SIGMAS * float(lobe.sigma_rad[1])))


def completed(
    resolver: Resolver, points: list[Points], own: Sequence[tuple[Lobe, ...]], grounds: list[Ground]
) -> tuple[Resolver, list[tuple[Lobe, ...]]]:
    """The resolver with nodes built anew around their own lobes and those carried over; and these, of each node.

    Only nodes that the resolver connects are looked at (Resolver.without). All directions learn from what was found
    in their neighbours, none from what was carried over to them.
    """
    connected = set(resolver.source[resolver.kept].tolist())
    extra = [hidden_lobes(resolver, k, p) if k in connected else () for k, p in enumerate(points)]
    if not any(extra):
        return resolver, extra
    nodes = list(resolver.nodes)
    for number, lobes in enumerate(extra):
        if lobes:
            built = build_node(points[number], (*own[number], *lobes), grounds[number])
            nodes[number] = replace(built, coverage=_with_gaps(built.coverage, points[number], lobes))
    whole = Resolver(nodes, resolver.images, resolver.scheme)
    for number in set(range(len(points))) - connected:
        whole = whole.without(number)
    return whole, extra


def _with_gaps(coverage: NDArray[np.uint8], points: Points, lobes: tuple[Lobe, ...]) -> NDArray[np.uint8]:
    """Cells about the lobes' centres, as far as there is no point, as BETWEEN points: nothing was measured there."""
    middle = (np.arange(SIZE) + 0.5) * (2.0 / SIZE) - 1.0
    cells = np.stack(np.meshgrid(middle, middle), axis=-1)
    result = coverage.copy()
    for lobe in lobes:
        # a distance on the disc is that on the sphere or, along the other axis, up to sqrt 2 of it
        gap = float(np.arccos(np.clip(np.max(points.unit @ lobe.centre), -1.0, 1.0)))
        away = np.linalg.norm(cells - disc_from_unit(lobe.centre), axis=-1)
        hole = away <= max(gap / np.sqrt(2.0), float(away.min()))
        result[hole & (result == WITHIN)] = BETWEEN
    return result
