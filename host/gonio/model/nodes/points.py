"""points.py: a dataset sorted for models: per channel and component the points of each incident direction, folded."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.hemisphere import folded

FloatArray = NDArray[np.float64]

SAME_DEG = 0.1  # incident directions closer than this are one
_LEAST_POINTS = 3  # in a hemisphere; fewer are no distribution
_LEAST_U_REL = 1e-3  # no point counts as better than this: grids and lobes would follow its last digit


@dataclass(frozen=True)
class Component:
    """Light that arrives at one side of the sample and leaves from one side."""

    incident_front: bool
    outgoing_front: bool

    @property
    def reflection(self) -> bool:
        """Whether it leaves where it arrives."""
        return self.incident_front == self.outgoing_front

    @property
    def name(self) -> str:
        """For reports: "front reflection": light arriving at the front."""
        side = "front" if self.incident_front else "back"
        return f"{side} {'reflection' if self.reflection else 'transmission'}"


COMPONENTS = tuple(Component(i, o) for i in (True, False) for o in (True, False))


@dataclass(frozen=True)
class Points:
    """Measured points of one incident direction and component, in the folded frame (hemisphere.py).

    incident (3,); unit (n, 3); dsf_per_sr, variance_per_sr2, solid_angle_sr (n,). rho or tau that the dataset states,
    with its standard uncertainty; NaN where it does not.
    """

    incident: FloatArray
    unit: FloatArray
    dsf_per_sr: FloatArray
    variance_per_sr2: FloatArray
    solid_angle_sr: FloatArray
    stated: float = float("nan")
    stated_u: float = float("nan")

    @property
    def integral(self) -> float:
        """Sum of DSF times solid angle."""
        return float(np.einsum("n,n->", self.dsf_per_sr, self.solid_angle_sr))

    def turned(self, phi_rad: float) -> "Points":
        """Incident and outgoing directions turned by phi about the normal."""
        c, s = np.cos(phi_rad), np.sin(phi_rad)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return replace(self, incident=self.incident @ turn, unit=np.einsum("ni,ij->nj", self.unit, turn))

    def mirrored(self, signs: FloatArray) -> "Points":
        """With x and y of all directions times signs (2,): half a turn or a mirror image."""
        both = np.append(signs, 1.0)
        return replace(self, incident=self.incident * both, unit=self.unit * both)

    def some(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> "Points":
        """Those of a mask, or of rows, with the solid angle of all."""
        sr = self.solid_angle_sr[rows]
        return replace(
            self,
            unit=self.unit[rows],
            dsf_per_sr=self.dsf_per_sr[rows],
            variance_per_sr2=self.variance_per_sr2[rows],
            solid_angle_sr=sr * (self.solid_angle_sr.sum() / sr.sum()),
        )


def points_of(dataset: Dataset, channel: str) -> dict[Component, list[Points]]:
    """Points of all components that were measured; masked ones left out, in the order of the dataset.

    Where the incident direction is stated more than once the points are joined and share their solid angles.
    """
    found: dict[Component, list[Points]] = {}
    for distribution in dataset.distributions:
        if distribution.channel != channel:
            continue
        for component, points in _split(distribution).items():
            found.setdefault(component, []).append(points)
    return {component: joined(found[component]) for component in COMPONENTS if component in found}


def _split(distribution: Distribution) -> dict[Component, Points]:
    d = distribution
    used = d.measured & np.isfinite(d.dsf_per_sr) & (d.solid_angle_sr > 0.0)
    incident = unit_from_angles_deg(d.incident_theta_deg, d.incident_phi_deg)
    columns = (d.theta_deg, d.phi_deg, d.dsf_per_sr, d.variance_per_sr2, d.solid_angle_sr)
    theta_deg, phi_deg, dsf, variance, sr = columns if np.all(used) else [column[used] for column in columns]
    unit = unit_from_angles_deg(theta_deg, phi_deg)
    least = (_LEAST_U_REL * dsf) ** 2 + (1e-6 * np.max(np.abs(dsf), initial=0.0)) ** 2
    variance = np.fmax(variance, least)
    front = theta_deg <= 90.0  # a row of exactly 90 belongs to the front
    result = {}
    for outgoing_front in (True, False):
        rows = front == outgoing_front
        number = int(np.count_nonzero(rows))
        if number < _LEAST_POINTS:
            continue
        component = Component(bool(d.incident_theta_deg <= 90.0), outgoing_front)
        name = "rho" if component.reflection else "tau"
        whole = number == len(rows)
        own = [a if whole else a[rows] for a in (unit, dsf, variance, sr)]
        stated, u = d.integrals.get(f"{name}_measured", np.nan), d.integrals.get(f"{name}_u", np.nan)
        result[component] = Points(
            folded(incident), own[0] if outgoing_front else folded(own[0]), own[1], own[2], own[3], stated, u
        )
    return result


def joined(points: list[Points]) -> list[Points]:
    """Points of incident directions within SAME_DEG put together."""
    result: list[Points] = []
    left = list(points)
    while left:
        first = left.pop(0)
        near = [p for p in left if _angle_deg(p.incident, first.incident) < SAME_DEG]
        left = [p for p in left if _angle_deg(p.incident, first.incident) >= SAME_DEG]
        result.append(_together([first, *near]) if near else first)
    return result


def _together(parts: list[Points]) -> Points:
    return Points(
        parts[0].incident,
        np.concatenate([p.unit for p in parts]),
        np.concatenate([p.dsf_per_sr for p in parts]),
        np.concatenate([p.variance_per_sr2 for p in parts]),
        np.concatenate([p.solid_angle_sr / len(parts) for p in parts]),
        float(np.mean([p.stated for p in parts])),
        float(np.mean([p.stated_u for p in parts])),
    )


def _angle_deg(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees(2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))))
