"""turns.py: about which line each axis turns, seen from the sample: the exact derivative of every direction."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.kinematics import AxisGeometry

FloatArray = NDArray[np.float64]


class Turns:
    """The turn vectors of an instrument's axes while its sample stands still.

    From lab <- sample = product of the sample's turns, and detector in the lab = product of the detector's turns of +Z:
    the derivative of a turn about `a` is a x (.), carried along by the turns outside it.
    """

    def __init__(self, axes: Sequence[AxisGeometry], still_deg: FloatArray) -> None:
        """`still_deg` (axes,): readings of all axes; those that carry the detector do not matter."""
        vectors = [np.asarray(axis.vector, dtype=np.float64) for axis in axes]
        self._vectors = [vector / np.linalg.norm(vector) for vector in vectors]
        self._of_sample: dict[int, FloatArray] = {}
        self._to_sample = np.eye(3)
        for number in reversed(range(len(axes))):
            if axes[number].carries == "sample":
                # The later turns are undone after this one: they stand outside it.
                self._of_sample[number] = -self._to_sample @ self._vectors[number]
                undone = rotation(self._vectors[number], -float(np.radians(still_deg[number])))
                self._to_sample = self._to_sample @ undone

    def at(self, q_rad: FloatArray) -> list[FloatArray]:
        """Per axis the vector w (3, 1) or (3, n), sample frame, with d(direction)/dq = w x direction [1/rad] at the
        readings (axes, n): for the incident and the outgoing direction alike where the axis carries the sample, for
        the outgoing one alone where it carries the detector."""
        turns: list[FloatArray] = []
        outside: list[int] = []
        for number, vector in enumerate(self._vectors):
            if number in self._of_sample:
                turns.append(self._of_sample[number][:, None])
                continue
            in_lab = vector[:, None]
            for carrier in reversed(outside):
                in_lab = rotated(in_lab, self._vectors[carrier], q_rad[carrier])
            outside.append(number)
            turns.append(self._to_sample @ in_lab)
        return turns


def rotation(axis: FloatArray, angle_rad: float) -> FloatArray:
    """Matrix (3, 3) of the turn about a unit vector (3,) (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle_rad) * cross + (1.0 - np.cos(angle_rad)) * cross @ cross)


def rotated(v: FloatArray, axis: FloatArray, angle_rad: FloatArray) -> FloatArray:
    """Vectors (3, 1) or (3, n) turned about a unit vector (3,) by angles (n,); shape (3, n)."""
    x, y, z = axis
    along = axis[:, None] * (axis @ v)
    across = np.stack((y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]))
    return np.asarray(along + np.cos(angle_rad) * (v - along) + np.sin(angle_rad) * across)
