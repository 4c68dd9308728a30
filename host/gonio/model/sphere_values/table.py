"""table.py: hemispherical values that an integrating sphere measured: spectra per angle and number of layers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gonio.model.sphere_values.band import Band, weighted_mean
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]

Quantity = Literal["tau_total", "tau_diffuse", "rho_total", "rho_diffuse"]
QUANTITIES: tuple[Quantity, ...] = ("tau_total", "tau_diffuse", "rho_total", "rho_diffuse")
SideOfLight = Literal["front", "back"]


@dataclass(frozen=True)
class SphereSpectrum:
    """One measurement: wavelength_nm (n,), ascending; per quantity values (n,), NaN where it was not measured; u (n,):
    standard uncertainty of every value, NaN where the file states none."""

    theta_i_deg: float
    layers: int
    side: SideOfLight
    wavelength_nm: FloatArray
    values: dict[Quantity, FloatArray]
    u: FloatArray


@dataclass(frozen=True)
class SphereRow:
    """A value at one incident angle and its standard uncertainty (NaN: not stated)."""

    theta_i_deg: float
    value: float
    u: float


@dataclass(frozen=True)
class SphereValues:
    """All spectra of a file."""

    spectra: tuple[SphereSpectrum, ...]
    name: str

    def rows(
        self, quantity: Quantity, band: Band, *, side: SideOfLight = "front", layers: int = 1
    ) -> tuple[SphereRow, ...]:
        """The quantity by incident angle, ascending, at a wavelength or as the mean over a band; angles at which it was
        not measured are left out. Raises UsageError where a band reaches beyond the spectrum."""
        found = []
        for spectrum in self.spectra:
            values = spectrum.values[quantity]
            if spectrum.side != side or spectrum.layers != layers or not np.isfinite(values).any():
                continue
            value = weighted_mean(spectrum.wavelength_nm, values, band, self.name)
            known = np.isfinite(spectrum.u)
            # Errors of a spectrum's neighbours are mostly shared (baseline, port): the mean keeps their size.
            u = weighted_mean(spectrum.wavelength_nm, spectrum.u, band, self.name) if known.all() else float("nan")
            found.append(SphereRow(spectrum.theta_i_deg, value, u))
        return tuple(sorted(found, key=lambda row: row.theta_i_deg))

    def by_layers(self, quantity: Quantity, band: Band, side: SideOfLight = "front") -> dict[int, float]:
        """The quantity nearest to normal incidence by number of layers."""
        found = {}
        for layers in sorted({spectrum.layers for spectrum in self.spectra}):
            rows = self.rows(quantity, band, side=side, layers=layers)
            if rows:
                found[layers] = rows[0].value
        return found

    def openness(self, band: Band, side: SideOfLight = "front") -> float:
        """Direct transmittance, total less diffuse, of one layer at the angle nearest to normal incidence; what the
        sphere's port lets out with the beam, some degrees of scattering, is in it. Raises UsageError where total and
        diffuse transmittance were not both measured there, or that angle is beyond 10 degrees."""
        total = self.rows("tau_total", band, side=side)
        diffuse = {row.theta_i_deg: row.value for row in self.rows("tau_diffuse", band, side=side)}
        both = [row for row in total if row.theta_i_deg in diffuse]
        if not both or both[0].theta_i_deg > 10.0:
            raise UsageError(
                f"{self.name}: openness is tau_total less tau_diffuse of one layer near normal incidence, and the file "
                "does not have both"
            )
        return both[0].value - diffuse[both[0].theta_i_deg]


def sorted_spectra(spectra: Sequence[SphereSpectrum]) -> tuple[SphereSpectrum, ...]:
    """By side, layers and angle."""
    return tuple(sorted(spectra, key=lambda s: (s.side != "front", s.layers, s.theta_i_deg)))
