"""lopsided.py: a scattering function without any symmetry, cell averages worked out plainly, and Radiance's answers."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin

ASK_RADIANCE = """
import json, sys
import pyradiance.bsdf as b
job = json.load(sys.stdin)
sd = b.load_file(job["path"])
print(json.dumps({
    "values": [float(b.query(sd, *q)[1]) for q in job["queries"]],
    "hemi": [b.direct_hemi(sd, t, p, b.SAMPLE_ALL) for t, p in job["hemi"]],
}))
"""


@dataclass(frozen=True)
class Lopsided:
    """Front and back, left and right, up and down differ, in all pairs of sides; a wide lobe follows the source."""

    pairs: tuple[tuple[bool, bool], ...] = ((True, True), (True, False), (False, True), (False, False))
    tint: float = 1.0

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        own = np.broadcast_to(incident[0], outgoing.shape) if which is None else incident[which]
        lit, out = own[:, 2] > 0, outgoing[:, 2] > 0
        strength = np.select([lit & out, lit & ~out, ~lit & out], [0.05, 0.08, 0.03], 0.04) * self.tint
        flat = 1.0 + 0.5 * outgoing[:, 0] + 0.3 * outgoing[:, 1] + 0.2 * own[:, 0] - 0.15 * own[:, 1]
        flat = flat + 0.2 * own[:, 0] * outgoing[:, 1]
        centre = np.stack((0.6 * own[:, 0] + 0.2, 0.3 - 0.5 * own[:, 1], np.where(out, 0.7, -0.7)), axis=1)
        centre /= np.linalg.norm(centre, axis=1, keepdims=True)
        lobe = 6.0 * np.exp((np.sum(centre * outgoing, axis=1) - 1.0) / 0.06)
        there = np.zeros(len(outgoing), dtype=np.bool_)
        for front, leaves in self.pairs:
            there |= (lit == front) & (out == leaves)
        return np.where(there, strength * (flat * np.abs(outgoing[:, 2]) + lobe), np.nan)

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        own = np.broadcast_to(incident[0], outgoing.shape) if which is None else incident[which]
        absent = np.isnan(self.dsf_per_sr(incident, outgoing, which))
        beyond = np.abs(own[:, 2]) < 0.5  # measured to 60 degrees
        found = np.where(beyond, Origin.EXTRAPOLATED, Origin.INTERPOLATED)
        return np.where(absent, Origin.ABSENT, found).astype(np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        return (incident_front, outgoing_front) in self.pairs

    def features(self, incident: FloatArray) -> Features:
        del incident
        return Features.none()


def concentric_disc(place: FloatArray) -> FloatArray:
    """Shirley and Chiu's map from the square, case by case as in their paper; (n, 2)."""
    disc = np.zeros_like(place)
    for k, (a, b) in enumerate(2.0 * place - 1.0):
        if a == 0 and b == 0:
            continue
        if abs(a) > abs(b):
            r, phi = a, np.pi / 4 * (b / a)
        else:
            r, phi = b, np.pi / 2 - np.pi / 4 * (a / b)
        disc[k] = r * np.cos(phi), r * np.sin(phi)
    return disc


def unit_of(xy: FloatArray, sign: float) -> FloatArray:
    """Unit vectors (n, 3) over direction cosines, on the side of that sign of z."""
    z = np.sqrt(np.maximum(1.0 - np.sum(xy**2, axis=1), 0.0))
    return np.column_stack((xy, sign * z))


def midpoints(cell: NDArray[np.int64], level: int, count: int) -> FloatArray:
    """Middles of count x count equal parts of a cell (2,) of the square, (count^2, 2)."""
    step = (np.arange(count) + 0.5) / count
    a, b = np.meshgrid(step, step, indexing="ij")
    return (cell + np.stack((a.ravel(), b.ravel()), axis=1)) / (1 << level)


def ask_radiance(path: Path, queries: list[list[float]], hemi: list[list[float]] | None = None) -> dict[str, Any]:
    """BSDF for theta_i, phi_i, theta_o, phi_o [deg] in Radiance's frame, and hemispherical values."""
    job = json.dumps({"path": str(path), "queries": queries, "hemi": hemi or []})
    done = subprocess.run([sys.executable, "-c", ASK_RADIANCE], input=job, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))
