"""gauss.py: values and derivatives of a Gaussian lobe in the parameters that are fitted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.model.hemisphere import tangent_axes
from gonio.model.lobe import Lobe

FloatArray = NDArray[np.float64]

PARAMETERS = 6  # log peak, two of the centre, three of the shape


@dataclass(frozen=True)
class Gauss:
    """exp(log_peak - |v|^2 / 2), v = (e^a (u1 + b u2), e^c u2), u azimuthal equidistant about the frame's last row.

    frame (3, 3): rows e1, e2, centre, carried along without turning as the centre moves, so that derivatives stay
    regular at the pole. shape (a, b, c): Cholesky factor of the inverse covariance, always positive definite.
    `circular`: b = 0 and c = a, four free parameters instead of six.
    """

    frame: FloatArray
    log_peak: float
    shape: tuple[float, float, float]
    circular: bool = False

    @staticmethod
    def of(
        centre: FloatArray,
        covariance: FloatArray,
        peak: float,
        *,
        frame: FloatArray | None = None,
        circular: bool = False,
    ) -> "Gauss":
        """From a covariance [rad^2] (2, 2) in `frame`, or in tangent_axes(centre)."""
        axes = tangent_axes(centre) if frame is None else frame
        inverse = np.linalg.inv(covariance)
        if circular:
            a = -0.25 * float(np.log(np.linalg.det(covariance)))
            return Gauss(axes, float(np.log(peak)), (a, 0.0, a), True)
        first = np.sqrt(inverse[0, 0])
        b = float(inverse[0, 1] / inverse[0, 0])
        c = 0.5 * float(np.log(np.linalg.det(inverse) / inverse[0, 0]))
        return Gauss(axes, float(np.log(peak)), (float(np.log(first)), b, c), False)

    @property
    def centre(self) -> FloatArray:
        """Unit vector (3,)."""
        return np.asarray(self.frame[2])

    @property
    def peak(self) -> float:
        """DSF at the centre [1/sr]."""
        return float(np.exp(self.log_peak))

    @property
    def covariance(self) -> FloatArray:
        """Covariance [rad^2] (2, 2) in the frame's e1, e2."""
        a, b, c = self.shape
        root = np.array([[np.exp(a), b * np.exp(a)], [0.0, np.exp(c)]])
        back = np.linalg.inv(root)
        return np.asarray(back @ back.T)

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations [rad] (2,) along the principal axes, the smaller first."""
        return np.asarray(np.sqrt(np.linalg.eigvalsh(self.covariance)))

    def lobe(self) -> Lobe:
        """The same as a Lobe, its covariance turned to tangent_axes of the centre."""
        axes = tangent_axes(self.centre)
        turn = axes[:2] @ self.frame[:2].T
        covariance = turn @ self.covariance @ turn.T
        return Lobe(self.centre.copy(), 0.5 * (covariance + covariance.T), self.peak)

    def whitened(self, unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Whitened coordinates v (2, m) and q = |v|^2 (m,) of unit vectors (m, 3)."""
        local = self.frame @ unit.T
        across = np.sqrt(local[0] ** 2 + local[1] ** 2)
        factor = np.arctan2(across, local[2]) / np.maximum(across, 1e-300)
        a, b, c = self.shape
        u2 = local[1] * factor
        v = np.stack((np.exp(a) * (local[0] * factor + b * u2), np.exp(c) * u2))
        return v, v[0] ** 2 + v[1] ** 2

    def value(self, unit: FloatArray) -> FloatArray:
        """DSF [1/sr] (m,) towards unit vectors (m, 3)."""
        return np.asarray(np.exp(self.log_peak - 0.5 * self.whitened(unit)[1]))

    def value_and_slopes(self, unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """DSF (m,) and its derivatives: (6, m) in log peak, centre towards e1 and e2 [1/rad], a, b, c; circular: the
        first four, the last in a = c.

        Moving the centre by d changes u by -(k I + (1 - k) r r') d, r the unit vector along u, k = t / tan t at the
        distance t: on the sphere, what lies abeam closes in more slowly than on a plane.
        """
        local = self.frame @ unit.T
        across = np.sqrt(local[0] ** 2 + local[1] ** 2)
        safe = np.maximum(across, 1e-300)
        factor = np.arctan2(across, local[2]) / safe
        near = factor * local[2]
        a, b, c = self.shape
        ea, ec = np.exp(a), np.exp(c)
        u2 = local[1] * factor
        v1, v2 = ea * (local[0] * factor + b * u2), ec * u2
        q1, q2 = v1**2, v2**2
        g = np.exp(self.log_peak - 0.5 * (q1 + q2))
        s1, s2 = ea * v1, b * ea * v1 + ec * v2
        r1, r2 = local[0] / safe, local[1] / safe
        along = (1.0 - near) * (r1 * s1 + r2 * s2)
        slopes = [g, g * (near * s1 + along * r1), g * (near * s2 + along * r2)]
        slopes += [-g * (q1 + q2)] if self.circular else [-g * q1, -g * v1 * ea * u2, -g * q2]
        return g, np.stack(slopes)

    def stepped(self, step: FloatArray) -> "Gauss":
        """After a step in the parameters of value_and_slopes."""
        frame = _moved(self.frame, step[1], step[2])
        a, b, c = self.shape
        shape = (a + step[3], 0.0, a + step[3]) if self.circular else (a + step[3], b + step[4], c + step[5])
        return Gauss(
            frame, self.log_peak + float(step[0]), (float(shape[0]), float(shape[1]), float(shape[2])), self.circular
        )

    def moved_to(self, centre: FloatArray) -> "Gauss":
        """The same shape with its centre carried to another unit vector."""
        local = self.frame @ centre
        across = float(np.hypot(local[0], local[1]))
        angle = float(np.arctan2(across, local[2])) / max(across, 1e-300)
        return self.shifted(local[:2] * angle)

    def with_covariance(self, covariance: FloatArray) -> "Gauss":
        """Another covariance [rad^2] in the same frame."""
        return Gauss.of(self.centre, covariance, self.peak, frame=self.frame, circular=self.circular)

    def shifted(self, offset: FloatArray) -> "Gauss":
        """The same shape with its centre moved by (2,) [rad] along e1 and e2."""
        frame = _moved(self.frame, float(offset[0]), float(offset[1]))
        return Gauss(frame, self.log_peak, self.shape, self.circular)

    def rounded(self) -> "Gauss":
        """A circular lobe of the same power."""
        return Gauss.of(self.centre, self.covariance, self.peak, frame=self.frame, circular=True)

    @property
    def free(self) -> int:
        """Number of free parameters."""
        return 4 if self.circular else PARAMETERS

    def widened(self, variance: float) -> "Gauss":
        """Convolved with a round Gaussian of this variance [rad^2] per axis; negative: that taken out again."""
        if variance == 0.0:
            return self
        before = self.covariance
        after = before + variance * np.eye(2)
        peak = self.peak * float(np.sqrt(np.linalg.det(before) / np.linalg.det(after)))
        return Gauss.of(self.centre, after, peak, frame=self.frame, circular=self.circular)


def _moved(frame: FloatArray, along1: float, along2: float) -> FloatArray:
    """The frame carried by the angle and direction (along1, along2) [rad] without turning about its centre."""
    angle = float(np.hypot(along1, along2))
    if angle < 1e-15:
        return frame
    towards = (along1 * frame[0] + along2 * frame[1]) / angle
    aside = (-along2 * frame[0] + along1 * frame[1]) / angle
    cos, sin = np.cos(angle), np.sin(angle)
    centre = cos * frame[2] + sin * towards
    ahead = cos * towards - sin * frame[2]
    e1 = (along1 * ahead - along2 * aside) / angle
    e2 = (along2 * ahead + along1 * aside) / angle
    return np.asarray(np.stack((e1, e2, centre)) / np.linalg.norm(centre))
