"""points.py: from the samples of flown paths to the points of one distribution: DSF, variance, masks, cells."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import MASKED, Distribution, PointFlag
from gonio.geometry.cells import disc_solid_angles_sr, hemisphere_solid_angles_sr, solid_angles_sr
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.reduce.samples.flown import Flown
from gonio.reduce.samples.masks import shadowed

FloatArray = NDArray[np.float64]

RUN_DEG = 0.1


@dataclass(frozen=True)
class Scale:
    """What turns light into DSF: mean lamp monitor of the reference scan, P_i, and the noise of light and monitor."""

    monitor_counts: float
    p_i: float
    p_i_u_rel: float
    shot_per_count: float
    monitor_variance_rel: float


@dataclass
class Points:
    """Points of one incident direction in the order flown; arrays (n,), `unit` (n, 3)."""

    unit: FloatArray
    signal: FloatArray
    variance: FloatArray  # of the signal, counts^2
    normalisation: FloatArray
    count: NDArray[np.int32]
    flags: NDArray[np.uint16]
    time_ns: NDArray[np.int64]
    path: NDArray[np.int32]  # index in the list of flown paths; -1 for points that no path flew

    @classmethod
    def joined(cls, parts: Sequence["Points"]) -> "Points":
        """All points one after the other."""
        return cls(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)})

    def where(self, chosen: NDArray[np.bool_]) -> "Points":
        """The chosen ones, in order."""
        return Points(**{f.name: getattr(self, f.name)[chosen] for f in fields(self)})


def points_of(flown: Flown, path: int, scale: Scale, shade_deg: float | None) -> Points:
    """The samples of a path as points. `shade_deg` None (free beam): the head shades nothing that counts."""
    flags = flown.flags.copy()
    if shade_deg is not None:
        flags[shadowed(flown.detector_lab, shade_deg)] |= np.uint16(PointFlag.SHADOWED)
    return Points(
        unit=flown.outgoing,
        signal=flown.signal,
        variance=flown.dark_variance + scale.shot_per_count * np.maximum(flown.signal, 0.0),
        normalisation=flown.monitor_counts / scale.monitor_counts,
        count=np.ones(len(flags), dtype=np.int32),
        flags=flags,
        time_ns=flown.time_ns,
        path=np.full(len(flags), path, dtype=np.int32),
    )


def binned(points: Points, bin_deg: float) -> Points:
    """Successive points of one path joined over `bin_deg` of track: means, variance of the mean, all flags.

    Masked and measured points are never joined.
    """
    step = np.linalg.norm(np.diff(points.unit, axis=0, prepend=points.unit[:1]), axis=1)
    place = np.floor(np.cumsum(np.degrees(step)) / bin_deg)
    masked = points.flags & MASKED != 0
    new = np.ones(len(place), dtype=bool)
    new[1:] = (np.diff(place) != 0) | (np.diff(masked) != 0)
    start = np.flatnonzero(new)
    size = np.diff(start, append=len(place)).astype(np.int32)

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray((np.add.reduceat(values, start, axis=0).T / size).T)

    unit = mean(points.unit)
    origin = points.time_ns[0]
    return Points(
        unit=unit / np.linalg.norm(unit, axis=1)[:, None],
        signal=mean(points.signal),
        variance=mean(points.variance) / size,
        normalisation=mean(points.normalisation),
        count=np.add.reduceat(points.count, start),
        flags=np.bitwise_or.reduceat(points.flags, start),
        time_ns=origin + np.rint(mean((points.time_ns - origin).astype(np.float64))).astype(np.int64),
        path=points.path[start],
    )


def unreachable_points(entries: Sequence[dict[str, Any]], incident_deg: tuple[float, float]) -> Points:
    """Masked points where the plan found that the instrument cannot look."""
    own = [e for e in entries if (e["incident_theta_deg"], e["incident_phi_deg"]) == incident_deg]
    n = len(own)
    return Points(
        unit=unit_from_angles_deg([e["theta_deg"] for e in own], [e["phi_deg"] for e in own]).reshape(n, 3),
        signal=np.full(n, np.nan),
        variance=np.full(n, np.nan),
        normalisation=np.full(n, np.nan),
        count=np.zeros(n, dtype=np.int32),
        flags=np.full(n, PointFlag.UNREACHABLE, dtype=np.uint16),
        time_ns=np.zeros(n, dtype=np.int64),
        path=np.full(n, -1, dtype=np.int32),
    )


def cells(points: Points, kinds: Sequence[str]) -> FloatArray:
    """Solid angles (n,). Where the coarse pass covered a hemisphere its points share all of it; where it did not, the
    points of a peak's spiral share only their disc. `kinds` has the kind of each flown path."""
    coarse = np.array([kind == "coarse" for kind in kinds] + [False])[points.path]  # path -1: the last
    up = points.unit[:, 2] >= 0.0
    covered = [_covers(points.unit[coarse & side, 2]) for side in (up, ~up)]
    if all(covered):
        return _in_runs(points, coarse, solid_angles_sr)
    omega = np.zeros(len(up))
    for side, of_coarse in zip((up, ~up), covered, strict=True):
        if of_coarse:
            omega[side] = _in_runs(points.where(side), coarse[side], hemisphere_solid_angles_sr)
            continue
        for path in np.unique(points.path[side & (points.path >= 0)]):
            own = side & (points.path == path)
            if kinds[path] == "peak" and own.sum() > 2:
                pole = points.unit[own].sum(axis=0)
                omega[own] = disc_solid_angles_sr(points.unit[own], pole / np.linalg.norm(pole))
    return omega


def _in_runs(points: Points, coarse: NDArray[np.bool_], areas: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Solid angles (n,): successive samples of the coarse pass within RUN_DEG of track share their middle one's cell.

    They lie far closer along the track than the tracks do, and than the aperture sees: cells of their own would cost
    three times the work and tell nothing more.
    """
    step_deg = np.degrees(np.linalg.norm(np.diff(points.unit, axis=0, prepend=points.unit[:1]), axis=1))
    place = np.floor(np.cumsum(np.where(coarse, step_deg, 0.0)) / RUN_DEG)
    new = ~coarse
    new[:1] = True
    new[1:] |= (np.diff(place) != 0) | (np.diff(points.path) != 0)
    start = np.flatnonzero(new)
    size = np.diff(start, append=len(new))
    return np.repeat(areas(points.unit[start + size // 2]) / size, size)


def _covers(height: FloatArray) -> bool:
    """Whether a pass with these cosines (n,) went over its hemisphere and not just along the horizon."""
    return len(height) > 0 and bool(np.abs(height).max() > 0.5)


def distribution_of(points: Points, omega: FloatArray, incident_deg: tuple[float, float], scale: Scale) -> Distribution:
    """The points as a distribution; masked ones have NaN for the DSF and its variance."""
    masked = points.flags & MASKED != 0
    with np.errstate(invalid="ignore", divide="ignore"):
        dsf = points.signal / (points.normalisation * scale.p_i)
        variance = points.variance / (points.normalisation * scale.p_i) ** 2
        variance = variance + dsf**2 * scale.monitor_variance_rel / np.maximum(points.count, 1)
        low = ~masked & (points.signal < 3.0 * np.sqrt(points.variance))
    dsf[masked] = np.nan
    variance[masked] = np.nan
    flags = points.flags | np.where(low, np.uint16(PointFlag.LOW_SIGNAL), np.uint16(0))
    theta_deg, phi_deg = angles_deg_from_unit(points.unit)
    return Distribution(
        incident_theta_deg=incident_deg[0],
        incident_phi_deg=incident_deg[1],
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        dsf_per_sr=dsf,
        variance_per_sr2=variance,
        signal=points.signal,
        normalisation=points.normalisation,
        count=points.count,
        flags=flags,
        solid_angle_sr=omega,
        time_ns=points.time_ns,
        p_i=scale.p_i,
        p_i_u_rel=scale.p_i_u_rel,
    )
