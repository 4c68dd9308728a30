"""text_numbers.py: numbers in text files: read with the last digit's weight, written so that the digits come back."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_EXACT_DECIMALS = 12  # an angle under 1000 degrees with so many decimals is exact through sums of float64
_LINE_END = re.compile(r"\r\n|\r|\n")


def lines_of(content: bytes) -> list[str]:
    """Lines of a text file with any line ends; UTF-8, or Latin-1 where it is not that."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return _LINE_END.split(text)


def exact_deg(angle_deg: FloatArray) -> FloatArray:
    """Angles after a sum or difference of decimals, put back to the nearest decimal: 180 - 40.123 is 139.877."""
    return np.asarray(np.round(angle_deg, _EXACT_DECIMALS) + 0.0, dtype=np.float64)


def fold_deg(theta_deg: FloatArray, phi_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signed polar angles, or those of a full circle, folded to theta in [0, 180], phi in [0, 360); shapes as given.
    Angles that lie there already stay as they are, to the last bit."""
    theta = np.asarray(theta_deg, dtype=np.float64)
    phi = np.asarray(phi_deg, dtype=np.float64)
    over = np.abs(theta) > 180.0
    other_half = (theta < 0.0) != over
    folded = np.where(over, exact_deg(360.0 - np.abs(theta)), np.abs(theta))
    phi = np.where(other_half, exact_deg(phi + 180.0), phi)
    inside = (phi >= 0.0) & (phi < 360.0)
    turned = exact_deg(np.mod(phi, 360.0))
    return folded, np.where(inside, phi + 0.0, np.where(turned >= 360.0, 0.0, turned))


def cosine(theta_deg: FloatArray) -> FloatArray:
    """|cos theta|, from the angle to the nearer normal: the same float64 before and after a frame is turned about."""
    theta = np.asarray(theta_deg, dtype=np.float64)
    return np.asarray(np.cos(np.radians(np.where(theta > 90.0, exact_deg(180.0 - theta), theta))), dtype=np.float64)


def shortest(values: FloatArray) -> list[str]:
    """The shortest text that reads back as the same float64: what was read with at most 15 digits keeps them. Whole
    numbers without a decimal point."""
    return [text.removesuffix(".0") for text in map(repr, np.asarray(values, dtype=np.float64).tolist())]


def fifteen_digits(values: FloatArray) -> list[str]:
    """The shortest text of at most 15 digits, for what was multiplied and divided again."""
    return [f"{value:.15g}" for value in np.asarray(values, dtype=np.float64).tolist()]


def rounding_variance(text: Sequence[str]) -> FloatArray:
    """Variance of numbers (n,) that were rounded to their last written digit: a twelfth of its weight's square (GUM,
    JCGM 100:2008, 4.3.7). 2.62E-01 has the weight 0.001."""
    if not text:
        return np.zeros(0)
    text = [number.strip() for number in text]
    letters = np.array([number.encode("ascii", "replace") for number in text])
    width = letters.dtype.itemsize
    code = letters.view(np.uint8).reshape(len(text), width)
    length = np.count_nonzero(code, axis=1)
    is_e, is_dot = (code | 32) == ord("e"), code == ord(".")
    has_e = is_e.any(axis=1)
    end = np.where(has_e, np.argmax(is_e, axis=1), length)
    decimals = np.where(is_dot.any(axis=1), end - np.argmax(is_dot, axis=1) - 1, 0)
    exponent = np.zeros(len(text))
    for row in np.flatnonzero(has_e).tolist():
        exponent[row] = float(text[row][int(end[row]) + 1 :])
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(10.0 ** (2.0 * np.clip(exponent - decimals, -400, 400)) / 12.0, dtype=np.float64)
