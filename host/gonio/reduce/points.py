"""points.py: from the samples of flown paths to the points of one distribution: light, normalisation, masks, DSF."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import MASKED, Distribution, PointFlag
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.reduce.corrections import distance, lamp, masks, stray_light
from gonio.reduce.corrections.chain import Switches
from gonio.reduce.corrections.noise import light_variance
from gonio.reduce.samples.flown import Flown
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]


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
    q_deg: FloatArray  # (n, axes)
    axis_rate_deg_per_s: FloatArray  # (n, axes)
    high_weight: FloatArray  # of the high gain in the signal
    dark_u_counts: FloatArray  # standard uncertainty of the dark that was subtracted, common to neighbours

    @classmethod
    def joined(cls, parts: Sequence["Points"]) -> "Points":
        """All points one after the other."""
        return cls(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)})


def points_of(
    flown: Flown,
    path: int,
    scale: Scale,
    instrument: Instrument,
    switches: Switches,
    shade_deg: float | None,
) -> Points:
    """The samples of a path as points. `shade_deg` None: the free beam, with no sample that lies off the centre, and
    nothing that the head shades."""
    flags, unit, signal = flown.flags, flown.unit, flown.signal
    variance = light_variance(flown.dark_variance, scale.shot_per_count, signal)
    dark_u = flown.dark_u_counts
    normalisation = np.ones(len(flags))
    if switches.on(lamp.NAME):
        normalisation = lamp.normalisation(flown.monitor_counts, scale.monitor_counts)
    if shade_deg is not None:
        calibration = instrument.calibration
        if switches.on(masks.NAME):
            shade = masks.shadowed(flown.cosine_from_source, shade_deg)
            flags = flags | np.where(shade, np.uint16(PointFlag.SHADOWED), np.uint16(0))
        if switches.on(distance.NAME) and calibration.sample_offset_mm and flown.incident_deg is not None:
            offset = calibration.sample_offset_mm, instrument.arm_radius_mm
            unit, factor = distance.seen_from_spot(unit, flown.incident_deg, *offset)
            signal, variance, dark_u = signal * factor, variance * factor**2, dark_u * factor
        if switches.on(stray_light.NAME) and calibration.stray_light_per_sr:
            signal = stray_light.without_stray(signal, normalisation, scale.p_i, calibration.stray_light_per_sr)
    return Points(
        unit=unit,
        signal=signal,
        variance=variance,
        normalisation=normalisation,
        count=np.ones(len(flags), dtype=np.int32),
        flags=flags,
        time_ns=flown.time_ns,
        path=np.full(len(flags), path, dtype=np.int32),
        q_deg=flown.q_deg,
        axis_rate_deg_per_s=flown.axis_rate_deg_per_s,
        high_weight=flown.high_weight,
        dark_u_counts=dark_u,
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
        q_deg=mean(points.q_deg),
        axis_rate_deg_per_s=mean(points.axis_rate_deg_per_s),
        high_weight=mean(points.high_weight),
        dark_u_counts=mean(points.dark_u_counts),
    )


def unreachable_points(entries: Sequence[dict[str, Any]], incident_deg: tuple[float, float], axes: int) -> Points:
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
        q_deg=np.full((n, axes), np.nan),
        axis_rate_deg_per_s=np.full((n, axes), np.nan),
        high_weight=np.full(n, np.nan),
        dark_u_counts=np.full(n, np.nan),
    )


def distribution_of(points: Points, omega: FloatArray, incident_deg: tuple[float, float], scale: Scale) -> Distribution:
    """The points as a distribution; masked ones have NaN for the DSF and its variance. The division comes here, last,
    and keeps the sign of the signal."""
    masked = points.flags & MASKED != 0
    with np.errstate(invalid="ignore", divide="ignore"):
        per_signal = 1.0 / (points.normalisation * scale.p_i)
        dsf = points.signal * per_signal
        variance = points.variance * per_signal**2
        variance += dsf**2 * (scale.monitor_variance_rel / np.maximum(points.count, 1))
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
