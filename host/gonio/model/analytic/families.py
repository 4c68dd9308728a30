"""families.py: the families by name."""

from gonio.model.analytic.abg import ABg
from gonio.model.analytic.family import Family
from gonio.model.analytic.gaussian import Gaussian
from gonio.model.analytic.ggx import GGX, GGXDielectric, GGXThrough
from gonio.model.analytic.lambertian import Lambertian
from gonio.model.analytic.ward_duer import WardDuer
from gonio.units.errors import UsageError

ALL: dict[str, Family] = {
    family.name: family
    for family in (Lambertian(), ABg(), Gaussian(), GGX(), GGXDielectric(), GGXThrough(), WardDuer())
}


def family_of(name: str) -> Family:
    """By name; UsageError where there is none."""
    if name not in ALL:
        raise UsageError(f"no family {name!r}: choose one of {', '.join(ALL)}")
    return ALL[name]
