"""asking.py: BSDF and DSF of any model or file in given directions, with their origin, or why there is none."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Bsdf, FloatArray, IndexArray, Origin, Scattering
from gonio.formats.tables.csv_write import HORIZON_DEG
from gonio.units.errors import UsageError


class Reason(IntEnum):
    """Why there is no BSDF."""

    NONE = 0  # there is one
    ABSENT = 1
    OUTSIDE = 2
    HORIZON = 3


REASONS = {
    Reason.NONE: "",
    Reason.ABSENT: "this pair of hemispheres was not measured",
    Reason.OUTSIDE: "outside what was measured",
    Reason.HORIZON: "at the horizon the BSDF of a DSF is not defined",
}
_HORIZON_COSINE = float(np.sin(np.radians(HORIZON_DEG)))


@runtime_checkable
class HasBsdf(Protocol):
    """A Scattering whose BSDF is defined at grazing too: files of cells, where DSF = BSDF |cos| is 0."""

    def bsdf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """BSDF [1/sr] (m,); arguments as in Scattering."""
        ...


@dataclass(frozen=True)
class Answers:
    """Arrays (m,): BSDF and DSF [1/sr], NaN where there is none; Origin; Reason why there is no BSDF."""

    bsdf_per_sr: FloatArray
    dsf_per_sr: FloatArray
    origin: NDArray[np.uint8]
    reason: NDArray[np.uint8]


def ask(scattering: Scattering, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> Answers:
    """Arguments as in Scattering. Within HORIZON_DEG of grazing a point model has a DSF and no BSDF; a file of cells
    has its cell's value."""
    dsf = np.asarray(scattering.dsf_per_sr(incident, outgoing, which), dtype=np.float64)
    origin = np.asarray(scattering.origin(incident, outgoing, which), dtype=np.uint8)
    cosine = np.abs(outgoing[:, 2])
    grazing = cosine < _HORIZON_COSINE
    bsdf = np.full(len(dsf), np.nan)
    np.divide(dsf, cosine, out=bsdf, where=~grazing)
    if grazing.any() and isinstance(scattering, HasBsdf):
        of_grazing = np.flatnonzero(grazing)
        rows = None if which is None else which[of_grazing]
        bsdf[of_grazing] = scattering.bsdf_per_sr(incident, outgoing[of_grazing], rows)
    origin = np.where(np.isfinite(dsf), origin, np.uint8(Origin.ABSENT))
    return Answers(bsdf, dsf, origin, _reasons(scattering, incident, outgoing, which, dsf, bsdf))


def _reasons(
    scattering: Scattering,
    incident: FloatArray,
    outgoing: FloatArray,
    which: IndexArray | None,
    dsf: FloatArray,
    bsdf: FloatArray,
) -> NDArray[np.uint8]:
    reason = np.full(len(dsf), Reason.NONE, dtype=np.uint8)
    reason[np.isnan(bsdf)] = Reason.HORIZON
    lost = np.isnan(dsf)
    if lost.any():
        reason[lost] = Reason.OUTSIDE
        lit = (incident[:, 2] >= 0.0)[np.zeros(len(dsf), dtype=np.int64) if which is None else which]
        leaves = outgoing[:, 2] >= 0.0
        for lit_front in (True, False):
            for to_front in (True, False):
                if not scattering.covers(incident_front=lit_front, outgoing_front=to_front):
                    reason[lost & (lit == lit_front) & (leaves == to_front)] = Reason.ABSENT
    return reason


def channel_of(bsdf: Bsdf, name: str | None, source: str) -> str:
    """The channel of that name, or by default "visible" or the only one. UsageError names those that there are."""
    present = ", ".join(bsdf.channels)
    if name is not None:
        if name not in bsdf.channels:
            raise UsageError(f"{source}: no channel {name[:60]!r}; it has {present}")
        return name
    if "visible" in bsdf.channels:
        return "visible"
    if len(bsdf.channels) == 1:
        return next(iter(bsdf.channels))
    raise UsageError(f"{source}: has the channels {present}: name one with --channel")
