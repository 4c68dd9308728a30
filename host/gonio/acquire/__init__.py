"""Driving the instrument: configuration, homing, running a program, resuming it."""
