"""signature: what beam and aperture do to a distribution: measured, applied to a model, taken out again."""
