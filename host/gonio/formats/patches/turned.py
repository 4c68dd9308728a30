"""turned.py: averages over incident and outgoing patches of an isotropic sample: only theta_i is sampled.

With g(phi) the azimuth profile of an outgoing ring for one theta_i, phi counted from the column's azimuth,
    B_oi L_o L_i = integral cos sin dtheta_i  integral g(phi) T(phi - (c_o - c_i)) dphi,
T(phi) the length of incident azimuths of the patch about c_i that put phi into the patch about c_o: a trapezoid. All
its corners lie on edges of BINS equal bins, so that the integral and the first moment of g in every bin give it
exactly.
"""

import math
from functools import cache

import numpy as np

from gonio.dataset.scattering import FloatArray, IndexArray
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.outgoing import Base, integrate
from gonio.formats.patches.rules import gauss, kronrod, moments_of_parts
from gonio.formats.window.klems import KlemsBasis

BINS = 480
_SECTOR = 32  # bins of a first cell; halved down to one bin and on
_RULE = 15
_MOST_HALVINGS = 6
_FULL = 2.0 * np.pi


def fits(basis: KlemsBasis) -> bool:
    """Whether all corners of the basis's trapezoids lie on the bins' edges."""
    return BINS % (2 * math.lcm(*(ring.patches for ring in basis.rings))) == 0


def matrix(component: Component, basis: KlemsBasis, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """B (outgoing, incident) and the estimated error of each column's sum."""
    rings = len(basis.rings)
    moments = np.zeros((rings, rings, BINS, 2))  # of each incident ring
    missed = np.zeros(rings)
    pending = [(ring, *np.radians([r.lower_deg, r.upper_deg])) for ring, r in enumerate(basis.rings)]
    for halving in range(_MOST_HALVINGS + 1):
        fine, coarse, inner = _spans(component, basis, pending, tolerance)
        again = []
        for (ring, low, high), own, rough, cells in zip(pending, fine, coarse, inner, strict=True):
            size = basis.rings[ring].projected_solid_angle_sr
            energy = _column(basis, ring, 0, own)
            apart = float(np.abs(energy - _column(basis, ring, 0, rough)).sum())
            whole = max(float((energy + _column(basis, ring, 0, moments[ring])).sum()), 1e-12 * size)
            left = kronrod(_RULE).error(apart, whole)
            if left > 0.5 * tolerance * whole and halving < _MOST_HALVINGS:
                middle = 0.5 * (low + high)
                again += [(ring, low, middle), (ring, middle, high)]
            else:
                moments[ring] += own
                missed[ring] += (left + cells) / size
        pending = again
        if not pending:
            break
    counts = [ring.patches for ring in basis.rings]
    return assembled(basis, moments), np.repeat(missed, counts)


def assembled(basis: KlemsBasis, moments: FloatArray) -> FloatArray:
    """B (outgoing, incident) from the moments (incident rings, outgoing rings, BINS, 2) of azimuth profiles, integrated
    over each incident ring with cos sin dtheta_i."""
    result = np.empty((basis.size, basis.size))
    for ring, start in enumerate(basis.ring_start[:-1]):
        for turn in range(basis.rings[ring].patches):
            size = basis.rings[ring].projected_solid_angle_sr
            result[:, start + turn] = _column(basis, ring, turn, moments[ring]) / size
    return result / basis.projected_solid_angle_sr[:, None]


def _spans(
    component: Component, basis: KlemsBasis, pending: list[tuple[int, float, float]], tolerance: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moments (spans, rings, bins, 2) of spans of theta_i (ring, from, to) by the fine and the coarse rule, and the
    error of the outgoing cells (spans,), times the incident patch's width."""
    pair = kronrod(_RULE)
    limits = np.array([(low, high) for _, low, high in pending])
    length = (limits[:, 1] - limits[:, 0])[:, None]
    theta = limits.mean(axis=1)[:, None] + 0.5 * length * pair.nodes
    measure = length * np.cos(theta) * np.sin(theta)
    incident = component.incident(theta.ravel(), np.zeros(theta.size))
    rings = len(basis.rings)
    moments = np.zeros((theta.size * rings * BINS, 2))
    errors = np.zeros(theta.size)
    for done in integrate(component, incident, _base(basis), 0.5 * tolerance):
        errors += np.bincount(done.cells.row, done.error, minlength=theta.size)
        place = (done.cells.row * rings + done.cells.base // (BINS // _SECTOR)) * BINS
        _deposit(moments, place, done.cells.polar, done.cells.azimuth, done.values)
    per_node = moments.reshape(*theta.shape, rings, BINS, 2)
    fine, coarse = (np.einsum("sn,sn...->s...", measure * weight, per_node) for weight in (pair.fine, pair.coarse))
    width = np.array([_FULL / basis.rings[ring].patches for ring, _, _ in pending])
    return fine, coarse, width * np.einsum("sn,sn->s", measure * pair.fine, errors.reshape(theta.shape))


def _base(basis: KlemsBasis) -> Base:
    sectors = BINS // _SECTOR
    edges = np.arange(sectors + 1) * (_FULL / sectors)
    polar = np.radians([(ring.lower_deg, ring.upper_deg) for ring in basis.rings])
    azimuth = np.stack((edges[:-1], edges[1:]), axis=1)
    return Base(np.repeat(polar, sectors, axis=0), np.tile(azimuth, (len(polar), 1)))


def _deposit(
    moments: FloatArray, place: IndexArray, polar: FloatArray, azimuth: FloatArray, values: FloatArray
) -> None:
    """Adds cells' integrals and first moments in azimuth to bins; `place` (n,) is the ring's first bin in moments."""
    nodes, weight = gauss()
    bin_rad = _FULL / BINS
    wide = azimuth[:, 1] - azimuth[:, 0]
    profile = (polar[:, 1] - polar[:, 0])[:, None] * np.einsum("nab,a->nb", values, weight)  # (n, azimuth nodes)
    bins = np.rint(wide / bin_rad).astype(np.int64)
    fraction = wide < 0.75 * bin_rad
    for parts in np.unique(bins[~fraction]):
        mine = ~fraction & (bins == parts)
        first = place[mine] + np.rint(azimuth[mine, 0] / bin_rad).astype(np.int64)
        half = 0.5 * wide[mine]
        # moments_of_parts is on [-1, 1]: lengths take half the width once, moments twice.
        added = np.einsum("nb,bpm->npm", profile[mine], moments_of_parts(int(parts)))
        added *= np.stack((half, half**2), axis=1)[:, None, :]
        target = (first[:, None] + np.arange(parts)).ravel()
        for m in range(2):
            moments[:, m] += np.bincount(target, added[:, :, m].ravel(), minlength=len(moments))
    if fraction.any():
        centre = azimuth[fraction].mean(axis=1)
        number = np.floor(centre / bin_rad).astype(np.int64)
        offset = (centre - (number + 0.5) * bin_rad)[:, None] + 0.5 * wide[fraction][:, None] * nodes
        share = profile[fraction] * weight * wide[fraction][:, None]
        target = place[fraction] + number
        moments[:, 0] += np.bincount(target, share.sum(axis=1), minlength=len(moments))
        moments[:, 1] += np.bincount(target, (share * offset).sum(axis=1), minlength=len(moments))


def _column(basis: KlemsBasis, ring: int, turn: int, moments: FloatArray) -> FloatArray:
    """Energies L_o L_i B (patches,) of a ring's column number `turn` from moments (rings, bins, 2)."""
    incident = basis.rings[ring].patches
    parts = []
    for own, outgoing in zip(moments, basis.rings, strict=True):
        weights = _trapezoid(_FULL / incident, _FULL / outgoing.patches)
        between = BINS // outgoing.patches * np.arange(outgoing.patches) - BINS // incident * turn
        place = (np.arange(BINS) - between[:, None]) % BINS
        parts.append(weights[place, 0] @ own[:, 0] + weights[place, 1] @ own[:, 1])
    return np.concatenate(parts)


@cache
def _trapezoid(width_a: float, width_b: float) -> FloatArray:
    """T at the middle of every bin and its slope there (bins, 2), about azimuth 0, wound round the circle."""
    bin_rad = _FULL / BINS
    middle = (np.arange(BINS) + 0.5) * bin_rad
    top, foot = abs(width_a - width_b) / 2.0, (width_a + width_b) / 2.0
    result = np.zeros((BINS, 2))
    for turn in (-2.0, -1.0, 0.0, 1.0):
        phi = middle + turn * _FULL
        result[:, 0] += np.clip(foot - np.abs(phi), 0.0, foot - top)
        result[:, 1] += np.where((np.abs(phi) > top) & (np.abs(phi) < foot), -np.sign(phi), 0.0)
    return result
