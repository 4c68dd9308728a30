"""Radiance's tensor trees: grown sparsely from any Scattering, written, and read back."""
