"""columns.py: what every systematic effect does to every point of a distribution: one signed column per effect."""

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.reduce.effects.angles import AngleChanges, angle_changes
from gonio.reduce.effects.gradient import slope_of
from gonio.reduce.effects.power import ReferenceBeam, power_columns
from gonio.reduce.effects.signal import level_of, signal_columns
from gonio.reduce.effects.stray import stray_columns
from gonio.reduce.points import Points
from gonio.units.instrument import Instrument

FloatArray = NDArray[np.float64]

# An effect is left out if it is nowhere this large beside noise, P_i and lamp: it would add 0.05 % to u. The latter two
# never cancel in a sum; noise does, so means over more and more neighbours along the path must not show it either.
_NEGLIGIBLE = 0.03
_NEIGHBOURS = (1, 64, 4096)
_FEW = 97


def angles_of(points: Points, distribution: Distribution, instrument: Instrument) -> AngleChanges:
    """The effects of angle with the distribution's own slopes: the part that costs time, for the two functions below.

    `points` and `distribution` hold the same n points; the distribution's DSF, variance and cells must be there.
    """
    aperture_rad = 0.5 * instrument.detector_aperture_mm / instrument.arm_radius_mm
    return angle_changes(points, distribution, instrument, slope_of(points, distribution, aperture_rad))


def effect_columns(
    points: Points,
    distribution: Distribution,
    instrument: Instrument,
    beam: ReferenceBeam,
    angles: AngleChanges | None = None,
) -> dict[str, FloatArray]:
    """Change of the DSF (n,) [1/sr] for one standard deviation of every systematic effect; keys: dataset/effects.py.
    NaN at masked points. `beam`: see reference_beam; `angles`: angles_of the same points, where it is at hand.

    Effects that are 0 everywhere are left out, and those too small to show (see _showing).
    """
    angles = angles or angles_of(points, distribution, instrument)
    dsf = distribution.dsf_per_sr
    dark_u = np.where(np.isnan(dsf), np.nan, points.dark_u_counts / (points.normalisation * distribution.p_i))
    level = level_of(points.signal, points.high_weight, instrument)
    columns = {
        **signal_columns(dsf, dark_u, level, beam.level, instrument),
        **power_columns(dsf, beam),
        **angles.columns,
        **stray_columns(dsf, instrument.calibration),
    }
    scale_u_rel = float(np.hypot(beam.p_i_u_rel, instrument.calibration.monitor_u_rel))
    return _showing(columns, distribution, scale_u_rel)


def pose_variance(angles: AngleChanges, stamp_u_us: float) -> FloatArray:
    """Variance (n,) [1/sr^2] of the DSF that changes from SYNC to SYNC, so is part of the independent variance: of the
    SYNC's time stamps, each with the standard uncertainty `stamp_u_us` and common to all axes, and of the readings'
    resolution."""
    return np.asarray((1e-6 * stamp_u_us * angles.per_second) ** 2 + angles.resolution_variance)


def _showing(columns: dict[str, FloatArray], distribution: Distribution, scale_u_rel: float) -> dict[str, FloatArray]:
    """The columns that show beside noise and the relative uncertainty of everything, at some scale along the path."""
    measured = np.flatnonzero(distribution.measured)
    kept: set[str] = set()
    # The first round looks at a few single points only, and spares most columns the rest.
    for size, step in ((1, _FEW), *((size, 1) for size in _NEIGHBOURS)):
        chosen = measured[::step]
        start = np.arange(0, len(chosen), size)
        noise = np.sqrt(_sums(distribution.variance_per_sr2[chosen], start))
        floor = _NEGLIGIBLE * np.hypot(noise, scale_u_rel * _sums(distribution.dsf_per_sr[chosen], start))
        for name, column in columns.items():
            if name not in kept and bool(np.any(np.abs(_sums(column[chosen], start)) > floor)):
                kept.add(name)
    return {name: column for name, column in columns.items() if name in kept}


def _sums(values: FloatArray, start: NDArray[np.intp]) -> FloatArray:
    """Sums (m,) of successive values (n,) from each `start` (m,) to the next."""
    return values if len(start) == len(values) else np.add.reduceat(values, start)
