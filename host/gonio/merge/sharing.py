"""sharing.py: how points of several sessions that lie together share their area: by what they are sure of."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.merge import neighbourhoods

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A session's uncertainty is averaged over so many of its points, but over no less than this angle.
_SMOOTH_POINTS = 100
_SMOOTH_DEG = 2.0


def weights(
    distribution: Distribution, session: IntArray, own_effects: Sequence[str], together_deg: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Weights (n,) that the points of a joined distribution have among those that lie together with them, and which
    points (n,) are in a neighbourhood of several sessions; the others have weight 1.

    `session` (n,) is the number of each point's session; `own_effects` are the effects that sessions do not share.

    A neighbourhood is `together_deg` wide: a fraction of the aperture, within which nothing can differ but by error.
    Where k sessions read it, with n_k points of variance v_k each and a standard uncertainty s_k of what their points
    have in common but other sessions do not, the mean of session k has the variance v_k / n_k + s_k^2, and the weighted
    mean of least variance gives each of its points 1 / (v_k + n_k s_k^2) (GUM: weights inverse to variances).

    v and s are means over a hundred points or more: a point's own variance follows its reading (shot noise), and with
    it as weight low readings would be believed more than high ones, which biases the mean.
    """
    n = len(session)
    weight: FloatArray = np.ones(n)
    together: NDArray[np.bool_] = np.zeros(n, dtype=bool)
    measured = distribution.measured & (distribution.solid_angle_sr > 0.0)
    if len(np.unique(session[measured])) < 2:
        return weight, together
    place = neighbourhoods.numbers(distribution.theta_deg, distribution.phi_deg, together_deg)
    count = _table(place, session, measured.astype(np.float64))
    together = measured & (np.sum(count > 0.0, axis=1, keepdims=True) > 1)[place, 0]
    in_session = np.bincount(session[measured])
    fewest = in_session[in_session > 0].min()
    spread_deg = np.degrees(np.sqrt(_SMOOTH_POINTS * distribution.solid_angle_sr[measured].sum() / fewest))
    smooth = neighbourhoods.numbers(distribution.theta_deg, distribution.phi_deg, max(_SMOOTH_DEG, spread_deg))
    points = np.maximum(_table(smooth, session, measured.astype(np.float64)), 1.0)
    own = np.zeros(n)
    for key in own_effects:
        own += distribution.effects[key] ** 2
    v = (_table(smooth, session, np.where(measured, distribution.variance_per_sr2, 0.0)) / points)[smooth, session]
    s2 = (_table(smooth, session, np.where(measured, own, 0.0)) / points)[smooth, session]
    variance = v + count[place, session] * s2
    # Where a session claims to be exact there is no least variance to be found.
    exact = np.bincount(place, (together & ~(variance > 0.0)).astype(np.float64))[place] > 0.0
    together &= ~exact
    weight[together] = 1.0 / variance[together]
    return weight, together


def shared(area_sr: FloatArray, weight: FloatArray, together: NDArray[np.bool_], place: IntArray) -> FloatArray:
    """Areas (n,) shared anew within each neighbourhood, in proportion to the weights; each keeps its whole area."""
    found = area_sr.copy()
    groups = int(place.max(initial=-1)) + 1
    own, by = area_sr[together], weight[together]
    whole = np.bincount(place[together], own, groups)
    weighted = np.bincount(place[together], own * by, groups)
    scale = np.divide(whole, weighted, out=np.zeros(groups), where=weighted > 0.0)
    found[together] = own * by * scale[place[together]]
    return found


def _table(place: IntArray, session: IntArray, values: FloatArray) -> FloatArray:
    """Sums (places, sessions) of `values` (n,)."""
    sessions = int(session.max()) + 1
    places = int(place.max()) + 1
    table = np.bincount(place * sessions + session, values, places * sessions)
    return np.asarray(table, dtype=np.float64).reshape(places, sessions)
