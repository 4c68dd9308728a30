"""test_merge_traced_rig.py: the twin's traced beam splitters through the merge: a white disc comes back as white, and
the step of slip S12 is found and taken out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_form_sets import distribution, lambertian, spiral

from gonio.merge.points import units
from gonio.merge.retro import Plate, RetroOptions, retro_distribution
from gonio.merge.splitter_view import REFERENCE_LAB, SAMPLE_LAB, lab_from_sample
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import Job
from gonio.simulate.request import Request
from gonio.simulate.setting import open_setting

SCENARIO = Path(__file__).parents[3] / "sim" / "scenarios" / "photon" / "splitter_rig.toml"
INCIDENT = (20.0, 0.0)
BAND = "near-infrared"
WHITE = 0.8 / np.pi


def test_a_white_disc_seen_in_the_splitters():
    """The readings are per emitted power: what arrives at the reference is R T of it, 0.204, in the mean over s and p.
    The disc depolarises: it is seen with 0.2401. Errors: 1500 photons about the retro direction, 2.6 %."""
    lab = np.concatenate((spiral(SAMPLE_LAB, 8.5, 0.8), spiral(REFERENCE_LAB, 1.5, 0.15)))
    unit = np.ascontiguousarray(lab @ lab_from_sample(*INCIDENT))
    with PhotonProgress() as progress, open_setting(Request(SCENARIO, seed=3, threads=2), progress) as setting:
        reading = setting.read([Job(BAND, INCIDENT, True, unit)], 400_000)[0]
    planned = distribution(unit, lambertian(), incident=INCIDENT, channel=BAND)
    rig = replace(
        planned,
        dsf_per_sr=reading.signal_per_sr,
        variance_per_sr2=reading.error_per_sr**2,
        p_i=1.0,
        signal=reading.signal_per_sr,
    )
    as_read = retro_distribution(rig, rig, "unpolarised", RetroOptions())
    assert as_read.facts["reference_power"] == pytest.approx(0.204, rel=0.01)
    assert _over_truth(as_read.distribution) == pytest.approx(0.2401 / 0.204, abs=0.06)
    plate = Plate(reflectance_s=0.68, reflectance_p=0.30, transmittance_s=0.30, transmittance_p=0.68)
    options = RetroOptions(plate=plate, depolarisation=1.0, depolarisation_u=0.0)
    assert _over_truth(retro_distribution(rig, rig, "unpolarised", options).distribution) == pytest.approx(
        1.0, abs=0.05
    )


def _over_truth(d):
    return float(d.dsf_per_sr @ d.solid_angle_sr / (WHITE * units(d)[:, 2] @ d.solid_angle_sr))
