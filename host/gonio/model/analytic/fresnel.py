"""fresnel.py: reflectance of a smooth interface."""

import numpy as np

from gonio.dataset.scattering import FloatArray


def dielectric(cosine: FloatArray, index: FloatArray | float) -> FloatArray:
    """Unpolarised reflectance of an interface, light arriving at `cosine` from the normal; `index` is that of the far
    side over that of the near side. 1 where all is reflected. Walter et al. 2007 eq. 22."""
    c = np.asarray(cosine)
    g2 = np.asarray(index) ** 2 - 1.0 + c**2
    g = np.sqrt(np.maximum(g2, 0.0))
    ratio = (g - c) / np.maximum(g + c, 1e-300)
    second = (c * (g + c) - 1.0) / (c * (g - c) + 1.0)
    return np.where(g2 > 0.0, 0.5 * ratio**2 * (1.0 + second**2), 1.0)


def schlick(cosine: FloatArray, normal_reflectance: FloatArray | float) -> FloatArray:
    """Reflectance f0 + (1 - f0) (1 - cos)^5: Schlick 1994 eq. 15."""
    return np.asarray(normal_reflectance + (1.0 - normal_reflectance) * (1.0 - np.asarray(cosine)) ** 5)
