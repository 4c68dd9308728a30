"""gaussian.py: Gaussian lobes about the mirror or through direction and about retro, on a diffuse ground."""

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray
from gonio.model.analytic.family import Parameter, Process
from gonio.model.analytic.polar_rule import graded

_NARROW_DEG = 12.0
_MIRROR = np.array([-1.0, -1.0, 1.0])


def _angle_rad(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angle between unit vectors (m, 3), exact for tiny ones (Kahan 2006, section 12)."""
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)))


class Gaussian:
    """DSF = diffuse / pi cos(theta_s) + sum over two lobes of peak exp(-a^2 / (2 sigma^2)), a the angle from the mirror
    (in transmission: through) direction and from retro (in transmission: its image behind the sample's plane). The
    lobes are of the DSF, as they are seen by a detector, so they are not reciprocal at large angles."""

    name = "gaussian"
    source = "DSF = diffuse / pi cos(theta_s) + peak exp(-a^2 / (2 sigma^2)), a from mirror or through, and from retro"
    processes: tuple[Process, ...] = ("reflection", "transmission")
    parameters = (
        Parameter("diffuse", "1", 0.0, 1.0, False, "hemispherical value of the ground"),
        Parameter("opposite_peak", "1/sr", 0.0, 1e7, False, "DSF of the mirror or through lobe"),
        Parameter("opposite_sigma", "deg", 0.05, 60.0, True, "its standard deviation"),
        Parameter("same_peak", "1/sr", 0.0, 1e7, False, "DSF of the retro lobe"),
        Parameter("same_sigma", "deg", 0.05, 60.0, True, "its standard deviation"),
    )
    per_direction = True

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """See Family."""
        own, of = incident[which], values[which]
        dsf = np.zeros(len(outgoing))
        for column, centre in ((1, own * _MIRROR), (3, own)):
            off = _angle_rad(outgoing, centre) / np.radians(of[:, column + 1])
            dsf += of[:, column] * np.exp(-0.5 * off**2)
        return np.asarray(of[:, 0] / np.pi + dsf / np.maximum(outgoing[:, 2], 1e-12))

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """See Family: circles of radius a about a lobe's centre at polar angle theta have the share
        acos(-cot theta cot a) / pi above the horizon."""
        node, weight = graded(per_halving=2)
        theta = np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), incident[:, 2])[:, None]
        whole = np.pi / 2.0 - theta  # circles up to here lie wholly above the horizon
        inside = whole * node
        # From there on the share falls like a square root: a = whole + 2 theta s^2 makes it smooth.
        beyond = whole + 2.0 * theta * node**2
        angle = np.concatenate((inside, beyond), axis=1)
        step = np.concatenate((whole * weight, 4.0 * theta * node * weight), axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            tangents = np.nan_to_num(np.cos(theta) * np.cos(angle) / (np.sin(theta) * np.sin(angle)), nan=1.0)
        arc = 2.0 * np.arccos(np.clip(-tangents, -1.0, 1.0))
        arc[:, : inside.shape[1]] = 2.0 * np.pi
        total = values[:, 0].copy()
        for column in (1, 3):
            sigma = np.radians(values[:, column + 1])[:, None]
            lobe = np.exp(-0.5 * (angle / sigma) ** 2)
            total += values[:, column] * np.sum(lobe * np.sin(angle) * arc * step, axis=1)
        return total

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """Both lobes, where they are narrow and there."""
        found = []
        for column, centre in ((1, incident * _MIRROR), (3, incident)):
            rows = np.flatnonzero((values[:, column] > 0.0) & (values[:, column + 1] < _NARROW_DEG))
            found.append((centre[rows], np.radians(values[rows, column + 1]), rows))
        centres, sigmas, rows_of = zip(*found, strict=True)
        return Features(np.concatenate(centres), np.concatenate(sigmas), np.concatenate(rows_of).astype(np.int64))

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family."""
        excess = max(mirror_bsdf - far_bsdf, 0.01 * far_bsdf, 1e-6)
        ground = min(np.pi * far_bsdf, 0.9)
        widths = ((1.5, 1.5), (1.5, 12.0), (12.0, 1.5), (12.0, 12.0), (5.0, 25.0))
        return np.array([(ground, excess, opposite, excess, same) for opposite, same in widths])
