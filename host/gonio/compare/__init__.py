"""Comparison of two datasets, or of a dataset with a model: the papers' metrics, also by solid angle and noise."""
