"""directions.py: directions that cover the sphere evenly."""

import numpy as np
from numpy.typing import NDArray


def even_directions(count: int) -> NDArray[np.float64]:
    """Unit vectors on a Fibonacci spiral, shape (count, 3); each stands for 4 pi / count steradians."""
    number = np.arange(count) + 0.5
    z = 1 - 2 * number / count
    phi = number * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(phi), ring * np.sin(phi), z], 1)
