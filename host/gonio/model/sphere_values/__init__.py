"""sphere_values: what an integrating sphere measured: spectra, layers, openness, thread reflectance."""

from gonio.model.sphere_values.band import Band
from gonio.model.sphere_values.layers import Threads, stack, threads_from_stacks
from gonio.model.sphere_values.read import read_sphere
from gonio.model.sphere_values.table import SphereRow, SphereSpectrum, SphereValues

__all__ = [
    "Band",
    "SphereRow",
    "SphereSpectrum",
    "SphereValues",
    "Threads",
    "read_sphere",
    "stack",
    "threads_from_stacks",
]
