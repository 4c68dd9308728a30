"""match.py: which distribution of B belongs to which of A: by channel and incident direction."""

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg


@dataclass(frozen=True)
class Matching:
    """Pairs of indices (A, B) in the order of A, what is left of both, and what the user should know."""

    pairs: tuple[tuple[int, int], ...]
    unmatched_a: tuple[str, ...]
    unmatched_b: tuple[str, ...]
    remarks: tuple[str, ...]


def match(a: Dataset, b: Dataset, tolerance_deg: float) -> Matching:
    """One to one: channels of the same name (or the only one of each dataset), incident directions no farther apart
    than `tolerance_deg`, the nearest first."""
    remarks = []
    names = [{d.channel for d in dataset.distributions} for dataset in (a, b)]
    alone = all(len(channels) == 1 for channels in names)
    if alone and names[0] != names[1]:
        remarks.append(f'channel "{min(names[0])}" of A is compared with "{min(names[1])}", the only one of B')
    candidates = []
    for i, one in enumerate(a.distributions):
        for j, other in enumerate(b.distributions):
            apart_deg = float(angle_between_deg(_incident(one), _incident(other)))
            if (alone or one.channel == other.channel) and apart_deg <= tolerance_deg:
                candidates.append((apart_deg, i, j))
    taken_a: dict[int, int] = {}
    taken_b: set[int] = set()
    for _, i, j in sorted(candidates):
        if i not in taken_a and j not in taken_b:
            taken_a[i] = j
            taken_b.add(j)
    return Matching(
        tuple(sorted(taken_a.items())),
        _names(a.distributions, taken_a.keys()),
        _names(b.distributions, taken_b),
        tuple(remarks),
    )


def described(distribution: Distribution) -> str:
    """Channel and incident direction: "visible (30, 0)"."""
    theta, phi = distribution.incident_theta_deg, distribution.incident_phi_deg
    return f"{distribution.channel} ({theta:g}, {phi:g})"


def _incident(distribution: Distribution) -> NDArray[np.float64]:
    return unit_from_angles_deg(distribution.incident_theta_deg, distribution.incident_phi_deg)


def _names(distributions: Sequence[Distribution], taken: Container[int]) -> tuple[str, ...]:
    return tuple(described(d) for index, d in enumerate(distributions) if index not in taken)
