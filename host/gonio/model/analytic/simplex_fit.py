"""simplex_fit.py: the ABg fit as paper [2] describes it, section 4.2.1, for comparison."""

from dataclasses import dataclass

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.weighting import thinned
from gonio.model.nodes.points import Points

_MOST_POINTS = 4000
_GRAZING = 0.05  # cosine below which a BSDF is mostly the DSF's noise
_PENALTY = 1e3


@dataclass(frozen=True)
class SimplexFit:
    """A, B, g (3,); root mean square difference of the BSDF [1/sr] over the points that were used."""

    values: FloatArray
    rms_bsdf_per_sr: float
    points: int


def fit_simplex(points: Points) -> SimplexFit:
    """Nelder and Mead's simplex on the root mean square difference of the BSDF, all points alike, with a high penalty
    on negative A, B and g; one start, read off the data. At most some 4000 points, not within 3 degrees of grazing."""
    from scipy.optimize import minimize  # noqa: PLC0415 - slow to load, and few models need it

    used = thinned(points, _MOST_POINTS)
    kept = used.unit[:, 2] > _GRAZING
    unit, dsf = used.unit[kept], used.dsf_per_sr[kept]
    bsdf = dsf / unit[:, 2]
    r = np.hypot(*(unit[:, :2] + points.incident[:2]).T)

    def error(x: FloatArray) -> float:
        a, b, g = np.maximum(x, (0.0, 1e-300, 0.0))
        negative = float(np.sum(np.maximum(-x, 0.0)))
        rms = float(np.sqrt(np.mean((a / (b + r**g) - bsdf) ** 2)))
        return rms + _PENALTY * (float(np.abs(bsdf).max()) + 1.0) * negative

    top = max(float(bsdf[np.argmin(r)]), 1e-6)
    half = r[bsdf > 0.5 * top]
    b = float(np.clip(np.median(half) if len(half) else 0.1, 0.01, 1.0)) ** 2
    options = {"maxiter": 2000, "maxfev": 2000, "xatol": 1e-10, "fatol": 1e-10}
    found = minimize(error, np.array([top * b, b, 2.0]), method="Nelder-Mead", options=options)
    values = np.maximum(found.x, (0.0, 1e-14, 0.0))
    return SimplexFit(values, float(np.sqrt(np.mean((values[0] / (values[1] + r ** values[2]) - bsdf) ** 2))), len(r))
