"""starts.py: where fits start: what a family proposes, and for ABg the best of a search with A left out."""

from collections.abc import Sequence

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.model.analytic.abg import distance
from gonio.model.analytic.family import Family
from gonio.model.analytic.weighting import thinned, weights
from gonio.model.nodes.points import Points

_NEAR = 0.05  # direction cosines about the mirror direction
_BEST = 4
_RADII = np.geomspace(0.002, 1.5, 14)
_SLOPES = np.array([0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0])


def starts_of(family: Family, directions: Sequence[Points]) -> FloatArray:
    """Parameters (s, p) to start from."""
    steepest = max(directions, key=lambda points: float(points.incident[2]))
    cosine = np.maximum(steepest.unit[:, 2], 0.05)
    bsdf = steepest.dsf_per_sr / cosine
    r = distance(steepest.incident[None, :], steepest.unit, np.zeros(len(bsdf), dtype=np.int64))
    near = bsdf[r <= max(_NEAR, float(r.min()) * 1.01)]
    far = max(float(np.median(bsdf)), 1e-9)
    proposed = family.starts(max(float(near.max()), far), far)
    if family.name == "abg" and len(directions) == 1:
        return np.concatenate((_projected(directions[0]), proposed))
    return proposed


def _projected(points: Points) -> FloatArray:
    """The best of a grid over B and g: A is linear, so each has its best A in closed form (variable projection, Golub
    and Pereyra 1973)."""
    used = thinned(points, 2000)
    weight = weights(used, np.maximum(used.dsf_per_sr, 0.0))
    r = distance(used.incident[None, :], used.unit, np.zeros(len(used.dsf_per_sr), dtype=np.int64))
    found = []
    for radius in _RADII:
        for g in _SLOPES:
            shape = used.unit[:, 2] / (radius**g + r**g)
            a = max(float(weight @ (shape * used.dsf_per_sr)) / max(float(weight @ shape**2), 1e-300), 1e-12)
            found.append((float(weight @ (a * shape - used.dsf_per_sr) ** 2), a, float(radius**g), float(g)))
    return np.array([start[1:] for start in sorted(found)[:_BEST]])
