"""Judges of models and simulation files: samples whose truth is known, and the table beside Radiance's chain."""
