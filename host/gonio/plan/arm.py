"""arm.py: a track on the sphere as a curve of the detector axes: readings and derivatives by the track's length."""

from dataclasses import dataclass

import numpy as np

from gonio.geometry.directions import angles_deg_from_unit
from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import FloatArray
from gonio.plan.limits import reasons_out_of_reach
from gonio.plan.spiral import SphereTrack
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument


@dataclass(frozen=True)
class AxisCurve:
    """Readings (n, axes) in degrees along a track of length (n,), with first and second derivatives by that length."""

    length_deg: FloatArray
    q_deg: FloatArray
    d_q: FloatArray
    dd_q: FloatArray


def axis_numbers(instrument: Instrument, carries: str) -> tuple[int, int]:
    """Indices of the two axes that carry the "sample" or the "detector"; UsageError if there are not two."""
    found = [i for i, axis in enumerate(instrument.axes) if axis.carries == carries]
    if len(found) != 2:
        raise UsageError(f"the {carries} has {len(found)} axes: planning needs two")
    return found[0], found[1]


def readings(
    instrument: Instrument, sample_deg: tuple[float, float], first_deg: FloatArray, second_deg: FloatArray
) -> FloatArray:
    """Readings (n, axes) with the sample axes at `sample_deg` and the detector axes at these angles (n,)."""
    q = np.empty((len(first_deg), len(instrument.axes)))
    q[:, axis_numbers(instrument, "sample")] = sample_deg
    first, second = axis_numbers(instrument, "detector")
    q[:, first], q[:, second] = first_deg, second_deg
    return q


def _turned(vector: FloatArray, axis: FloatArray, angle_rad: FloatArray) -> FloatArray:
    """A vector (3,) turned about a unit vector by angles (n,): (n, 3) (Rodrigues' formula)."""
    cos, sin = np.cos(angle_rad)[:, None], np.sin(angle_rad)[:, None]
    return vector * cos + np.cross(axis, vector) * sin + axis * (axis @ vector) * (1.0 - cos)


def _solve(one: FloatArray, two: FloatArray, right: FloatArray) -> FloatArray:
    """(n, 2) with one x0 + two x1 = right for vectors (n, 3), by normal equations (right lies in their plane)."""
    a, b, c = (one * one).sum(1), (one * two).sum(1), (two * two).sum(1)
    p, q = (one * right).sum(1), (two * right).sum(1)
    determinant = a * c - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack(((c * p - b * q) / determinant, (a * q - b * p) / determinant), axis=1)


def fit_to_wrap(reading_deg: FloatArray, low_deg: float, high_deg: float) -> FloatArray:
    """A continuous reading shifted by whole turns so that it lies within the limits if it can."""
    middle = 0.5 * (reading_deg.min() + reading_deg.max())
    shift = 360.0 * np.rint((0.5 * (low_deg + high_deg) - middle) / 360.0)
    inside = reading_deg.min() >= low_deg and reading_deg.max() <= high_deg
    return reading_deg if inside else reading_deg + shift


def follow(track: SphereTrack, sample_deg: tuple[float, float], instrument: Instrument, where: str) -> AxisCurve:
    """The detector axes along a track given in the sample frame, with the sample axes at `sample_deg`.

    With d the detector's direction and w3, w4 the axes' vectors in the lab, d' = (w3 q3' + w4 q4') x d; differentiated
    once more for the second derivative. Raises UsageError, with direction and limit, where the arm cannot look.
    """
    kinematics = Kinematics(instrument.axes)
    first, second = axis_numbers(instrument, "detector")
    arm = kinematics.arm_for_outgoing(*sample_deg, track.unit)
    low, high = instrument.axes[first].min_deg, instrument.axes[first].max_deg
    q = readings(instrument, sample_deg, fit_to_wrap(np.unwrap(arm[:, 0], period=360.0), low, high), arm[:, 1])
    for row, reason in enumerate(reasons_out_of_reach(q, instrument)):
        if reason is not None:
            theta, phi = angles_deg_from_unit(track.unit[row])
            raise UsageError(f"{where}: outgoing direction ({theta:.1f}, {phi:.1f}) is out of reach: {reason}")

    d, d_s, d_ss = (kinematics.to_lab(q, v) for v in (track.unit, track.d_unit, track.dd_unit))
    w3 = np.asarray(instrument.axes[first].vector) / np.linalg.norm(instrument.axes[first].vector)
    w4_zero = np.asarray(instrument.axes[second].vector) / np.linalg.norm(instrument.axes[second].vector)
    w4 = _turned(w4_zero, w3, np.radians(q[:, first]))
    by_first, by_second = np.cross(w3, d), np.cross(w4, d)
    rate = _solve(by_first, by_second, d_s)  # radians per degree of length
    turning = w3 * rate[:, :1] + w4 * rate[:, 1:]
    bend = np.cross(np.cross(w3, w4) * (rate[:, :1] * rate[:, 1:]), d) + np.cross(turning, d_s)
    d_rate = _solve(by_first, by_second, d_ss - bend)
    d_q, dd_q = np.zeros_like(q), np.zeros_like(q)
    d_q[:, [first, second]] = np.degrees(rate)
    dd_q[:, [first, second]] = np.degrees(d_rate)
    return AxisCurve(track.length_deg, q, d_q, dd_q)
