"""features.py: how a distribution moves on the sphere when the incident direction does."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg

FloatArray = NDArray[np.float64]

# Within about REACH of an ideal direction the distribution is taken to follow it; a diffuse one, far away, stays.
REACH_DEG = 30.0
# Two ideal directions share what lies between them smoothly; each has its own within this.
_OWN_DEG = 2.0
# Where mirror and retro direction are nearer to each other than this, what is there is taken for a mirror's.
_RETRO_APART_DEG = 10.0
_NEIGHBOURS = 20
_NEAR_DEG = 5.0


@dataclass(frozen=True)
class Followed:
    """For one incident direction: the ideal directions (mirror, retro, straight through), and how each of them turns
    its surroundings, as a matrix by which the turn of the incident direction is multiplied. `retro_weight` 0: nothing
    follows the retro direction."""

    feature: FloatArray  # (3, 3): one a row
    matrix: FloatArray  # (3, 3, 3)
    retro_weight: float

    @classmethod
    def of(cls, incident_theta_deg: float, incident_phi_deg: float, retro_weight: float) -> "Followed":
        """The incident direction i moves by w x i, so the mirror direction m = 2 (n.i) n - i by (2 n n^T - 1)(w x i),
        straight through by -(w x i); each takes its surroundings along by the smallest turn, f x df."""
        incident = unit_from_angles_deg(incident_theta_deg, incident_phi_deg)
        reflect = np.diag([-1.0, -1.0, 1.0])
        moves = -_cross(incident)
        ways = (reflect, np.eye(3), -np.eye(3))
        return cls(
            np.stack([way @ incident for way in ways]),
            np.stack([_cross(way @ incident) @ way @ moves for way in ways]),
            retro_weight,
        )

    def share(self, unit: FloatArray) -> FloatArray:
        """Shares (3, n) of the ideal directions in what the points `unit` (3, n) follow; their sum, at most 1, falls
        away from all of them."""
        chord2 = np.maximum(2.0 - 2.0 * (self.feature @ unit), 0.0)
        nearness = 1.0 / (chord2 + np.radians(_OWN_DEG) ** 2) ** 2
        nearness[1] *= self.retro_weight
        reach = 1.0 / (1.0 + (chord2.min(axis=0) / np.radians(REACH_DEG) ** 2) ** 2)
        return np.asarray(nearness * (reach / nearness.sum(axis=0)))

    def turn(self, share: FloatArray, of_incident: FloatArray) -> FloatArray:
        """Turn vectors (3, n) of the distribution, with shares (3, n), for the incident direction's turn (3,)."""
        return np.asarray((self.matrix @ of_incident).T @ share)


def retro_weight(unit: FloatArray, dsf_per_sr: FloatArray, incident_theta_deg: float, incident_phi_deg: float) -> float:
    """How much the distribution (n,) at directions (n, 3) shows of a peak at the retro direction, 0 to 1.

    A lobe about the mirror direction m is there, too, when incidence is near normal; but then it is as high on the
    other side of m. What the retro direction has more than that side is its own. Where that side cannot be seen the
    angle between both decides.
    """
    incident = unit_from_angles_deg(incident_theta_deg, incident_phi_deg)
    mirror = np.array([-incident[0], -incident[1], incident[2]])
    apart_deg = 2.0 * min(incident_theta_deg, 180.0 - incident_theta_deg)
    by_angle = float(1.0 - np.exp(-((apart_deg / _RETRO_APART_DEG) ** 2)))
    retro, other = (_value_at(unit, dsf_per_sr, v) for v in (incident, 2.0 * (mirror @ incident) * mirror - incident))
    if retro is None or other is None:
        return by_angle
    return by_angle * float(np.clip((retro - other) / max(abs(retro) + abs(other), 1e-300), 0.0, 1.0))


def _value_at(unit: FloatArray, dsf_per_sr: FloatArray, direction: FloatArray) -> float | None:
    """Median of the points nearest to a direction; None where they are far."""
    cosine = np.where(np.isnan(dsf_per_sr), -2.0, unit @ direction)
    near = np.argpartition(cosine, -_NEIGHBOURS)[-_NEIGHBOURS:] if len(cosine) > _NEIGHBOURS else np.arange(len(cosine))
    near = near[cosine[near] > np.cos(np.radians(_NEAR_DEG))]
    return float(np.median(dsf_per_sr[near])) if len(near) else None


def _cross(v: FloatArray) -> FloatArray:
    """Matrix of v x (.); w x i = -_cross(i) @ w."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
