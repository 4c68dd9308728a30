"""least_squares.py: overlapping lobes and the smooth ground under them, fitted together (Levenberg-Marquardt)."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.hemisphere import disc_from_unit
from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.scene import Nodes

FloatArray = NDArray[np.float64]

CONVERGED = 1e-4  # relative gain of a step
SHARE = 0.02  # of the level: what a point is trusted to beside its noise, as the lobes' shape is a model


@dataclass(frozen=True)
class Bounds:
    """Of one lobe: it stays within `leash` [rad] of `home`, its standard deviations within `least` and `most` [rad]
    and its peak below `highest` [1/sr], so that one cut by a shaded zone or the horizon cannot run away."""

    home: FloatArray
    leash: float
    least: float
    most: float
    highest: float

    def keep(self, lobe: Gauss) -> Gauss:
        """The lobe, moved to the nearest that is allowed."""
        if lobe.log_peak > np.log(self.highest):
            lobe = replace(lobe, log_peak=float(np.log(self.highest)))
        values, axes = np.linalg.eigh(lobe.covariance)
        allowed = np.clip(values, self.least**2, self.most**2)
        if not np.array_equal(values, allowed):
            lobe = lobe.with_covariance((axes * allowed) @ axes.T)
        centre = lobe.centre
        if centre[2] < 0.0:
            centre = np.array([centre[0], centre[1], 0.0]) / np.hypot(centre[0], centre[1])
        away = float(np.arccos(np.clip(centre @ self.home, -1.0, 1.0)))
        if away > self.leash:
            aside = centre - (centre @ self.home) * self.home
            centre = np.cos(self.leash) * self.home + np.sin(self.leash) * aside / np.linalg.norm(aside)
        return lobe if centre is lobe.centre else lobe.moved_to(centre)


@dataclass(frozen=True)
class Fit:
    """lobes; what is left (m,) at the nodes; the weights (m,) used; coefficients (q,) of the ground."""

    lobes: tuple[Gauss, ...]
    left: FloatArray
    weight: FloatArray
    ground: FloatArray


def ground_terms(unit: FloatArray, *, order: int) -> FloatArray:
    """Polynomials (q, m) on Lambert's disc up to `order`, centred and scaled to the nodes. With order 2 a cosine and
    a constant are among them: cos theta = 1 - r^2 on this disc."""
    disc = disc_from_unit(unit)
    middle = disc.mean(axis=0)
    x, y = (disc - middle).T / max(float(np.abs(disc - middle).max()), 1e-12)
    terms = [np.ones(len(unit)), x, y, x * x, x * y, y * y]
    return np.stack(terms[: {0: 1, 1: 3, 2: 6}[order]])


def trust(nodes: Nodes, level: FloatArray, floor: float) -> FloatArray:
    """Weights: solid angle over (noise^2 + (SHARE level)^2 + floor^2), so neither crowded nor bright points rule."""
    return np.asarray(nodes.weight / (nodes.variance + (SHARE * level) ** 2 + floor**2))


def _solve(a: FloatArray, b: FloatArray) -> FloatArray:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(a), 1e-300))
    scaled = a * scale[:, None] * scale
    scaled[np.diag_indices_from(scaled)] += 1e-12
    return np.asarray(scale * np.linalg.solve(scaled, scale * b))


def fit_together(
    lobes: tuple[Gauss, ...],
    bounds: tuple[Bounds, ...],
    nodes: Nodes,
    beside: FloatArray,
    ground: FloatArray,
    *,
    floor: float,
    steps: int,
) -> Fit:
    """Weighted least squares of lobes + ground terms (q, m), with `beside` (m,) taken off the nodes' values."""
    value = nodes.value - beside
    lobes, coefficients = _linear_start(lobes, bounds, nodes, beside, ground, floor)
    count = len(ground)
    weight = np.zeros(len(nodes))
    damping, cost = 1e-3, np.inf
    left = value
    normal, gradient = np.zeros((0, 0)), np.zeros(0)
    fresh, weighed = True, 0
    for _ in range(steps):
        if fresh:
            parts = [lobe.value_and_slopes(nodes.unit) for lobe in lobes]
            model = sum((p[0] for p in parts), coefficients @ ground)
            left = value - model
            if weighed < 2:
                weight = trust(nodes, np.maximum(np.abs(nodes.value), model + beside), floor)
                cost = float(weight @ left**2)
                weighed += 1
            slopes = np.concatenate([*(p[1] for p in parts), ground])
            weighted = slopes * weight
            normal, gradient = weighted @ slopes.T, weighted @ left
        damped = normal.copy()
        damped[np.diag_indices_from(damped)] *= 1.0 + damping
        step = _solve(damped, gradient)
        tried = _stepped(lobes, bounds, step)
        moved = coefficients + step[len(step) - count :]
        residual = value - sum((lobe.value(nodes.unit) for lobe in tried), moved @ ground)
        new_cost = float(weight @ residual**2)
        if new_cost < cost:
            gain = (cost - new_cost) / cost
            lobes, coefficients, left, cost, fresh = tried, moved, residual, new_cost, True
            damping = max(damping * 0.1, 1e-9)
            if gain < CONVERGED:
                if weighed >= 2:
                    break
                weighed = 1
        else:
            fresh = False
            damping = max(damping * 10.0, 1e-6)
            if damping > 1e4:
                break
    return Fit(lobes, left, weight, coefficients)


def _stepped(lobes: tuple[Gauss, ...], bounds: tuple[Bounds, ...], step: FloatArray) -> tuple[Gauss, ...]:
    """Lobes after a step, which is shortened to what a quadratic model can be trusted with."""
    result = []
    place = 0
    for lobe, bound in zip(lobes, bounds, strict=True):
        own = step[place : place + lobe.free].copy()
        place += len(own)
        sigma = lobe.sigma
        share = max(
            abs(own[0]) / 1.0,
            float(np.hypot(own[1], own[2])) / (0.7 * float(sigma[0])),
            float(np.abs(own[3:]).max()) / 0.5,
        )
        result.append(bound.keep(lobe.stepped(own / max(share, 1.0))))
    return tuple(result)


def _linear_start(
    lobes: tuple[Gauss, ...],
    bounds: tuple[Bounds, ...],
    nodes: Nodes,
    beside: FloatArray,
    ground: FloatArray,
    floor: float,
) -> tuple[tuple[Gauss, ...], FloatArray]:
    """Peaks and ground by linear least squares, the lobes' shapes as they are."""
    value = nodes.value - beside
    shapes = np.array([lobe.value(nodes.unit) for lobe in lobes]).reshape(len(lobes), len(nodes))
    weight = trust(nodes, np.maximum(np.abs(nodes.value), shapes.sum(axis=0)), floor)
    terms = np.concatenate((shapes, ground))
    solution = _solve((terms * weight) @ terms.T, (terms * weight) @ value)
    factors = np.clip(solution[: len(lobes)], 0.2, 5.0)
    lobes = tuple(
        bound.keep(replace(lobe, log_peak=lobe.log_peak + float(np.log(f))))
        for lobe, f, bound in zip(lobes, factors, bounds, strict=True)
    )
    rest = value - sum((lobe.value(nodes.unit) for lobe in lobes), np.zeros(len(nodes)))
    return lobes, _solve((ground * weight) @ ground.T, (ground * weight) @ rest)


def peak_errors(fit: Fit, nodes: Nodes, ground: FloatArray) -> FloatArray:
    """Relative standard errors of a fit's peaks: each node errs by its noise or by what is left, whichever is more."""
    slopes = np.concatenate([*(lobe.value_and_slopes(nodes.unit)[1] for lobe in fit.lobes), ground])
    weighted = slopes * fit.weight
    normal = weighted @ slopes.T
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    inverse = np.linalg.pinv(normal * scale[:, None] * scale, rcond=1e-13) * scale[:, None] * scale
    spread = (weighted * np.maximum(nodes.variance, fit.left**2)) @ weighted.T
    places = np.cumsum([0] + [lobe.free for lobe in fit.lobes])[:-1]
    return np.asarray(np.sqrt(np.maximum(np.diag(inverse @ spread @ inverse)[places], 0.0)))
