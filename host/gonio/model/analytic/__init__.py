"""analytic: BSDF in closed form: Lambertian, Gaussian lobes, ABg, GGX, Ward-Duer; fitted, tied to measured rho, tau."""

from typing import Any

from gonio.dataset.scattering import Scattering
from gonio.model.analytic.component import Component
from gonio.model.analytic.families import ALL
from gonio.model.analytic.fit import FAMILIES, fit_family
from gonio.model.analytic.scattering import KIND, AnalyticScattering
from gonio.units.errors import UsageError

__all__ = ["ALL", "FAMILIES", "KIND", "AnalyticScattering", "Component", "fit_family", "from_json", "to_json"]


def to_json(channel: Scattering) -> dict[str, Any]:
    """Plain JSON values of an analytic channel. Raises TypeError for another kind."""
    if not isinstance(channel, AnalyticScattering):
        raise TypeError(f"{type(channel).__name__} is no analytic model")
    return channel.to_json()


def from_json(stored: Any) -> AnalyticScattering:
    """Inverse of `to_json`. Raises UsageError for anything else."""
    try:
        return AnalyticScattering.from_json(stored)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise UsageError(f"the stored analytic model is damaged ({error}): fit it again") from error
