"""weighting.py: how much each point of a distribution counts in a fit, and what is left beside a model."""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.nodes.points import Points

RELATIVE_FLOOR = 0.02  # of the DSF: no point counts as better known by the model's family than this
LOW = 1e-3  # of the mean DSF: below, all points count as equally dark


@dataclass(frozen=True)
class Left:
    """What is left beside a model in one distribution, on the DSF and by solid angle.

    rms_per_sr: root mean square; cv: that over the mean of the data; misplaced: share of the light, half the integral
    of |difference| over the integral of the data, that a model of the same integral sends elsewhere.
    """

    rms_per_sr: float
    cv: float
    misplaced: float


def weights(points: Points, model_dsf: FloatArray) -> FloatArray:
    """Weight (n,) of each squared difference of the DSF: the light that the cell carries over the variance,
    Omega y / (u^2 + (RELATIVE_FLOOR y)^2), y the model's DSF.

    By light, so that a narrow peak counts by what it carries, not by its small solid angle; y from the model and not
    from the point, so that noise does not choose its own weight.
    """
    y = np.maximum(model_dsf, LOW * points.integral / max(float(points.solid_angle_sr.sum()), 1e-300))
    y = np.maximum(y, 1e-12)
    weight = points.solid_angle_sr * y / (points.variance_per_sr2 + (RELATIVE_FLOOR * y) ** 2)
    return np.asarray(weight / np.mean(weight))


def left(points: Points, model_dsf: FloatArray) -> Left:
    """See Left."""
    omega = points.solid_angle_sr
    difference = model_dsf - points.dsf_per_sr
    rms = float(np.sqrt(omega @ difference**2 / omega.sum()))
    light = max(points.integral, 1e-300)
    return Left(rms, rms / (light / float(omega.sum())), 0.5 * float(omega @ np.abs(difference)) / light)


def thinned(points: Points, most: int) -> Points:
    """At most about `most` points: every n-th, with the solid angle of those left out; the brightest is kept."""
    step = -(-len(points.dsf_per_sr) // most)
    if step <= 1:
        return points
    kept = np.zeros(len(points.dsf_per_sr), dtype=bool)
    kept[::step] = True
    kept[np.argmax(points.dsf_per_sr)] = True
    return points.some(kept)
