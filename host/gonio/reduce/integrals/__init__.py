"""integrals: what a distribution adds up to, with uncertainty: hemispheres, cones, direct part, peaks, free beam."""
