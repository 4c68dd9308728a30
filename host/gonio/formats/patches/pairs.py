"""pairs.py: averages over incident and outgoing patches of a sample without rotational symmetry: both axes of the
incident patch are sampled."""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.klems import KlemsBasis
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.outgoing import Base, integrate
from gonio.formats.patches.rules import gauss, kronrod

_MOST_ROUNDS = 5
_ROWS_AT_ONCE = 1500
_POLE_SECTORS = 6  # that a patch all round is divided in
_WIDE_SIGMA = 6.0  # a box of an incident patch wider than this, in a peak's sigma, starts with the longer rule
_TOO_WIDE_SIGMA = 14.0  # and one wider than this is divided first


@dataclass(frozen=True)
class _Box:
    """Part of an incident patch, limits [rad]."""

    column: int
    polar: tuple[float, float]
    azimuth: tuple[float, float]
    nodes: tuple[int, int] = (7, 7)


def matrix(
    component: Component, basis: KlemsBasis, tolerance: float, columns: IndexArray
) -> tuple[FloatArray, FloatArray]:
    """B (outgoing, incident) and the estimated error of each column's sum; only `columns` are computed."""
    base, patch = _base(basis)
    energy = np.zeros((basis.size, basis.size))
    missed = np.zeros(basis.size)
    pending = [box for column in columns.tolist() for box in _first_boxes(component, basis, column)]
    for round_ in range(_MOST_ROUNDS + 1):
        again: list[_Box] = []
        for group in _groups(pending):
            sums, inner = _boxes(component, group, base, patch, basis.size, tolerance)
            for box, (fine, rough_polar, rough_azimuth), cells in zip(group, sums, inner, strict=True):
                whole = max(float((energy[:, box.column] + fine).sum()), 1e-12)
                left = [
                    kronrod(nodes).error(float(np.abs(fine - rough).sum()), whole)
                    for nodes, rough in zip(box.nodes, (rough_polar, rough_azimuth), strict=True)
                ]
                bad = [own > 0.25 * tolerance * whole for own in left]
                if any(bad) and round_ < _MOST_ROUNDS:
                    again += _finer(box, bad)
                else:
                    energy[:, box.column] += fine
                    missed[box.column] += sum(left) + cells
        pending = again
        if not pending:
            break
    size = basis.projected_solid_angle_sr
    return energy / size[:, None] / size, missed / size


def _first_boxes(component: Component, basis: KlemsBasis, column: int) -> list[_Box]:
    """The patch, divided and with longer rules where a narrow peak of its centre's distribution will cross borders."""
    low, high, start, width = np.radians(basis.bounds_deg[column]).tolist()
    centre = component.incident(np.array([0.5 * (low + high)]), np.array([start + 0.5 * width]))
    sigma = component.peaks(centre)[1].min(initial=np.inf)
    sectors = _POLE_SECTORS if width > 6.0 else 1
    boxes = [
        _Box(column, (low, high), (start + width * k / sectors, start + width * (k + 1) / sectors))
        for k in range(sectors)
    ]
    while True:
        extents = [(b.polar[1] - b.polar[0], (b.azimuth[1] - b.azimuth[0]) * np.sin(b.polar[1])) for b in boxes]
        wide = [[own > _TOO_WIDE_SIGMA * sigma for own in extent] for extent in extents]
        if not any(any(own) for own in wide):
            break
        boxes = [
            part for box, own in zip(boxes, wide, strict=True) for part in (_halves(box, own) if any(own) else [box])
        ]
    return [
        _Box(b.column, b.polar, b.azimuth, tuple(15 if own > _WIDE_SIGMA * sigma else 7 for own in extent))  # type: ignore[arg-type]
        for b, extent in zip(boxes, extents, strict=True)
    ]


def _halves(box: _Box, axes: list[bool]) -> list[_Box]:
    boxes = [box]
    for axis, name in enumerate(("polar", "azimuth")):
        if not axes[axis]:
            continue
        parts = []
        for own in boxes:
            low, high = getattr(own, name)
            middle = 0.5 * (low + high)
            for span in ((low, middle), (middle, high)):
                limits = {"polar": own.polar, "azimuth": own.azimuth, name: span}
                parts.append(_Box(own.column, limits["polar"], limits["azimuth"], own.nodes))
        boxes = parts
    return boxes


def _finer(box: _Box, bad: list[bool]) -> list[_Box]:
    """The longer rule along the axes that need it; halves where that was taken already."""
    longer = tuple(15 if own else n for own, n in zip(bad, box.nodes, strict=True))
    halve = [own and n == 15 for own, n in zip(bad, box.nodes, strict=True)]
    return [_Box(b.column, b.polar, b.azimuth, longer) for b in _halves(box, halve)]  # type: ignore[arg-type]


def _groups(boxes: list[_Box]) -> list[list[_Box]]:
    """Boxes with at most _ROWS_AT_ONCE incident directions together, or a single box."""
    groups: list[list[_Box]] = []
    rows = 0
    for box in boxes:
        own = box.nodes[0] * box.nodes[1]
        if not groups or rows + own > _ROWS_AT_ONCE:
            groups.append([])
            rows = 0
        groups[-1].append(box)
        rows += own
    return groups


def _boxes(
    component: Component, boxes: list[_Box], base: Base, patch: IndexArray, size: int, tolerance: float
) -> tuple[list[tuple[FloatArray, FloatArray, FloatArray]], list[float]]:
    """Energies (patches,) of each box: by the fine rule, by the coarse one in polar angle, by that in azimuth; and the
    error of the outgoing cells."""
    polar, azimuth, weights = [], [], []
    for box in boxes:
        pair_p, pair_a = kronrod(box.nodes[0]), kronrod(box.nodes[1])
        theta = 0.5 * sum(box.polar) + 0.5 * (box.polar[1] - box.polar[0]) * pair_p.nodes
        phi = 0.5 * sum(box.azimuth) + 0.5 * (box.azimuth[1] - box.azimuth[0]) * pair_a.nodes
        area = (box.polar[1] - box.polar[0]) * (box.azimuth[1] - box.azimuth[0])
        measure: FloatArray = area * np.cos(theta) * np.sin(theta)
        polar.append(np.repeat(theta, len(phi)))
        azimuth.append(np.tile(phi, len(theta)))
        rules = [(pair_p.fine, pair_a.fine), (pair_p.coarse, pair_a.fine), (pair_p.fine, pair_a.coarse)]
        weights.append(np.stack([np.outer(measure * p, a).ravel() for p, a in rules]))
    incident = component.incident(np.concatenate(polar), np.concatenate(azimuth))
    rows = np.zeros((len(incident), size))
    errors = np.zeros(len(incident))
    _, weight = gauss()
    for done in integrate(component, incident, base, tolerance):
        cells = done.cells
        wide = (cells.polar[:, 1] - cells.polar[:, 0]) * (cells.azimuth[:, 1] - cells.azimuth[:, 0])
        integral = wide * np.einsum("nab,a,b->n", done.values, weight, weight)
        rows += np.bincount(cells.row * size + patch[cells.base], integral, minlength=rows.size).reshape(rows.shape)
        errors += np.bincount(cells.row, done.error, minlength=len(errors))
    ends = np.cumsum([own.shape[1] for own in weights])
    sums, inner = [], []
    for own, end in zip(weights, ends, strict=True):
        part = slice(end - own.shape[1], end)
        fine, rough_polar, rough_azimuth = own @ rows[part]
        sums.append((fine, rough_polar, rough_azimuth))
        inner.append(float(own[0] @ errors[part]))
    return sums, inner


def _base(basis: KlemsBasis) -> tuple[Base, IndexArray]:
    """First cells, and the patch that each belongs to."""
    polar, azimuth, patch = [], [], []
    for number, (low, high, start, width) in enumerate(np.radians(basis.bounds_deg).tolist()):
        sectors = _POLE_SECTORS if width > 6.0 else 1
        for k in range(sectors):
            polar.append((low, high))
            azimuth.append((start + width * k / sectors, start + width * (k + 1) / sectors))
            patch.append(number)
    return Base(np.array(polar), np.array(azimuth)), np.array(patch, dtype=np.int64)
