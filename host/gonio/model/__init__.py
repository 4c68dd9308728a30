"""Models: from points at a few incident directions to a BSDF in all directions."""
