"""band.py: a wavelength, or a band with weights, and the mean of a spectrum over it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Band:
    """From and to [nm], equal for one wavelength. Weights (w,) at wavelengths (w,), linear between; None: flat."""

    from_nm: float
    to_nm: float
    weight_nm: FloatArray | None = None
    weight: FloatArray | None = None
    name: str = ""

    @staticmethod
    def at(wavelength_nm: float) -> "Band":
        """One wavelength."""
        return Band(wavelength_nm, wavelength_nm, name=f"{wavelength_nm:g} nm")

    @staticmethod
    def visible() -> "Band":
        """380 to 780 nm by the eye's sensitivity: the two-lobe fit of the CIE 1931 y curve by Wyman, Sloan and Shirley
        (Journal of Computer Graphics Techniques 2 (2), 2013), within 0.01 of the table; equal energy."""
        nm = np.arange(380.0, 781.0, 5.0)
        first = (nm - 568.8) * np.where(nm < 568.8, 0.0213, 0.0247)
        second = (nm - 530.9) * np.where(nm < 530.9, 0.0613, 0.0322)
        y = 0.821 * np.exp(-0.5 * first**2) + 0.286 * np.exp(-0.5 * second**2)
        return Band(380.0, 780.0, nm, y, "380-780 nm, CIE 1931 y")

    @staticmethod
    def flat(from_nm: float, to_nm: float) -> "Band":
        """All wavelengths alike."""
        return Band(from_nm, to_nm, name=f"{from_nm:g}-{to_nm:g} nm, flat")


def weighted_mean(wavelength_nm: FloatArray, values: FloatArray, band: Band, name: str) -> float:
    """Mean of a spectrum, linear between its points, over a band; NaN points are left out. Raises UsageError where the
    band reaches more than 1 % beyond what was measured (a spectrum that is known to 779 nm serves 380 to 780)."""
    known = np.isfinite(values)
    nm, y = wavelength_nm[known], values[known]
    margin = max(0.01 * (band.to_nm - band.from_nm), 1e-6)
    if not len(nm) or band.from_nm < nm[0] - margin or band.to_nm > nm[-1] + margin:
        has = f"{nm[0]:g} to {nm[-1]:g} nm" if len(nm) else "nothing"
        raise UsageError(
            f"{name}: {band.name or 'the band'} is asked for and the file has {has}: give a spectrum of it"
        )
    if band.to_nm == band.from_nm:
        return float(np.interp(band.from_nm, nm, y))
    parts = [nm, np.array([band.from_nm, band.to_nm])]
    if band.weight_nm is not None:
        parts.append(band.weight_nm)
    grid = np.unique(np.concatenate(parts))
    grid = grid[(grid >= band.from_nm) & (grid <= band.to_nm)]
    weight = np.ones(len(grid))
    if band.weight_nm is not None and band.weight is not None:
        weight = np.interp(grid, band.weight_nm, band.weight, left=0.0, right=0.0)
    value = np.interp(grid, nm, y)
    step = np.diff(grid)
    # Products of two linear pieces, integrated exactly.
    a, b, c, d = weight[:-1], weight[1:], value[:-1], value[1:]
    above = float(np.sum(step * (2.0 * a * c + 2.0 * b * d + a * d + b * c)) / 6.0)
    return above / float(np.sum(step * (a + b)) / 2.0)
