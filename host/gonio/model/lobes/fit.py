"""fit.py: finds the lobes of one measured distribution, from strong to weak, and keeps those that pay."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.lobe import Lobe
from gonio.model.lobes.found import Found
from gonio.model.lobes.scene import Scene
from gonio.model.lobes.search import Search

FloatArray = NDArray[np.float64]

FEWEST_POINTS = 30


def fit_lobes(
    unit: FloatArray,
    dsf: FloatArray,
    variance: FloatArray,
    solid_angle_sr: FloatArray,
    *,
    most: int = 8,
    hints: tuple[FloatArray, ...] = (),
) -> tuple[Lobe, ...]:
    """Gaussian lobes of one component of one incident direction, strongest first; none is a good answer.

    unit (n, 3): outgoing directions, folded (z >= 0); dsf [1/sr], its variance and the solid angle of each (n,).
    Points without a value or solid angle are left out. most: at most so many lobes; hints: ideal directions, unit
    vectors (3,), where a lobe is looked for even if nothing stands out. What lobes do not explain (a smooth ground,
    the shape of peaks that are no Gaussians) is left to whoever calls.
    """
    usable = np.isfinite(dsf) & np.isfinite(variance) & (solid_angle_sr > 0.0) & np.isfinite(solid_angle_sr)
    if np.count_nonzero(usable) < FEWEST_POINTS or most < 1:
        return ()
    weight = np.where(usable, solid_angle_sr, 0.0)
    unit_of_dsf = float(weight @ np.abs(np.where(usable, dsf, 0.0)) / weight.sum())
    if not 0.0 < unit_of_dsf < np.inf:
        return ()
    # in units of the mean: no threshold and no square depends on the DSF's own size
    found = Found(Scene(unit, dsf / unit_of_dsf, variance / unit_of_dsf**2, weight))
    Search(found, most).run(hints)
    lobes = sorted((g.lobe() for g in found.lobes), key=lambda lobe: -lobe.peak_per_sr)
    return tuple(replace(lobe, peak_per_sr=lobe.peak_per_sr * unit_of_dsf) for lobe in lobes)
