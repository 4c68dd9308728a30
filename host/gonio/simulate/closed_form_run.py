"""closed_form_run.py: readings of a closed-form sample, in the place of traced ones: exact, without photons."""

from collections.abc import Sequence

import numpy as np

from gonio.geometry.directions import angle_between_deg
from gonio.geometry.kinematics import SOURCE_LAB
from gonio.simulate.closed_form import Truth
from gonio.simulate.readings import Job, Reading


def read_closed_form(truth: Truth, jobs: Sequence[Job]) -> list[Reading]:
    """One reading per job, seen through beam and aperture."""
    readings = []
    for job in jobs:
        if job.mounted:
            signal = truth.dsf_per_sr(*job.incident_deg, job.directions)
        else:
            signal = truth.beam_per_sr(angle_between_deg(job.directions, -SOURCE_LAB))
        nothing = np.zeros(len(signal))
        readings.append(Reading(signal, nothing, nothing.astype(np.uint64)))
    return readings
