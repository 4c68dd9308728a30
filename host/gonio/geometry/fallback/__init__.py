"""fallback: what the compiled module _sphere does, by numpy and scipy: the same functions (_sphere.pyi), slower."""

from gonio.geometry.fallback.local_fit import local_fit
from gonio.geometry.fallback.locator import Locator
from gonio.geometry.fallback.tracks import track_distances
from gonio.geometry.fallback.triangulation import cells, edges, shared_reach

__all__ = ["Locator", "cells", "edges", "local_fit", "shared_reach", "track_distances"]
