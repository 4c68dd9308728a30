"""ceilings.py: what a dense exact tensor tree of resolution k answers: the best that any tree file of that k can do.

No file is made: only the cells that are asked for are averaged. Written apart from gonio.formats.tensor, from the
layout that shared CONVENTIONS and Radiance's reader agree on: Shirley-Chiu's square of the direction cosines; incident
pair negated; isotropic samples with the first coordinate 1/2 - sin(theta_i)/2 and -incident turned onto +x.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from gonio.dataset.scattering import FloatArray, Scattering

_QUARTER = np.pi / 4.0


def square_from_disc(disc: FloatArray) -> FloatArray:
    """Shirley-Chiu: points of the unit disc (m, 2) to [0, 1]^2 (m, 2), areas in proportion."""
    radius = np.hypot(disc[:, 0], disc[:, 1])
    phi = np.arctan2(disc[:, 1], disc[:, 0])
    phi = np.where(phi < -_QUARTER, phi + 2.0 * np.pi, phi)
    sector = np.minimum(((phi + _QUARTER) / (2.0 * _QUARTER)).astype(int), 3)
    aside = (phi - sector * 2.0 * _QUARTER) / _QUARTER * radius
    a = np.choose(sector, [radius, -aside, -radius, aside])
    b = np.choose(sector, [aside, radius, -aside, -radius])
    return np.column_stack((a + 1.0, b + 1.0)) / 2.0


def disc_from_square(square: FloatArray) -> FloatArray:
    """Inverse of `square_from_disc`."""
    a, b = (2.0 * square - 1.0).T
    along = np.abs(a) > np.abs(b)
    radius = np.where(along, a, b)
    part = np.where(along, b, a) / np.where(radius == 0.0, 1.0, radius)
    phi = np.where(along, _QUARTER * part, 2.0 * _QUARTER - _QUARTER * part)
    return np.column_stack((radius * np.cos(phi), radius * np.sin(phi)))


@dataclass(frozen=True)
class DenseTree:
    """The exact tree of `sample` with 2^k cells along each axis; `order`: Gauss-Legendre nodes along a cell's edge."""

    sample: Scattering
    k: int
    isotropic: bool = True
    order: int = 8

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        """DSF [1/sr] (m,) that a reader of the tree finds for one incident unit vector (3,) and outgoing (m, 3)."""
        nodes, weights = leggauss(self.order)
        nodes, weights = (nodes + 1.0) / 2.0, weights / 2.0
        step = 2.0**-self.k
        turn = self._turn(incident)
        square = square_from_disc(outgoing[:, :2] @ turn.T)
        cell = np.minimum((square / step).astype(np.int64), 2**self.k - 1)
        unique, back = np.unique(cell, axis=0, return_inverse=True)
        around = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)
        inner = disc_from_square(((unique[:, None, :] + around) * step).reshape(-1, 2)) @ turn
        leaving = _on_sphere(inner, np.sign(outgoing[0, 2]))
        weight_out = (weights[:, None] * weights).ravel()
        mean = np.zeros(len(unique))
        for weight, inside in zip(*self._incident_nodes(incident, nodes, weights, step), strict=True):
            dsf = self.sample.dsf_per_sr(inside[None, :], leaving)
            bsdf = dsf / np.maximum(np.abs(leaving[:, 2]), 1e-9)
            mean += weight * (bsdf.reshape(len(unique), -1) @ weight_out)
        return np.asarray(mean[back.ravel()] * np.abs(outgoing[:, 2]))

    def _turn(self, incident: FloatArray) -> FloatArray:
        """(2, 2) that turns (x, y) into the tree's frame."""
        if not self.isotropic:
            return np.eye(2)
        across = np.hypot(*incident[:2])
        c, s = (-1.0, 0.0) if across == 0.0 else -incident[:2] / across
        return np.array([[c, s], [-s, c]])

    def _incident_nodes(
        self, incident: FloatArray, nodes: FloatArray, weights: FloatArray, step: float
    ) -> tuple[NDArray[np.float64], FloatArray]:
        """Weights (q,) and unit vectors (q, 3) over the incident cell."""
        sign = np.sign(incident[2])
        if self.isotropic:
            at = int((0.5 - 0.5 * np.hypot(*incident[:2])) / step)
            sine = 1.0 - 2.0 * (at + nodes) * step
            across = np.hypot(*incident[:2])
            way = np.array([1.0, 0.0]) if across == 0.0 else incident[:2] / across
            # By projected solid angle, as light from all around arrives: sin d(sin) of a ring.
            return weights * sine / np.sum(weights * sine), _on_sphere(sine[:, None] * way, sign)
        cell = np.minimum((square_from_disc(-incident[None, :2])[0] / step).astype(np.int64), 2**self.k - 1)
        around = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)
        return (weights[:, None] * weights).ravel(), _on_sphere(-disc_from_square((cell + around) * step), sign)


def _on_sphere(disc: FloatArray, sign: float) -> FloatArray:
    z = np.sqrt(np.maximum(1.0 - np.sum(disc**2, axis=-1), 0.0))
    return np.column_stack((disc, sign * z))
