"""layers.py: the reflectance of a fabric's threads from stacks of one, two and three layers of it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gonio.units.errors import UsageError

_CONVERGED = 0.005  # change of rho with one more layer that a sphere cannot tell from none


@dataclass(frozen=True)
class Threads:
    """What folding tells of the threads.

    reflectance, transmittance: solved with the stack model; openness: as given. folded: reflectance of the thickest
    stack, the value that folding converges to and paper [2] takes for the threads'; converged: whether the last layer
    changed it by less than 0.005, or none can be told from it (False also for a single layer). residual: the largest
    difference between measured rho and tau of the stacks and the model's.
    """

    reflectance: float
    transmittance: float
    openness: float
    folded: float
    converged: bool
    residual: float


def stack(rho: float, tau: float, layers: int) -> tuple[float, float]:
    """Reflectance and transmittance of equal layers with diffuse light between them (Stokes 1862):
    rho_n+1 = rho + tau^2 rho_n / (1 - rho rho_n), tau_n+1 = tau tau_n / (1 - rho rho_n)."""
    total_rho, total_tau = rho, tau
    for _ in range(layers - 1):
        between = 1.0 - rho * total_rho
        total_rho, total_tau = rho + tau**2 * total_rho / between, tau * total_tau / between
    return total_rho, total_tau


def threads_from_stacks(rho: Mapping[int, float], tau: Mapping[int, float], openness: float) -> Threads:
    """Reflectance r and transmittance t of the threads from rho and tau by number of layers.

    A layer is open over the share `openness` o; the rest is thread, which reflects r and lets t through, both diffuse:
    rho_1 = (1 - o) r, tau_1 = o + (1 - o) t. Layers lie on each other at random and light between them is diffuse
    (`stack`). Layers that were laid so that threads cover holes reflect somewhat more, layers with gaps between them
    lose light at their edges: `residual` shows it. r and t are least squares over all stacks. Raises UsageError where
    there is no rho of one layer, or the openness is impossible.
    """
    if 1 not in rho:
        raise UsageError("thread reflectance needs rho_total of one layer, and of two or three to see it converge")
    from scipy.optimize import least_squares  # noqa: PLC0415 - slow to load, and a model once fitted needs none

    if not 0.0 <= openness < 1.0:
        raise UsageError(f"openness {openness:g} is not from 0 to below 1: tau_diffuse exceeds tau_total?")
    cover = 1.0 - openness

    def difference(x: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[float]:
        one_rho, one_tau = cover * x[0] * x[1], openness + cover * x[0] * (1.0 - x[1])
        found = [stack(one_rho, one_tau, n)[0] - value for n, value in rho.items()]
        return found + [stack(one_rho, one_tau, n)[1] - value for n, value in tau.items()]

    # Solved as r + t, at most 1, and the reflected share of it.
    r, t = rho[1] / cover, max((tau.get(1, openness) - openness) / cover, 0.0)
    start = np.clip([r + t, r / max(r + t, 1e-9)], 1e-6, 1.0 - 1e-6)
    solved = least_squares(difference, start, bounds=([0.0, 0.0], [1.0, 1.0]), x_scale=0.1, xtol=1e-14, ftol=1e-14)
    r, t = float(solved.x[0] * solved.x[1]), float(solved.x[0] * (1.0 - solved.x[1]))
    thickest = max(rho)
    converged = thickest - 1 in rho and abs(rho[thickest] - rho[thickest - 1]) < _CONVERGED
    residual = float(np.max(np.abs(difference(solved.x))))
    return Threads(r, t, openness, rho[thickest], converged, residual)
