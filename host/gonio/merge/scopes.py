"""scopes.py: which systematic causes stay one when datasets are joined, and which are kept apart by " #SCOPE"."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.effects import effect_of
from gonio.merge.sources import Source

FloatArray = NDArray[np.float64]

# Causes that lie in one detector and its electronics, although they last as long as the instrument: the channels of two
# detectors do not share them.
_OF_DETECTOR = frozenset({"gain_ratio", "linearity", "aperture", "stray_light"})


@dataclass(frozen=True)
class Scopes:
    """What the whole merge holds more than one of; causes are kept apart only along those."""

    sessions: bool
    mounts: bool
    instruments: bool
    channels: bool

    @classmethod
    def of(cls, sources: Sequence[Source]) -> "Scopes":
        """The scopes that `sources` need."""

        def several(values: Iterable[str]) -> bool:
            return len(set(values)) > 1

        return cls(
            sessions=several(s.session for s in sources),
            mounts=several(s.mount for s in sources),
            instruments=several(s.instrument for s in sources),
            channels=several(d.channel for s in sources for d in s.dataset.distributions),
        )

    def key(self, key: str, source: Source, channel: str) -> str:
        """The key of a cause in the merged dataset: as it is where all share it, else with the scope at its end."""
        effect = effect_of(key)
        parts = []
        if effect.reach == "instrument":
            if self.instruments:
                parts.append(hashlib.sha256(source.instrument.encode()).hexdigest()[:8])
            if self.channels and effect.name in _OF_DETECTOR:
                parts.append(re.sub(r"\W+", "-", channel))
        elif effect.reach == "session" and self.sessions:
            parts.append(source.session)
        elif effect.reach == "mount" and self.mounts:
            parts.append(source.mount)
        return f"{key} #{'-'.join(parts)}" if parts else key


def effects_of(distribution: Distribution, source: Source, scopes: Scopes) -> dict[str, FloatArray]:
    """Columns (n,) of a distribution under their keys in the merged dataset.

    Where a distribution states the uncertainty of its P_i but no column for it (imported, simulated), the column is
    made here, so that the points of one session keep that cause in common: the DSF falls as P_i rises.
    """
    columns: Mapping[str, FloatArray] = distribution.effects
    if distribution.p_i_u_rel > 0.0 and "p_i" not in columns:
        columns = {**columns, "p_i": -distribution.p_i_u_rel * distribution.dsf_per_sr}
    return {scopes.key(key, source, distribution.channel): column for key, column in columns.items()}


def own_keys(keys: Iterable[str]) -> list[str]:
    """Those keys that are kept apart by session or mount: what they add to a point, another session's do not share."""
    return [key for key in keys if " #" in key and effect_of(key).reach != "instrument"]
