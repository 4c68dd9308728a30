"""integral_delta.py: integrals of A and B side by side: of the points compared, and those that both files hold."""

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gonio.compare.judge import spread_out
from gonio.compare.metrics import delta_percent
from gonio.compare.result import IntegralDelta
from gonio.compare.values import Values
from gonio.dataset.bsdf import Distribution
from gonio.dataset.effects import EFFECTS, effect_of
from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.directions import angle_between_deg, mirror, retro, through, unit_from_angles_deg

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_STORED = re.compile(
    r"(rho|tau)_(measured|estimate|counted|voronoi|direct|diffuse)|openness|haze|cone .+(?<!_u)(?<!_measured_share)"
)
# Effects that scale all of a dataset: their contributions to two integrals of one instrument have one sign.
_SCALES = frozenset({"distance", "aperture"})
assert EFFECTS.keys() >= _SCALES


def compared_integrals(
    reference: Distribution, used: BoolArray, a: Values, b: Values, cone_deg: float
) -> list[IntegralDelta]:
    """Sums of DSF times the cells of A over the points that both have, so that what was not measured is missing in
    both: "rho_compared", "tau_compared" over the hemispheres and "cone_through", "cone_mirror", "cone_retro" over the
    points within `cone_deg` of these directions (biconical, paper [1] section 3.3)."""
    incident = reference.incident_theta_deg, reference.incident_phi_deg
    unit = unit_from_angles_deg(reference.theta_deg, reference.phi_deg)
    same_side = (reference.theta_deg <= 90.0) == (reference.incident_theta_deg <= 90.0)
    parts = {"rho_compared": used & same_side, "tau_compared": used & ~same_side}
    for name, about in (("through", through), ("mirror", mirror), ("retro", retro)):
        axis = unit_from_angles_deg(*about(*incident))
        parts[f"cone_{name}"] = used & (angle_between_deg(unit, axis) <= cone_deg)
    found = []
    for name, part in parts.items():
        weight = spread_out(part, reference.solid_angle_sr[part])
        if weight.any():
            found.append(_delta(name, a.linear(weight), b.linear(weight)))
    return found


def stored_integrals(a: Distribution, b: Distribution, shared: frozenset[str]) -> list[IntegralDelta]:
    """Integrals that both files hold, each over what its own file measured.

    A stored budget has no signs: of the effects in `shared` only those that scale a whole dataset cancel, the others
    count as if they had different causes.
    """
    common = [name for name in a.integrals if name in b.integrals and _STORED.fullmatch(name)]
    return [_delta(name, _stored(name, a, "A", shared), _stored(name, b, "B", shared)) for name in common]


def _stored(name: str, d: Distribution, mark: str, shared: frozenset[str]) -> Uncertain:
    budget: Mapping[str, float] = d.budgets.get(name, {})
    value = d.integrals[name]
    if not budget:
        short = re.sub(r"_(measured|estimate)$", "", name)
        return Uncertain(
            value, next((d.integrals[key] for key in (f"{name}_u", f"{short}_u") if key in d.integrals), 0.0)
        )
    independent = budget.get("independent", 0.0)
    scales = {key for key in budget if key in shared and effect_of(key).name in _SCALES}
    effects = {key if key in scales else f"{key} @{mark}": part for key, part in budget.items() if key != "independent"}
    return Uncertain(value, independent, effects)


def _delta(name: str, a: Uncertain, b: Uncertain) -> IntegralDelta:
    ratio = None if a.value == 0.0 else b.over(a)
    difference = b.minus(a)
    return IntegralDelta(
        name=name,
        a=a.value,
        b=b.value,
        u_a=a.u,
        u_b=b.u,
        delta_percent=delta_percent(a.value, b.value),
        signed_percent=None if ratio is None else 100.0 * (ratio.value - 1.0),
        u_percent=None if ratio is None else 100.0 * ratio.u,
        in_u=difference.value / difference.u if difference.u > 0.0 else None,
    )
