"""fit.py: finds the lobes of one measured distribution, from strong to weak, and keeps those that pay."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gonio.model.lobe import Lobe
from gonio.model.lobes.found import Found
from gonio.model.lobes.judge import in_vain, misfit
from gonio.model.lobes.scene import Scene
from gonio.model.lobes.search import Search

FloatArray = NDArray[np.float64]

FEWEST_POINTS = 30
NO_GAUSSIAN = 0.1  # mean relative error about a lobe from which relative weights no longer tell its width
SETTLED = 2  # fits, the second of what the first one found


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
    _drop_in_vain(found)
    _settle(found)
    lobes = sorted((g.lobe() for g in found.lobes), key=lambda lobe: -lobe.peak_per_sr)
    return tuple(replace(lobe, peak_per_sr=lobe.peak_per_sr * unit_of_dsf) for lobe in lobes)


def _drop_in_vain(found: Found) -> None:
    """What the last fit of all lobes has left without meaning."""
    for lobe in list(found.lobes):
        place = next(k for k, g in enumerate(found.lobes) if g is lobe)
        if in_vain(found, place):
            found.drop(place)


def _settle(found: Found) -> None:
    """A peak that is no Gaussian, alone: fitted where it is high. By relative weights, as shapes near a Gaussian are
    fitted, a top hat is a narrow lobe as well as a wide one, and another in each incident direction."""
    for place, lobe in enumerate(found.lobes):
        if found.neighbours(lobe, but=place) or misfit(found, place) < NO_GAUSSIAN:
            continue
        for _ in range(SETTLED):
            now = found.lobes[place]
            view = found.view([now.with_covariance(4.0 * now.covariance)], [place])  # with the dark about it
            if view is None:
                break
            (settled,) = replace(view, floor=now.peak).fit([now], 25).lobes
            found.replace(place, view.true(settled))
