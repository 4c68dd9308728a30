"""What was measured at each incident direction: points, lobes, what is left beside them, the declared symmetry."""
