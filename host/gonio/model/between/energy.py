"""energy.py: hemispherical integrals of resolved models, and the two scales that keep them right.

Node scale: the model's sum over a node's points, with their solid angles, equals the sum of the measured DSF there.
Bound: an incident direction's integral is not above the largest of the nodes that it is made of.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.between.resolve import Resolver
from gonio.model.evaluate import evaluate
from gonio.model.nodes.frames import along_tangents
from gonio.model.nodes.node import Node
from gonio.model.nodes.points import Points
from gonio.model.slices import Grids, Slices

FloatArray = NDArray[np.float64]

LARGEST_CORRECTION = 0.02  # a node's scale stays within; what it would have needed is recorded
BOUND_SLACK = 1e-3  # of the integral: what the quadrature below may be wrong by
_LEAST_RINGS, _MOST_RINGS = 24, 64  # of the hemisphere, as many as backgrounds have nodes across; twice as many sectors
_LOBE_RINGS, _LOBE_SECTORS = 16, 32
_LOBE_REACH = 5.0  # standard deviations: 4e-6 of a lobe is left out
_TABLE_STEP_DEG = 0.5


def integrals(slices: Slices, grids: Grids) -> FloatArray:
    """Integral of the DSF over the hemisphere (k,), lobes with what is beside them apart from backgrounds: each by
    Gauss's rule along the radius and equal steps around."""
    number = len(slices.scale)
    rings = int(np.clip(np.max(grids.size[slices.field_grid], initial=0), _LEAST_RINGS, _MOST_RINGS))
    sectors = 2 * rings
    z, weight = np.polynomial.legendre.leggauss(rings)
    z, weight = 0.5 * (z + 1.0), 0.5 * weight * 2.0 * np.pi / sectors
    phi = (np.arange(sectors) + 0.5) * (2.0 * np.pi / sectors)
    across = np.sqrt(1.0 - z * z)
    unit = np.stack(
        [np.outer(across, np.cos(phi)).ravel(), np.outer(across, np.sin(phi)).ravel(), np.repeat(z, sectors)], axis=1
    )
    ground = _without_lobes(slices)
    which = np.repeat(np.arange(number), len(unit))
    value = evaluate(ground, grids, np.tile(unit, (number, 1)), which).reshape(number, -1)
    total = value @ np.repeat(weight, sectors)
    total += _lobe_integrals(slices, grids, number)
    return np.asarray(total * slices.scale)


def _without_lobes(slices: Slices) -> Slices:
    return replace(
        slices,
        scale=np.ones(len(slices.scale)),
        lobe_start=np.zeros_like(slices.lobe_start),
        lobe_frame=np.zeros((0, 3, 3)),
        lobe_whitening=np.zeros((0, 2, 2)),
        lobe_peak_per_sr=np.zeros(0),
        patch_start=np.zeros(1, dtype=np.int64),
        patch_grid=np.zeros(0, dtype=np.int64),
        patch_weight=np.zeros(0),
    )


def _only_lobes(slices: Slices) -> Slices:
    """Each lobe a slice of its own."""
    lobes = len(slices.lobe_peak_per_sr)
    return replace(
        slices,
        scale=np.ones(lobes),
        lobe_start=np.arange(lobes + 1, dtype=np.int64),
        field_start=np.zeros(lobes + 1, dtype=np.int64),
        field_grid=np.zeros(0, dtype=np.int64),
        field_weight=np.zeros(0),
        field_matrix=np.zeros((0, 2, 2)),
        field_shift=np.zeros((0, 2)),
        field_as_bsdf=np.zeros(0, dtype=bool),
    )


def _lobe_integrals(slices: Slices, grids: Grids, number: int) -> FloatArray:
    """Of the lobes of each slice (k,), on rings about them; none below the horizon."""
    lobes = len(slices.lobe_peak_per_sr)
    if lobes == 0:
        return np.zeros(number)
    apart = _only_lobes(slices)
    root, weight = np.polynomial.legendre.leggauss(_LOBE_RINGS)
    radius, weight = 0.5 * (root + 1.0) * _LOBE_REACH, 0.5 * weight * _LOBE_REACH
    phi = (np.arange(_LOBE_SECTORS) + 0.5) * (2.0 * np.pi / _LOBE_SECTORS)
    v = np.stack((np.outer(radius, np.cos(phi)).ravel(), np.outer(radius, np.sin(phi)).ravel()), axis=1)
    area = np.repeat(weight * radius, _LOBE_SECTORS) * (2.0 * np.pi / _LOBE_SECTORS)
    colour = np.linalg.inv(slices.lobe_whitening)
    tangent = np.einsum("lij,nj->lni", colour, v)
    angle = np.linalg.norm(tangent, axis=2)
    sphere = np.sinc(np.minimum(angle, np.pi) / np.pi)  # sin(a) / a: the sphere's area over the plane's
    unit = along_tangents(slices.lobe_frame[:, None], tangent)
    which = np.repeat(np.arange(lobes), len(v))
    value = evaluate(apart, grids, unit.reshape(-1, 3), which).reshape(lobes, -1)
    value *= (unit[..., 2] > 0.0) & (angle < np.pi)
    each = np.abs(np.linalg.det(colour)) * ((value * sphere) @ area)
    row = np.repeat(np.arange(number), np.diff(slices.lobe_start))
    return np.asarray(np.bincount(row, each, number), dtype=np.float64)


def node_scale(resolver: Resolver, number: int, points: Points) -> tuple[float, float]:
    """Scale of node `number` (within LARGEST_CORRECTION of 1), and what it would have to be."""
    node = resolver.nodes[number]
    slices = resolver.slices(node.incident[None], scaled=False)
    model = float(np.einsum("n,n->", evaluate(slices, resolver.grids, points.unit), points.solid_angle_sr))
    wanted = points.integral / model if model > 0.0 else 1.0
    return float(np.clip(wanted, 1.0 - LARGEST_CORRECTION, 1.0 + LARGEST_CORRECTION)), float(wanted)


@dataclass(frozen=True)
class Bound:
    """What the bound makes of a resolved direction: for isotropic samples a table along theta, else each is integrated.

    table (t,): factors at 0, ... 90 degrees in steps of table_step; node_integral (e,): of the images.
    """

    node_integral: FloatArray
    table: FloatArray | None

    @staticmethod
    def of(resolver: Resolver) -> "Bound":
        """From the nodes' integrals."""
        incident = np.array([node.incident for node in resolver.nodes]).reshape(-1, 3)
        own = integrals(resolver.slices(incident), resolver.grids)
        bound = Bound(own[resolver.source], None)
        if not resolver.images.isotropic:
            return bound
        theta = np.radians(np.arange(0.0, 90.0 + _TABLE_STEP_DEG / 2, _TABLE_STEP_DEG))
        ways = np.stack((np.sin(theta), np.zeros_like(theta), np.cos(theta)), axis=1)
        return Bound(bound.node_integral, bound._factors(resolver, ways, resolver.slices(ways)))

    def applied(self, resolver: Resolver, incident: FloatArray, slices: Slices) -> Slices:
        """Slices of folded incident directions (k, 3) with the bound in their scale."""
        if self.table is None:
            return replace(slices, scale=slices.scale * self._factors(resolver, incident, slices))
        theta_deg = np.degrees(np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), incident[:, 2]))
        factor = np.interp(theta_deg, np.arange(len(self.table)) * _TABLE_STEP_DEG, self.table)
        return replace(slices, scale=slices.scale * factor)

    def _factors(self, resolver: Resolver, incident: FloatArray, slices: Slices) -> FloatArray:
        stencil = resolver.locate(incident)
        most = np.max(np.where(stencil.weight > 1e-9, self.node_integral[stencil.node], 0.0), axis=1)
        found = integrals(slices, resolver.grids)
        return np.asarray(np.minimum(1.0, (1.0 + BOUND_SLACK) * most / np.maximum(found, 1e-300)))


def with_node_scales(resolver: Resolver, points: list[Points]) -> tuple[list[Node], list[float]]:
    """Nodes with their scale, and the scales that would have been needed."""
    found = [node_scale(resolver, number, p) for number, p in enumerate(points)]
    return [n.with_scale(s) for n, (s, _) in zip(resolver.nodes, found, strict=True)], [wanted for _, wanted in found]
