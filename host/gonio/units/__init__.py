"""Units, constants, errors and the description of the instrument: what every other package may use."""
