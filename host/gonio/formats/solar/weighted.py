"""weighted.py: a weighted mean of channels as one channel more: the solar one."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Bsdf, Features, FloatArray, IndexArray, MeasuredIntegral, Scattering
from gonio.formats.solar.weights import SolarWeights, bands_of, solar_weights
from gonio.units.errors import UsageError

SOLAR = "solar"


@dataclass(frozen=True)
class Weighted:
    """Sum of weight times Scattering; there is a value where all parts have one."""

    parts: tuple[tuple[float, Scattering], ...]

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        result = np.zeros(len(outgoing))
        for weight, part in self.parts:
            result += weight * part.dsf_per_sr(incident, outgoing, which)
        return result

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering; of each value the part that rests least on measurements."""
        every = [part.origin(incident, outgoing, which) for _, part in self.parts]
        return np.asarray(np.max(every, axis=0), dtype=np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return all(p.covers(incident_front=incident_front, outgoing_front=outgoing_front) for _, p in self.parts)

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        found = [part.features(incident) for _, part in self.parts]
        return Features(
            np.concatenate([f.centre for f in found]),
            np.concatenate([f.sigma_rad for f in found]),
            np.concatenate([f.incident for f in found]),
        )


def with_solar(
    bsdf: Bsdf, spectrum: str, given: Mapping[str, tuple[float, float]] | None = None
) -> tuple[Bsdf, SolarWeights]:
    """The sample with the channel `solar` more. `given`: bands [nm] of channels, before what is known of them.

    UsageError where there is a solar channel already and where the bands do not do (weights.py).
    """
    if any(name.lower() == SOLAR for name in bsdf.channels):
        raise UsageError("there is a channel solar already: leave --solar-spectrum away, or choose others by --channel")
    weights = solar_weights(spectrum, bands_of(bsdf, given or {}))
    solar = Weighted(tuple((weight, bsdf.channels[name]) for name, weight in weights.weight.items()))
    return replace(
        bsdf,
        channels={**bsdf.channels, SOLAR: solar},
        measured=(*bsdf.measured, *_measured(bsdf.measured, weights)),
        provenance={
            **bsdf.provenance,
            "solar": {
                "spectrum": weights.spectrum,
                "weights": weights.weight,
                "bands_nm": {name: list(band) for name, band in weights.band_nm.items()},
                "uncovered": weights.uncovered,
            },
        },
    ), weights


def _measured(measured: tuple[MeasuredIntegral, ...], weights: SolarWeights) -> list[MeasuredIntegral]:
    """Weighted integrals of incident directions in which all channels were measured. The channels share the instrument:
    their uncertainties are added, not their squares."""
    groups: dict[tuple[float, float, bool], dict[str, MeasuredIntegral]] = {}
    for m in measured:
        groups.setdefault((m.incident_theta_deg, m.incident_phi_deg, m.reflection), {})[m.channel] = m
    found = []
    for (theta, phi, reflection), own in groups.items():
        if all(name in own for name in weights.weight):
            value = sum(w * own[name].value for name, w in weights.weight.items())
            u = sum(w * own[name].u for name, w in weights.weight.items())
            found.append(MeasuredIntegral(SOLAR, theta, phi, reflection, value, u))
    return found
