"""pair.py: one distribution of A and what B says at its points, judged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.compare import metrics
from gonio.compare.field import At, Field, PointField
from gonio.compare.integral_delta import compared_integrals, stored_integrals
from gonio.compare.judge import judge
from gonio.compare.result import Metrics, Pair, PathTrace, Profile, Region, Route, Settings
from gonio.compare.scatter_plane import plane_directions, profile
from gonio.compare.values import difference_u_per_sr
from gonio.dataset.bsdf import Distribution, PointFlag

BoolArray = NDArray[np.bool_]

_SIDES: tuple[Region, ...] = ("reflection", "transmission")


@dataclass(frozen=True)
class Beside:
    """B for one distribution of A: its values at A's points, how they came there, and itself in any direction."""

    at: At
    route: Route
    field: Field
    channel: str
    incident_deg: tuple[float, float]
    distribution: Distribution | None  # None: a model
    shared: frozenset[str] = frozenset()  # effects whose cause is A's too


def judge_pair(reference: PointField, beside: Beside, settings: Settings) -> Pair:
    """Everything about one pair."""
    d, other = reference.distribution, beside.distribution
    a = reference.values.with_own_effects("A", beside.shared)
    b = beside.at.values.with_own_effects("B", beside.shared)
    used = np.isfinite(a.dsf_per_sr) & np.isfinite(b.dsf_per_sr)
    u = difference_u_per_sr(a, b)
    same_side = (d.theta_deg <= 90.0) == (d.incident_theta_deg <= 90.0)
    regions: dict[Region, BoolArray] = {
        "whole": np.ones(len(used), dtype=np.bool_),
        "reflection": same_side,
        "transmission": ~same_side,
    }
    judged: dict[Region, Metrics] = {
        name: judge(
            name,
            used & inside,
            _left_out(inside, used, np.isfinite(a.dsf_per_sr), beside.at.masked),
            a,
            b,
            d.solid_angle_sr,
            settings.floor_per_sr,
        )
        for name, inside in regions.items()
        if np.any(used & inside)
    }
    local = metrics.local_accordance_percent(a.dsf_per_sr, b.dsf_per_sr)
    integrals = compared_integrals(d, used, a, b, settings.cone_deg)
    return Pair(
        channel=d.channel,
        incident_theta_deg=d.incident_theta_deg,
        incident_phi_deg=d.incident_phi_deg,
        b_channel=beside.channel,
        b_incident_theta_deg=beside.incident_deg[0],
        b_incident_phi_deg=beside.incident_deg[1],
        route=beside.route,
        theta_deg=d.theta_deg,
        phi_deg=d.phi_deg,
        solid_angle_sr=d.solid_angle_sr,
        a_per_sr=a.dsf_per_sr,
        b_per_sr=b.dsf_per_sr,
        u_a_per_sr=a.u_per_sr,
        u_b_per_sr=b.u_per_sr,
        u_difference_per_sr=u,
        used=used,
        local_accordance_percent=local,
        deviation_in_u=np.divide(b.dsf_per_sr - a.dsf_per_sr, u, out=np.full(len(u), np.nan), where=used & (u > 0.0)),
        metrics=judged,
        integrals=(*integrals, *([] if other is None else stored_integrals(d, other, beside.shared))),
        profiles=tuple(
            found
            for region in _SIDES
            if region in judged and (found := _profile(region, reference, beside, settings)) is not None
        ),
        path_a=path_trace(d),
        path_b=None if other is None else path_trace(other),
        shared_effects=tuple(sorted(beside.shared)),
        interpolation_per_sr=beside.at.interpolation_per_sr,
    )


def path_trace(distribution: Distribution) -> PathTrace:
    """The directions that were flown; those that were only planned are in the list of points too."""
    flown = distribution.flags & (PointFlag.UNREACHABLE | PointFlag.NOT_MEASURED) == 0
    path = distribution.path if len(distribution.path) else np.full(len(flown), -1, dtype=np.int32)
    return PathTrace(distribution.theta_deg[flown], distribution.phi_deg[flown], path[flown], distribution.paths)


def _left_out(inside: BoolArray, used: BoolArray, has_a: BoolArray, masked_b: BoolArray) -> dict[str, int]:
    missing_b = inside & has_a & ~used
    return {
        "masked_a": int((inside & ~has_a).sum()),
        "masked_b": int((missing_b & masked_b).sum()),
        "outside_b": int((missing_b & ~masked_b).sum()),
    }


def _profile(region: Region, reference: PointField, beside: Beside, settings: Settings) -> Profile | None:
    d = reference.distribution
    directions = plane_directions(d.incident_theta_deg, d.incident_phi_deg, region)
    a = reference.at(directions).values.with_own_effects("A", beside.shared)
    b = beside.field.at(directions).values.with_own_effects("B", beside.shared)
    return profile(region, directions, a, b, settings.floor_per_sr)
