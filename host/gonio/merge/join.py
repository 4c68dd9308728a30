"""join.py: distributions of one channel and incident direction as one: all their points, new cells over them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import MASKED, Distribution
from gonio.dataset.effects import effect_of
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.geometry.pitch import path_pitch_rad
from gonio.merge import neighbourhoods, sharing
from gonio.merge.points import effect_column, path_numbers, taken, units
from gonio.merge.scopes import Scopes, effects_of, own_keys
from gonio.merge.sources import Source
from gonio.reduce.coverage import cells_of_paths

FloatArray = NDArray[np.float64]

_INCIDENT = ("incident_measured_theta_deg", "incident_measured_phi_deg")


@dataclass(frozen=True)
class Pass:
    """One distribution of one source, in the merged dataset's keys."""

    source: Source
    distribution: Distribution


@dataclass
class Joined:
    """The joined distribution, and counts of points: left out because they were there twice, or masked where another
    session measured; weighted among those that lie together."""

    distribution: Distribution
    counts: dict[str, int] = field(default_factory=dict)


def pass_of(source: Source, distribution: Distribution, scopes: Scopes) -> Pass:
    """A distribution with its effects under the merged dataset's keys. Where the cause `p_i` stands there under a key
    of its own, p_i_u_rel is 0: it would count twice."""
    effects = effects_of(distribution, source, scopes)
    apart = "p_i" not in effects and any(effect_of(key).name == "p_i" for key in effects)
    u_rel = 0.0 if apart else distribution.p_i_u_rel
    return Pass(source, replace(distribution, effects=effects, p_i_u_rel=u_rel))


def incident_unit(distribution: Distribution) -> FloatArray:
    """Incident direction (3,) as the axes read it, where that is known, else as planned."""
    theta_deg, phi_deg = (distribution.integrals.get(name) for name in _INCIDENT)
    if theta_deg is None or phi_deg is None:
        theta_deg, phi_deg = distribution.incident_theta_deg, distribution.incident_phi_deg
    return unit_from_angles_deg(theta_deg, phi_deg)


def join(passes: Sequence[Pass], *, reach: float, together_deg: float) -> Joined:
    """The union of the passes' points, with cells over all of them: no point owns area farther off than `reach` times
    the pitch of the paths around it. Points of several sessions within `together_deg` share their cells by weight
    (sharing.py); no value is changed, so that the noise of points stays independent.

    A sample that is there twice (one raw log, one time and place) counts once. A direction that one session masked and
    another measured belongs to the other.
    """
    first = passes[0].distribution
    sessions = list(dict.fromkeys(p.source.session for p in passes))
    parts = [_scaled(p.distribution, first) for p in passes]
    lengths = [len(part.theta_deg) for part in parts]
    session = np.repeat([sessions.index(p.source.session) for p in passes], lengths)
    path, names = _paths([(p.source.session, part) for p, part in zip(passes, parts, strict=True)], len(sessions) > 1)
    whole = _concatenated(parts)
    whole.path = path
    if len(passes) == 1:
        whole.paths = names
        return Joined(replace(whole, integrals=_incident_entries(passes), budgets={}))
    order = np.lexsort((whole.time_ns, path < 0, session))
    once = _once(whole, session, order) if len(sessions) < len(passes) else order
    covered = _covered_by_others(taken(whole, once), session[once])
    kept = once[~covered]
    counts = {"repeated": len(order) - len(once), "masked_but_measured": int(covered.sum())}
    joined, session = taken(whole, kept), session[kept]
    joined.path, joined.paths = _renumbered(joined.path, names)
    unit = units(joined)
    found = cells_of_paths(unit, joined.path, reach)
    joined.solid_angle_sr = found.solid_angle_sr
    weight, together = sharing.weights(joined, session, own_keys(joined.effects), together_deg)
    place = neighbourhoods.numbers(joined.theta_deg, joined.phi_deg, together_deg)
    joined.solid_angle_sr = sharing.shared(found.solid_angle_sr, weight, together, place)
    joined.linear_solid_angle_sr = sharing.shared(found.linear_sr, weight, together, place)
    joined.integrals = _incident_entries(passes)
    joined.budgets = {}
    counts["weighted"] = int(together.sum())
    return Joined(joined, counts)


def _scaled(distribution: Distribution, like: Distribution) -> Distribution:
    """With the P_i of `like`: the DSF, signal / (normalisation P_i), and the signal stay as they are where their units
    are the same, else the signal is put into the unit of `like`."""
    if distribution.signal_unit == like.signal_unit:
        normalisation = distribution.normalisation * (distribution.p_i / like.p_i)
        return replace(distribution, normalisation=normalisation)
    factor = like.p_i / distribution.p_i
    return replace(distribution, signal=distribution.signal * factor)


def _paths(parts: Sequence[tuple[str, Distribution]], several: bool) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Path numbers of all points and the paths' names: a path that was flown in one session is one, in whatever files
    its samples are."""
    names: dict[tuple[str, str, int], int] = {}
    numbers = []
    for session, part in parts:
        # Paths of one name are told apart by their order.
        keys = [(session, name, part.paths[:k].count(name)) for k, name in enumerate(part.paths)]
        number_of = [names.setdefault(key, len(names)) for key in keys]
        numbers.append(np.array([*number_of, -1], dtype=np.int32)[path_numbers(part)])
    return np.concatenate(numbers), tuple(f"{name} #{session}" if several else name for session, name, _ in names)


def _renumbered(path: NDArray[np.int32], names: tuple[str, ...]) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Paths in the order in which their first points come."""
    present, first = np.unique(path[path >= 0], return_index=True)
    order = present[np.argsort(first)]
    number = np.full(len(names) + 1, -1, dtype=np.int32)
    number[order] = np.arange(len(order), dtype=np.int32)
    return number[path], tuple(names[old] for old in order)


def _concatenated(parts: Sequence[Distribution]) -> Distribution:
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in (
            "theta_deg",
            "phi_deg",
            "dsf_per_sr",
            "variance_per_sr2",
            "signal",
            "normalisation",
            "count",
            "flags",
            "solid_angle_sr",
            "time_ns",
        )
    }
    keys = dict.fromkeys(key for part in parts for key in part.effects)
    effects = {key: np.concatenate([effect_column(part, key) for part in parts]) for key in keys}
    return replace(
        parts[0],
        **columns,
        effects=effects,
        linear_solid_angle_sr=np.concatenate([_linear(part) for part in parts]),
        p_i_u_rel=max(part.p_i_u_rel for part in parts),
    )


def _linear(part: Distribution) -> FloatArray:
    return part.linear_solid_angle_sr if len(part.linear_solid_angle_sr) else part.solid_angle_sr


def _once(whole: Distribution, session: NDArray[np.int64], order: NDArray[np.intp]) -> NDArray[np.intp]:
    """`order` without the samples that are there already: same session, time and direction. Measured points without a
    time (imported, simulated) are never one."""
    rows = (whole.phi_deg[order], whole.theta_deg[order], whole.time_ns[order], session[order])
    by_row = np.lexsort(rows)
    same = np.ones(len(order) - 1, dtype=bool)
    for column in rows:
        same &= np.diff(column[by_row]) == 0
    again = by_row[1:][same]
    again = again[(whole.time_ns[order[again]] != 0) | ~whole.measured[order[again]]]
    return np.asarray(np.delete(order, again))


def _covered_by_others(whole: Distribution, session: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Masked points (n,) where another session measured: its nearest point is a measured one, and nearer than its
    tracks are to each other. Where both have masked a direction, what was measured around it says nothing of it."""
    covered = np.asarray(whole.flags & MASKED != 0)
    if not covered.any():
        return covered
    unit = units(whole)
    found: NDArray[np.bool_] = np.zeros(len(covered), dtype=bool)
    for number in np.unique(session):
        others = np.flatnonzero(covered & (session != number))
        own = np.flatnonzero(session == number)
        measured = ~covered[own]
        if not len(others) or not measured.any():
            continue
        pitch = np.zeros(len(own))
        pitch[measured] = path_pitch_rad(unit[own[measured]], whole.path[own[measured]])
        distance, nearest = cKDTree(unit[own]).query(unit[others])
        found[others[distance < pitch[nearest]]] = True
    return found


def _incident_entries(passes: Sequence[Pass]) -> dict[str, float]:
    """The mean incident direction that the axes read, where one did."""
    read = [p.distribution for p in passes if all(name in p.distribution.integrals for name in _INCIDENT)]
    if not read:
        return {}
    mean = np.mean([incident_unit(d) for d in read], axis=0)
    mean /= np.linalg.norm(mean)
    first = passes[0].distribution
    planned = unit_from_angles_deg(first.incident_theta_deg, first.incident_phi_deg)
    read_deg = dict(zip(_INCIDENT, (float(value) for value in angles_deg_from_unit(mean)), strict=True))
    return read_deg | {"incident_off_plan_deg": float(angle_between_deg(mean, planned))}
