"""overlap.py: matrices of one Klems basis in another: patches hold constant values, overlaps are exact."""

import numpy as np

from gonio.dataset.scattering import FloatArray
from gonio.formats.window.klems import KlemsBasis


def overlaps_sr(old: KlemsBasis, new: KlemsBasis) -> FloatArray:
    """Projected solid angle [sr] that each patch of `new` shares with each of `old`, shape (new, old)."""
    result = np.zeros((new.size, old.size))
    for start_n, ring_n in zip(new.ring_start[:-1], new.rings, strict=True):
        for start_o, ring_o in zip(old.ring_start[:-1], old.rings, strict=True):
            low = max(ring_n.lower_deg, ring_o.lower_deg)
            high = min(ring_n.upper_deg, ring_o.upper_deg)
            if high <= low:
                continue
            height = float(np.diff(np.sin(np.radians([low, high])) ** 2)[0] / 2.0)
            width = _shared_azimuth_rad(ring_n.patches, ring_o.patches)
            result[start_n : start_n + ring_n.patches, start_o : start_o + ring_o.patches] = height * width
    return result


def rebinned(values: FloatArray, old: KlemsBasis, new: KlemsBasis) -> FloatArray:
    """BSDF [1/sr] (outgoing, incident) averaged over the patches of another basis. Every incident patch's sum becomes
    the mean of those it covers, weighted by the overlap."""
    shared = overlaps_sr(old, new)
    size = shared.sum(axis=1)
    return np.asarray(shared @ values @ shared.T / size[:, None] / size)


def _shared_azimuth_rad(new: int, old: int) -> FloatArray:
    """Azimuth that patches of a ring of `new` share with those of one of `old`, shape (new, old)."""
    width_n, width_o = 2.0 * np.pi / new, 2.0 * np.pi / old
    apart = width_n * np.arange(new)[:, None] - width_o * np.arange(old)
    foot, top = 0.5 * (width_n + width_o), min(width_n, width_o)
    turns = 2.0 * np.pi * np.arange(-1, 2)[:, None, None]
    return np.asarray(np.clip(foot - np.abs(apart + turns), 0.0, top).sum(axis=0))
