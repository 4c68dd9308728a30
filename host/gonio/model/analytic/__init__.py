"""analytic: BSDF in closed form: Lambertian, Gaussian lobes, ABg, GGX, Ward-Duer; fitted, tied to measured rho, tau."""

from gonio.model.analytic.component import Component
from gonio.model.analytic.families import ALL
from gonio.model.analytic.fit import FAMILIES, fit_family
from gonio.model.analytic.scattering import KIND, AnalyticScattering

__all__ = ["ALL", "FAMILIES", "KIND", "AnalyticScattering", "Component", "fit_family"]
