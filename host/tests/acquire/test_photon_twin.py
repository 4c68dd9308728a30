"""test_photon_twin.py: gonio scan of a sample that is traced: the twin's detector reads stored photon maps."""

from pathlib import Path

import numpy as np
import pytest
from twin_runs import journal, run, write_inputs

from gonio.dataset.bsdf import Distribution
from gonio.rawlog.reader import read_rawlog
from gonio.reduce.pipeline import reduce_rawlog

pytestmark = pytest.mark.twin
PHOTONS = 400_000
REFLECTANCE = 0.5
SCENARIO = f"""
seed = 3
[sample]
kind = "lambertian"
reflectance = {REFLECTANCE}
[beam]
kind = "focused"
diameter_mm = 10.0
divergence_deg = 1.0
[photons]
count = {PHOTONS}
"""


def scanned(folder: Path) -> Distribution:
    """The one distribution of a scan in this folder."""
    folder.mkdir()
    plan, device = write_inputs(folder, SCENARIO)
    # A free beam scanned as coarsely as there gives its power to 3 % only; so it gives it to 0.1 %.
    plan.write_text(plan.read_text().replace("pitch_deg = 0.5", "pitch_deg = 0.25", 1))
    raw, account = folder / "raw.mcap", folder / "journal.json"
    status, _, err = run(folder, "scan", plan, "-o", raw, "--device", device, "--twin-journal", account)
    assert (status, err) == (0, "")
    # One incident direction and the free beam; the sample turned in the dark alone.
    assert journal(account)["optics"] == (
        "photon map: 2 traced, 0 dropped for memory; while the sample turned, the nearest map answered 0 readings"
    )
    (distribution,) = reduce_rawlog(read_rawlog([raw])).distributions
    return distribution


def test_scan_of_a_traced_lambertian_reads_its_reflectance_and_repeats_bit_for_bit(tmp_path: Path) -> None:
    first, second = scanned(tmp_path / "a"), scanned(tmp_path / "b")
    assert np.array_equal(first.dsf_per_sr, second.dsf_per_sr, equal_nan=True)
    # Of the cells that were measured; the rest is behind the detector's head or out of reach.
    seen = first.measured & (first.theta_deg < 90.0)
    cosine = np.cos(np.radians(first.theta_deg[seen]))
    expected = REFLECTANCE / np.pi * float(cosine @ first.solid_angle_sr[seen])
    # Tracks 12 degrees apart see swaths as wide as the aperture, 0.56 degrees: so much of what is reflected is counted.
    sigma = expected / np.sqrt(PHOTONS * REFLECTANCE * 0.56 / 12.0)
    assert first.integrals["rho_measured"] == pytest.approx(expected, abs=4.0 * sigma)
