"""polarisation.py: the mean of what was read with s and with p polarised light: the DSF for unpolarised light."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from gonio.dataset.bsdf import MASKED, Distribution
from gonio.geometry.local_fit import local_fit
from gonio.geometry.pitch import path_pitch_rad
from gonio.merge.points import effect_column, path_numbers, taken, units
from gonio.reduce.coverage import cells_of_paths

_FIT_PITCHES = 3.0


def unpolarised(s: Distribution, p: Distribution, *, reach: float) -> tuple[Distribution, dict[str, int]]:
    """Mean of the DSF of s and of p (effects under common keys), and counts of points: `paired`, and `unpaired`, which
    have no partner nearer than the tracks' pitch and are left out.

    The pass with fewer points gives the directions. Every point of the other one belongs to the nearest of them, is
    carried there along the local gradient, and is used once: noise stays independent between points, and the mean of
    m partners has its own variance. What both passes share (one key) adds with its signs, what they do not share keeps
    its key and adds in squares. Masked points stay masked.
    """
    base, other = (s, p) if s.measured.sum() <= p.measured.sum() else (p, s)
    at, of = taken(base, base.measured), taken(other, other.measured)
    at_unit, of_unit = units(at), units(of)
    pitch = path_pitch_rad(at_unit, path_numbers(at))
    distance, partner = cKDTree(at_unit).query(of_unit)
    near = np.flatnonzero(distance < pitch[partner])
    of, of_unit, partner = taken(of, near), of_unit[near], partner[near]
    fit = local_fit(
        of_unit,
        of.dsf_per_sr,
        of.variance_per_sr2,
        np.ones(len(near), dtype=bool),
        _FIT_PITCHES * float(np.median(pitch)),
    )
    step = np.einsum("ij,ij->i", np.nan_to_num(fit.gradient), at_unit[partner] - of_unit)
    number = np.bincount(partner, minlength=len(at_unit))
    share = 1.0 / np.maximum(number, 1)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(partner, values, len(at_unit)) * share

    keys = dict.fromkeys([*at.effects, *of.effects])
    paired = replace(
        at,
        dsf_per_sr=0.5 * (at.dsf_per_sr + mean(of.dsf_per_sr + step)),
        variance_per_sr2=0.25 * (at.variance_per_sr2 + mean(of.variance_per_sr2) * share),
        count=at.count + np.bincount(partner, of.count, len(at_unit)).astype(np.int32),
        effects={key: 0.5 * (effect_column(at, key) + mean(effect_column(of, key))) for key in keys},
    )
    paired.signal = paired.dsf_per_sr * paired.normalisation * paired.p_i
    paired.flags = at.flags | _flags(of.flags, partner, len(at_unit))
    paired = taken(paired, number > 0)
    masked = taken(base, base.flags & MASKED != 0)
    masked.effects = {key: np.full(len(masked.theta_deg), np.nan) for key in keys}
    whole = _appended(paired, masked)
    unit = units(whole)
    found = cells_of_paths(unit, path_numbers(whole), reach)
    whole.solid_angle_sr, whole.linear_solid_angle_sr = found.solid_angle_sr, found.linear_sr
    whole.p_i_u_rel = max(s.p_i_u_rel, p.p_i_u_rel)
    return whole, {"paired": int((number > 0).sum()), "unpaired": int((number == 0).sum()) + len(distance) - len(near)}


def _flags(flags: np.ndarray, partner: np.ndarray, n: int) -> np.ndarray:
    found = np.zeros(n, dtype=np.uint16)
    np.bitwise_or.at(found, partner, flags)
    return found


def _appended(one: Distribution, other: Distribution) -> Distribution:
    """The points of both, one after the other; of the rest that of `one`."""
    columns: dict[str, Any] = {}
    for name, value in vars(one).items():
        if isinstance(value, np.ndarray) and len(value) == len(one.theta_deg):
            columns[name] = np.concatenate((value, getattr(other, name)))
    effects = {key: np.concatenate((column, other.effects[key])) for key, column in one.effects.items()}
    return replace(one, **columns, effects=effects)
