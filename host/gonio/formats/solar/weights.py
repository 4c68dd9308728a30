"""weights.py: shares of the sun's power that a sample's channels stand for."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from gonio.dataset.scattering import Bsdf
from gonio.formats.solar.spectra import spectrum_named
from gonio.units.errors import UsageError

# What a channel's name says of its band [nm], where nothing else does.
_NAMED_BANDS_NM = {
    "visible": (380.0, 780.0),
    "vis": (380.0, 780.0),
    "photopic": (380.0, 780.0),
    "near-infrared": (780.0, 2500.0),
    "nir": (780.0, 2500.0),
    "ultraviolet": (280.0, 380.0),
    "uv": (280.0, 380.0),
}
_RANGE = re.compile(r"(\d+(?:\.\d+)?)\s*-\s*(\d+(?:\.\d+)?)(?:\s*nm)?", re.IGNORECASE)
_LEAST_OF_ONE = 0.9  # share of the sun that a single channel must see: less is a copy, which only --assume-flat allows


@dataclass(frozen=True)
class SolarWeights:
    """Weights by channel, sum 1: the share of the covered part of the spectrum; `uncovered`: the rest of the whole."""

    spectrum: str  # its name in words
    weight: dict[str, float]
    band_nm: dict[str, tuple[float, float]]
    uncovered: float

    def sentence(self) -> str:
        """For <Comments> and the report."""
        parts = [f"{name} {low:g}-{high:g} nm {self.weight[name]:.4f}" for name, (low, high) in self.band_nm.items()]
        return (
            f"Solar: mean of the channels, weighted by {self.spectrum}: {', '.join(parts)}; "
            f"{100.0 * self.uncovered:.1f} % of the spectrum lies in no channel's band."
        )


def range_nm(text: str) -> tuple[float, float] | None:
    """Band that a text like "380-780" or "380-780 nm" states; None for any other text."""
    found = _RANGE.fullmatch(text.strip())
    return None if found is None else (float(found[1]), float(found[2]))


def bands_of(bsdf: Bsdf, given: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Band [nm] of every channel of which one is known: as given, else as the dataset states it, else by its name.

    UsageError for a channel that is not there, and where all that is known are single wavelengths."""
    for name in given:
        if name not in bsdf.channels:
            raise UsageError(f"--solar-band: no channel {name!r}; there is {', '.join(bsdf.channels)}")
    found = {}
    single = []
    for name in bsdf.channels:
        stated = bsdf.band_nm.get(name)
        wide = stated if stated is not None and stated[1] > stated[0] else None
        band = given.get(name) or wide or range_nm(name) or _NAMED_BANDS_NM.get(name.lower())
        if band is not None:
            found[name] = band
        elif stated is not None:
            single.append(name)
    if single and not found:
        raise UsageError(
            f"{', '.join(single)}: of one wavelength each: say which part of the sun each stands for, for every one "
            f"--solar-band '{single[0]}=FROM-TO' in nm"
        )
    return found


def solar_weights(spectrum: str, bands: Mapping[str, tuple[float, float]]) -> SolarWeights:
    """Weights of channels by their bands [nm]; `spectrum`: see spectrum_named.

    UsageError for no band at all, bands that overlap or are empty, and for a single channel that sees only part of the
    sun.
    """
    table = spectrum_named(spectrum)
    order = sorted(bands, key=lambda name: bands[name])
    if not order:
        raise UsageError("no channel's band of wavelengths is known: give --solar-band CHANNEL=FROM-TO in nm")
    for name in order:
        if not bands[name][1] > bands[name][0]:
            raise UsageError(f"channel {name}: band {bands[name][0]:g}-{bands[name][1]:g} nm is empty")
    for name, following in pairwise(order):
        if bands[following][0] < bands[name][1]:
            raise UsageError(
                f"bands of {name} and {following} overlap: state them apart with --solar-band CHANNEL=FROM-TO"
            )
    share = {name: table.between(*bands[name]) for name in order}
    covered = sum(share.values())
    if not covered > 0.0:
        raise UsageError(f"no channel's band holds any of the spectrum {spectrum}")
    if len(order) == 1 and covered < _LEAST_OF_ONE:
        raise UsageError(
            f"only channel {order[0]} has a band, {100 * covered:.0f} % of the sun: name others with --solar-band, or "
            "declare the sample spectrally flat with --assume-flat"
        )
    weight = {name: own / covered for name, own in share.items()}
    return SolarWeights(table.name, weight, {name: bands[name] for name in order}, 1.0 - covered)
