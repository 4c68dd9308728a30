"""kinematics.py: axis readings to directions in the sample frame and back, for any chain of turns about the origin."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

# Lab frame: +Z is towards the source, and the detector stands there when its axes read zero (CONVENTIONS.md).
SOURCE_LAB = np.array([0.0, 0.0, 1.0])
_DEGENERATE = 1e-9


class AxisGeometry(Protocol):
    """What kinematics needs of an axis: its sense is the vector's sign, its zero that of the readings."""

    @property
    def vector(self) -> Sequence[float]:
        """Direction of the axis in the lab when every reading is zero."""

    @property
    def carries(self) -> str:
        """ "sample" or "detector": what turns with it, together with the later axes of the same kind."""


def _rotate(v: FloatArray, axis: FloatArray, cos: FloatArray, sin: FloatArray) -> FloatArray:
    """Turn v (3, n) or (3, 1) about a unit vector (3,) by angles given as cosine and sine (n,) (Rodrigues' formula)."""
    along = (axis @ v) * (1.0 - cos)
    x, y, z = v
    cross = np.stack((axis[1] * z - axis[2] * y, axis[2] * x - axis[0] * z, axis[0] * y - axis[1] * x))
    return v * cos + cross * sin + axis[:, None] * along


def _turn_angle(start: FloatArray, end: FloatArray, axis: FloatArray) -> FloatArray:
    """Angle in radians, shape (n,), that turns start (3, n) into end (3, n) about the axis; 0 where both lie on it."""
    start_across = start - axis[:, None] * (axis @ start)
    end_across = end - axis[:, None] * (axis @ end)
    cross = np.cross(start_across, end_across, axis=0)
    sine, cosine = axis @ cross, np.sum(start_across * end_across, axis=0)
    on_axis = np.hypot(sine, cosine) < _DEGENERATE**2
    return np.where(on_axis, 0.0, np.arctan2(sine, cosine))


def _two_turns(first: FloatArray, second: FloatArray, start: FloatArray, end: FloatArray) -> list[FloatArray]:
    """Both solutions, each (2, n) in radians, of R(first, a) R(second, b) start = end, vectors (3, n); NaN where none.

    The two circles that `start` and `end` draw about their axes meet in up to two points (Paden and Kahan's second
    subproblem; Murray, Li, Sastry, "A Mathematical Introduction to Robotic Manipulation", 1994, section 3.3.2).
    """
    cosine = float(first @ second)
    normal = np.cross(first, second)
    sine_squared = 1.0 - cosine**2
    on_first, on_second = first @ end, second @ start
    a = (on_first - cosine * on_second) / sine_squared
    b = (on_second - cosine * on_first) / sine_squared
    square = (1.0 - a**2 - b**2 - 2.0 * a * b * cosine) / sine_squared
    reach = np.sqrt(np.where(square < -_DEGENERATE, np.nan, np.maximum(square, 0.0)))
    solutions = []
    for side in (reach, -reach):
        meeting = first[:, None] * a + second[:, None] * b + normal[:, None] * side
        turn = np.stack((_turn_angle(meeting, end, first), _turn_angle(start, meeting, second)))
        solutions.append(np.where(np.isnan(reach), np.nan, turn))
    return solutions


class Kinematics:
    """Kinematics of an instrument whose axes pass through the origin, in the order in which they carry one another."""

    def __init__(self, axes: Sequence[AxisGeometry]) -> None:
        """Raises UsageError for a vector without direction and for a `carries` that is neither sample nor detector."""
        self.axis_count = len(axes)
        self._vectors: list[FloatArray] = []
        self._sample: list[int] = []
        self._detector: list[int] = []
        for number, axis in enumerate(axes):
            vector = np.asarray(axis.vector, dtype=np.float64)
            length = float(np.linalg.norm(vector))
            if vector.shape != (3,) or not np.isfinite(length) or length < _DEGENERATE:
                raise UsageError(f"axis {number + 1}: vector {list(axis.vector)} has no direction; give three numbers")
            if axis.carries not in ("sample", "detector"):
                raise UsageError(f"axis {number + 1}: carries = {axis.carries!r}; it must be 'sample' or 'detector'")
            self._vectors.append(vector / length)
            (self._sample if axis.carries == "sample" else self._detector).append(number)

    def detector_in_lab(self, q_deg: ArrayLike) -> FloatArray:
        """Unit vectors (n, 3) from the origin to the detector, lab frame, for readings (n, axes) in degrees."""
        cos, sin = self._cos_sin(q_deg)
        return np.ascontiguousarray(self._detector_lab(cos, sin).T)

    def directions(self, q_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Incident and outgoing unit vectors, each (n, 3), in the sample frame, for readings (n, axes) in degrees."""
        cos, sin = self._cos_sin(q_deg)
        incident = np.repeat(SOURCE_LAB[:, None], cos.shape[1], axis=1)
        outgoing = self._detector_lab(cos, sin)
        # lab <- sample is the product of the turns in order, so its inverse undoes them in that order.
        for number in self._sample:
            incident = _rotate(incident, self._vectors[number], cos[number], -sin[number])
            outgoing = _rotate(outgoing, self._vectors[number], cos[number], -sin[number])
        return np.ascontiguousarray(incident.T), np.ascontiguousarray(outgoing.T)

    def to_lab(self, q_deg: ArrayLike, in_sample: ArrayLike) -> FloatArray:
        """Vectors (n, 3) of the sample frame in the lab frame, for readings (n, axes) in degrees."""
        cos, sin = self._cos_sin(q_deg)
        v = np.array(in_sample, dtype=np.float64).T
        for number in reversed(self._sample):
            v = _rotate(v, self._vectors[number], cos[number], sin[number])
        return np.ascontiguousarray(v.T)

    def sample_axes_for_incident(self, theta_deg: float, phi_deg: float) -> tuple[float, float]:
        """Readings of the two sample axes in degrees that bring the source to (theta, phi): the solution with the first
        reading in [0, 180], the second in [0, 360).

        Where the direction does not say how far the second axis is turned (theta = 0 or 180 on the reference
        instrument) its reading is the limit for directions nearby. Raises UsageError for a chain or a direction that it
        cannot invert.
        """
        first, second = self._pair(self._sample, "sample")
        on_axis = abs(abs(float(second @ unit_from_angles_deg(theta_deg, phi_deg))) - 1.0) < _DEGENERATE
        inwards = 1e-3 if theta_deg < 90.0 else -1e-3
        candidates = self._sample_solutions(first, second, theta_deg + (inwards if on_axis else 0.0), phi_deg)
        usable = [(q1, q2) for q1, q2 in candidates if np.isfinite(q1)]
        if not usable:
            raise UsageError(
                f"incident direction ({theta_deg:g}, {phi_deg:g}): the sample axes cannot turn the sample that far; "
                "plan a direction that they reach"
            )
        q1, q2 = max(usable, key=lambda pair: (pair[0] >= -_DEGENERATE, -abs(pair[0])))
        if on_axis:
            exact = [q for q, _ in self._sample_solutions(first, second, theta_deg, phi_deg)]
            q1 = min((q + turn for q in exact for turn in (-360.0, 0.0, 360.0)), key=lambda q: abs(q - q1))
        return (0.0 if abs(q1) < _DEGENERATE else q1), (0.0 if 360.0 - q2 % 360.0 < _DEGENERATE else q2 % 360.0)

    def arm_for_outgoing(self, q1_deg: float, q2_deg: float, outgoing: ArrayLike) -> FloatArray:
        """Readings (n, 2) in degrees of the two detector axes that look from `outgoing` (n, 3, sample frame) when the
        sample axes stand at q1, q2: the solution with the smaller second angle, the first in (-180, 180].

        NaN where the arm cannot look. Raises UsageError for a chain that it cannot invert.
        """
        first, second = self._pair(self._detector, "detector")
        self._pair(self._sample, "sample")
        directions = np.atleast_2d(np.asarray(outgoing, dtype=np.float64))
        q_deg = np.zeros((directions.shape[0], self.axis_count))
        q_deg[:, self._sample] = (q1_deg, q2_deg)
        end = self.to_lab(q_deg, directions).T
        start = np.repeat(SOURCE_LAB[:, None], end.shape[1], axis=1)
        one, other = (np.degrees(s) for s in _two_turns(first, second, start, end))
        arm = np.where(np.abs(one[1]) <= np.abs(other[1]), one, other).T
        arm[:, 0] = np.where(arm[:, 0] <= -180.0, arm[:, 0] + 360.0, arm[:, 0])
        return np.ascontiguousarray(arm)

    def _sample_solutions(
        self, first: FloatArray, second: FloatArray, theta_deg: float, phi_deg: float
    ) -> list[tuple[float, float]]:
        # In the sample frame the source is R(second, -q2) R(first, -q1) source.
        incident = unit_from_angles_deg(theta_deg, phi_deg)
        solutions = _two_turns(second, first, SOURCE_LAB[:, None], incident[:, None])
        return [(float(np.degrees(-s[1, 0])), float(np.degrees(-s[0, 0]))) for s in solutions]

    def _pair(self, numbers: list[int], what: str) -> tuple[FloatArray, FloatArray]:
        if len(numbers) != 2:
            raise UsageError(f"the {what} has {len(numbers)} axes: planning needs two; drive the axes directly instead")
        first, second = (self._vectors[n] for n in numbers)
        if np.linalg.norm(np.cross(first, second)) < 1e-6:
            raise UsageError(f"both {what} axes turn about one line: planning needs two; check `vector`")
        return first, second

    def _cos_sin(self, q_deg: ArrayLike) -> tuple[FloatArray, FloatArray]:
        q_rad = np.radians(np.atleast_2d(np.asarray(q_deg, dtype=np.float64)).T)
        if q_rad.shape[0] != self.axis_count:
            raise ValueError(f"readings of {q_rad.shape[0]} axes for an instrument of {self.axis_count}")
        return np.cos(q_rad), np.sin(q_rad)

    def _detector_lab(self, cos: FloatArray, sin: FloatArray) -> FloatArray:
        v = np.repeat(SOURCE_LAB[:, None], cos.shape[1], axis=1)
        for number in reversed(self._detector):
            v = _rotate(v, self._vectors[number], cos[number], sin[number])
        return v
