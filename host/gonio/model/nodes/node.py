"""node.py: what is kept of one measured incident direction: lobes, what is left beside them, and a background."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.evaluate import lobes_at, near_lobes
from gonio.model.grid_fit import fit_grid, grid_at, suitable_size
from gonio.model.hemisphere import disc_from_unit, ideal
from gonio.model.lobe import Lobe
from gonio.model.lobes.fit import fit_lobes
from gonio.model.nodes.coverage import coverage
from gonio.model.nodes.frames import level_axes, level_covariance, symmetric_function
from gonio.model.nodes.points import Points
from gonio.model.slices import PATCH_HALF_WIDTH

FloatArray = NDArray[np.float64]

MOST_BACKGROUND = 129  # nodes per side beside lobes; 1.3 degrees at the normal
MOST_PLAIN = 257  # without lobes
MOST_PATCH = 33  # a quarter of the lobe's standard deviation
# Of PATCH_HALF_WIDTH: so far a lobe's window is 1; it falls to 0 at PATCH_HALF_WIDTH. A sharp one is nearly all patch:
# a background is too coarse for the skirts that a peak with edges, such as a beam, does not have.
_FULL, _FULL_SHARP = 0.6, 0.9
_SHARP_RAD = np.radians(1.0)
_SKIRT = 5.2  # standard deviations of a sharp lobe where it is 1e-6 of its peak: so far it hides the background
_NARROW_RAD = np.radians(5.0)  # lobes up to this hide the background under them
_WIDE_RAD = np.radians(10.0)  # from here on the points under a lobe tell of the background too


@dataclass(frozen=True)
class Node:
    """One incident direction of a component, folded; isotropic samples: turned to azimuth 0.

    incident (3,); centre (l, 3), log_peak (l,) of DSF in 1/sr, log_covariance (l, 2, 2): matrix logarithm [rad^2] in
    level axes about the centre (frames.py); patch (l arrays): what is left beside lobes, in their whitened
    coordinates; background: on Lambert's disc. integral: sum over the points; stated: the dataset's own, with u;
    scale: what makes the model's sum over the points equal to theirs.
    """

    incident: FloatArray
    centre: FloatArray
    log_peak: FloatArray
    log_covariance: FloatArray
    patch: tuple[NDArray[np.float32], ...]
    background: NDArray[np.float32]
    coverage: NDArray[np.uint8]
    points: int
    integral: float
    stated: float
    stated_u: float
    scale: float = 1.0

    @property
    def sigma_rad(self) -> FloatArray:
        """Standard deviations (l, 2) along the principal axes, the smaller first."""
        return np.asarray(np.exp(0.5 * np.linalg.eigvalsh(self.log_covariance))).reshape(-1, 2)

    @property
    def power(self) -> FloatArray:
        """Of the lobes (l,), over the plane."""
        half_trace = 0.5 * np.trace(self.log_covariance, axis1=-2, axis2=-1)
        return np.asarray(2.0 * np.pi * np.exp(self.log_peak + half_trace))

    def with_scale(self, scale: float) -> "Node":
        """The same, scaled."""
        return replace(self, scale=scale)


def lobes_of(points: Points) -> tuple[Lobe, ...]:
    """Lobes of one incident direction; mirror (or through) and retro are looked at first."""
    hints = (ideal("opposite", points.incident), ideal("same", points.incident))
    return fit_lobes(points.unit, points.dsf_per_sr, points.variance_per_sr2, points.solid_angle_sr, hints=hints)


@dataclass(frozen=True)
class Ground:
    """What every way to model a direction's points needs: their places on the disc (n, 2), the size of a grid that
    shows all of them, their coverage."""

    disc: FloatArray
    size: int
    coverage: NDArray[np.uint8]

    @staticmethod
    def of(points: Points) -> "Ground":
        """From the points."""
        disc = disc_from_unit(points.unit)
        return Ground(disc, suitable_size(disc, 1.0), coverage(disc))


def build_node(points: Points, lobes: tuple[Lobe, ...], ground: Ground) -> Node:
    """Background and patches around these lobes; without lobes the background is all."""
    disc = ground.disc
    weight = points.solid_angle_sr / np.mean(points.solid_angle_sr)
    left = np.array(points.dsf_per_sr)
    centre = np.array([lobe.centre for lobe in lobes]).reshape(-1, 3)
    covariance = np.array([level_covariance(lobe.centre, lobe.covariance_rad2) for lobe in lobes]).reshape(-1, 2, 2)
    log_covariance = symmetric_function(covariance, np.log) if len(lobes) else covariance
    rows: list[NDArray[np.int64]] = []
    whitened: list[FloatArray] = []
    if lobes:
        axes = np.array([level_axes(c) for c in centre])
        whitening = np.ascontiguousarray(symmetric_function(-0.5 * log_covariance, np.exp))
        left -= lobes_at(axes, whitening, np.array([lobe.peak_per_sr for lobe in lobes]), points.unit)
        rows, whitened = near_lobes(axes, whitening, points.unit, _SKIRT)
    seen = np.ones(len(left))  # 1 - window of narrow lobes: what is under them is not background
    for lobe, at in zip(lobes, rows, strict=True):
        if float(lobe.sigma_rad[1]) < _SHARP_RAD:
            seen[at] = 0.0
    inside = [np.hypot(v[:, 0], v[:, 1]) <= PATCH_HALF_WIDTH for v in whitened]
    rows = [at[i] for at, i in zip(rows, inside, strict=True)]
    whitened = [v[i] for v, i in zip(whitened, inside, strict=True)]
    windows = [_window(v, float(lobe.sigma_rad[1])) for v, lobe in zip(whitened, lobes, strict=True)]
    outside, total = np.ones(len(left)), np.zeros(len(left))
    for lobe, at, window in zip(lobes, rows, windows, strict=True):
        hides = np.clip((_WIDE_RAD - lobe.sigma_rad[1]) / (_WIDE_RAD - _NARROW_RAD), 0.0, 1.0)
        seen[at] *= 1.0 - hides * window
        outside[at] *= 1.0 - window
        total[at] += window
    size = min(ground.size, MOST_BACKGROUND if lobes else MOST_PLAIN)
    background = fit_grid(disc, left, points.variance_per_sr2, weight * seen, half_width=1.0, size=size)
    patch = []
    for at, v, window in zip(rows, whitened, windows, strict=True):
        if len(at) == 0:
            patch.append(np.zeros((2, 2), dtype=np.float32))
            continue
        beside = left[at] - grid_at(background, 1.0, disc[at])
        share = window * (1.0 - outside[at]) / np.maximum(total[at], 1e-300)  # windows that overlap share what is left
        grid = fit_grid(
            v,
            beside * share,
            points.variance_per_sr2[at] * share**2,
            weight[at],
            half_width=PATCH_HALF_WIDTH,
            size=min(suitable_size(v, PATCH_HALF_WIDTH), MOST_PATCH),
        )
        patch.append((grid * _inside(len(grid))).astype(np.float32))
    return Node(
        points.incident,
        centre,
        np.log([lobe.peak_per_sr for lobe in lobes]) if lobes else np.zeros(0),
        log_covariance,
        tuple(patch),
        background.astype(np.float32),
        ground.coverage,
        len(points.unit),
        points.integral,
        points.stated,
        points.stated_u,
    )


def _window(v: FloatArray, sigma_rad: float) -> FloatArray:
    """1 about the centre, 0 from PATCH_HALF_WIDTH on, smooth between."""
    r = np.hypot(v[:, 0], v[:, 1]) / PATCH_HALF_WIDTH
    full = np.interp(sigma_rad, (_SHARP_RAD, _NARROW_RAD), (_FULL_SHARP, _FULL))
    t = np.clip((r - full) / (1.0 - full), 0.0, 1.0)
    return np.asarray(1.0 - t * t * (3.0 - 2.0 * t))


def _inside(size: int) -> FloatArray:
    """1 for the nodes of a patch inside the window's circle: outside a patch is nothing."""
    axis = np.linspace(-1.0, 1.0, size)
    return np.asarray(np.hypot(axis[:, None], axis) < 1.0, dtype=np.float64)
