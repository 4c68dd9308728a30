"""Radiance's side of the photon-map benchmarks and judges: scenes, runs and readings of an independent program."""
