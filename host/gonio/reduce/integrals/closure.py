"""closure.py: closure of the beam: the free beam, taken as if it were light through a sample, must add up to 1."""

from dataclasses import replace

import numpy as np

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain
from gonio.geometry.cells import cells
from gonio.geometry.directions import angles_deg_from_unit
from gonio.geometry.pitch import reach_rad
from gonio.reduce.integrals.quadrature import integral, side_weights


def closure(beam: Distribution) -> Uncertain:
    """sum E Omega / P_i (1 for a beam that is all there) by the way that samples go: sample-frame directions at normal
    incidence, cells cut at the horizon, masks, 2 V - P1, effects; `beam` as in Dataset.beam, in the order flown.

    It tells what cells, masks and reduction do to a power that is known; P_i cancels, so its uncertainty is not in it.
    Scans before and after count with equal weight.
    """
    polar, azimuth = np.radians(beam.theta_deg), np.radians(beam.phi_deg)
    # Normal incidence: the lab's axes are the sample's, and straight through is -z.
    unit = np.stack((np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)), axis=1)
    path = beam.path if len(beam.path) else np.zeros(len(unit), dtype=np.int32)
    found = cells(unit, reach_rad=reach_rad(unit, path))
    theta_deg, phi_deg = angles_deg_from_unit(unit)
    sample = replace(
        beam,
        theta_deg=theta_deg,
        phi_deg=phi_deg,
        solid_angle_sr=found.solid_angle_sr,
        linear_solid_angle_sr=found.linear_sr,
        p_i_u_rel=0.0,
        effects={key: column for key, column in beam.effects.items() if key.partition(" #")[0] != "p_i"},
    )
    return integral(sample, side_weights(sample, unit, unit[:, 2] < 0.0))
