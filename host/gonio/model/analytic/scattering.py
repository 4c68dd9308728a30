"""scattering.py: one channel of a sample whose components are closed forms; a Scattering (dataset/scattering.py)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin
from gonio.model.analytic.component import Component
from gonio.model.hemisphere import folded

KIND = "analytic"
Sides = tuple[bool, bool]  # light arrives at the front, light leaves from the front
_WORDS = {True: "front", False: "back"}


@dataclass(frozen=True)
class AnalyticScattering:
    """Components by sides. `theta_range_deg`: incident polar angles, from the normal of the light's side, within which
    the parameters were fitted; beyond, they are extrapolated."""

    components: dict[Sides, Component]
    theta_range_deg: tuple[float, float] = (0.0, 90.0)

    def __post_init__(self) -> None:
        for (arrives, leaves), component in self.components.items():
            if (component.process == "reflection") != (arrives == leaves):
                raise ValueError(f"{component.process} cannot be {_WORDS[arrives]} to {_WORDS[leaves]}")

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        """See Scattering."""
        result = np.full(len(outgoing), np.nan)
        for component, inside, rows, own in self._parts(incident, outgoing, which):
            result[inside] = component.dsf_per_sr(folded(incident[rows]), folded(outgoing[inside]), own)
        return result

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        """See Scattering. Nothing is MEASURED: a closed form stands in for every measured value."""
        result = np.full(len(outgoing), Origin.ABSENT, dtype=np.uint8)
        theta = np.degrees(np.arctan2(np.hypot(incident[:, 0], incident[:, 1]), np.abs(incident[:, 2])))
        highest = self.theta_range_deg[1]  # below the lowest: known as an even function of theta is
        known = np.where(theta <= highest + 1e-6, Origin.INTERPOLATED, Origin.EXTRAPOLATED)
        for _, inside, rows, own in self._parts(incident, outgoing, which):
            result[inside] = known[rows][own]
        return result

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        """See Scattering."""
        return (incident_front, outgoing_front) in self.components

    def features(self, incident: FloatArray) -> Features:
        """See Scattering."""
        centres, sigmas, rows_of = [np.zeros((0, 3))], [np.zeros(0)], [np.zeros(0, dtype=np.int64)]
        front = incident[:, 2] >= 0.0
        for (arrives, leaves), component in self.components.items():
            rows = np.flatnonzero(front == arrives)
            found = component.features(folded(incident[rows]))
            centres.append(found.centre * np.array([1.0, 1.0, 1.0 if leaves else -1.0]))
            sigmas.append(found.sigma_rad)
            rows_of.append(rows[found.incident])
        return Features(np.concatenate(centres), np.concatenate(sigmas), np.concatenate(rows_of))

    def _parts(
        self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None
    ) -> Iterator[tuple[Component, IndexArray, IndexArray, IndexArray]]:
        """Per component that is asked for: it, the outgoing rows, the incident rows in use, and theirs of each."""
        of = np.zeros(len(outgoing), dtype=np.int64) if which is None else np.asarray(which)
        front_i, front_o = incident[:, 2] >= 0.0, outgoing[:, 2] >= 0.0
        for (arrives, leaves), component in self.components.items():
            inside = np.flatnonzero((front_i[of] == arrives) & (front_o == leaves))
            if len(inside):
                used = np.bincount(of[inside], minlength=len(incident)) > 0
                place = np.cumsum(used) - 1  # of an incident row among those in use
                yield component, inside, np.flatnonzero(used), place[of[inside]]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; `kind` tells what it is."""
        return {
            "kind": KIND,
            "theta_range_deg": list(self.theta_range_deg),
            "components": [
                {"arrives": _WORDS[arrives], "leaves": _WORDS[leaves], **component.to_json()}
                for (arrives, leaves), component in sorted(self.components.items(), reverse=True)
            ],
        }

    @staticmethod
    def from_json(stored: dict[str, Any]) -> "AnalyticScattering":
        """Inverse of `to_json`. Raises UsageError or what Python raises for values of another shape."""
        if stored.get("kind") != KIND:
            raise ValueError(f"kind is {stored.get('kind')!r}, not {KIND!r}")
        components = {
            (part["arrives"] == "front", part["leaves"] == "front"): Component.from_json(part)
            for part in stored["components"]
        }
        low, high = stored["theta_range_deg"]
        return AnalyticScattering(components, (float(low), float(high)))
