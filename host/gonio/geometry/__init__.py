"""geometry: directions, kinematics of the instrument, spherical cells."""
