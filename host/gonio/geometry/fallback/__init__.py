"""fallback: what the compiled module _sphere does, by numpy and scipy: the same functions (_sphere.pyi), slower."""

from gonio.geometry.fallback.local_fit import local_fit
from gonio.geometry.fallback.locator import Locator
from gonio.geometry.fallback.tracks import coarsest_pitch, track_distances
from gonio.geometry.fallback.triangulation import cells, edges

__all__ = ["Locator", "cells", "coarsest_pitch", "edges", "local_fit", "track_distances"]
