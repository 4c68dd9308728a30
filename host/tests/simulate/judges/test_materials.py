"""test_materials.py: Radiance judges the materials that it shares with us: flat sheets, rtrace without sampling."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from our_sheet import goniophotometer, readings, reflected_and_transmitted, sheet_scenario
from radiance_sheet import FloatArray, dsf_per_sr, ideal_part, sheet

from benchmarks.sim.directions import even_directions
from benchmarks.sim.scene import unit

pytestmark = pytest.mark.judge
PHOTONS = 1_000_000
CAP_RAD = np.radians(4.0)

SCATTERING = {
    "lambertian": ('kind = "lambertian"\nreflectance = 0.6', "void plastic m\n0\n0\n5 0.6 0.6 0.6 0 0"),
    "metal": (
        'kind = "metal"\nreflectance = 0.7\nspecularity = 0.8\nroughness = 0.2',
        "void metal m\n0\n0\n5 0.7 0.7 0.7 0.8 0.2",
    ),
    "plastic": (
        'kind = "plastic"\nreflectance = 0.6\nspecularity = 0.1\nroughness = 0.15',
        "void plastic m\n0\n0\n5 0.6 0.6 0.6 0.1 0.15",
    ),
    "smooth-plastic": (
        'kind = "plastic"\nreflectance = 0.6\nspecularity = 0.05',
        "void plastic m\n0\n0\n5 0.6 0.6 0.6 0.05 0",
    ),
    "ward-duer": (
        'kind = "ward-duer"\nreflectance = 0.8\nspecular_share = 0.7\nroughness_x = 0.15\nroughness_y = 0.3',
        "void metal2 m\n4 1 0 0 .\n0\n6 0.8 0.8 0.8 0.7 0.15 0.3",
    ),
}


@pytest.mark.parametrize("incident_deg", [(10.0, 0.0), (45.0, 30.0), (70.0, 200.0)])
@pytest.mark.parametrize("name", SCATTERING)
def test_distribution_is_radiances(name: str, incident_deg: tuple[float, float], tmp_path: Path) -> None:
    """Caps of 4 degrees over the hemisphere, apart from each other: the sum of squared deviations, in standard errors,
    is chi-square distributed; 5 sigma of it are allowed. Smooth materials: all but the mirror image."""
    ours, theirs = SCATTERING[name]
    centres = even_directions(600)
    centres = centres[centres[:, 2] > np.sin(CAP_RAD)]  # whole caps: apart by 8.1 degrees
    mirror = unit(incident_deg[0], incident_deg[1] + 180)
    if name == "smooth-plastic":
        centres = centres[centres @ mirror < np.cos(CAP_RAD + np.radians(0.5))]
    dsf, error, hits = readings(
        goniophotometer(sheet_scenario(ours), incident_deg, tmp_path), centres, CAP_RAD, PHOTONS
    )

    expected = cap_means(lambda towards: dsf_per_sr(theirs, incident_deg, towards, tmp_path), centres)
    enough = hits > 100  # their errors are nearly normal, and known
    assert np.sum(enough) > 60
    chi_square = float(np.sum(((dsf - expected)[enough] / error[enough]) ** 2))
    freedom = int(np.sum(enough))
    assert abs(chi_square - freedom) < 5 * np.sqrt(2 * freedom)
    # And the sum over all caps, few hits or none, to 4 of its standard errors.
    assert np.sum(dsf) == pytest.approx(np.sum(expected), abs=4 * float(np.sqrt(np.sum(error**2))))


def cap_means(function: Callable[[FloatArray], FloatArray], centres: FloatArray) -> FloatArray:
    """Means over caps of CAP_RAD about unit vectors (n, 3), by 96 points of equal solid angle."""
    number = np.arange(96) + 0.5
    cosine = 1 - (1 - np.cos(CAP_RAD)) * number / 96
    phi = number * np.pi * (3 - np.sqrt(5))
    sine = np.sqrt(1 - cosine**2)
    across = np.cross(centres, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    other = np.cross(centres, across)
    points = (
        cosine[:, None] * centres[:, None]
        + (sine * np.cos(phi))[:, None] * across[:, None]
        + (sine * np.sin(phi))[:, None] * other[:, None]
    )
    return function(points.reshape(-1, 3)).reshape(len(centres), 96).mean(axis=1)


IDEAL = {
    "metal": ('kind = "metal"\nreflectance = 0.9\nspecularity = 1.0', "void metal m\n0\n0\n5 0.9 0.9 0.9 1 0"),
    "glass": ('kind = "glass"\ntransmissivity = 0.9', "void glass m\n0\n0\n3 0.9 0.9 0.9"),
    "glass-index": (
        'kind = "glass"\ntransmissivity = 0.95\nindex = 1.7',
        "void glass m\n0\n0\n4 0.95 0.95 0.95 1.7",
    ),
}


@pytest.mark.parametrize("theta_deg", [0.0, 40.0, 60.0, 80.0])
@pytest.mark.parametrize("name", IDEAL)
def test_shares_of_ideal_sheets_are_radiances(name: str, theta_deg: float, tmp_path: Path) -> None:
    """4 sigma of at most 0.5 / sqrt(photons) = 0.1 %; Radiance perturbs nothing and follows every path."""
    ours, theirs = IDEAL[name]
    found = reflected_and_transmitted(goniophotometer(sheet_scenario(ours), (theta_deg, 0.0), tmp_path), 4 * PHOTONS)
    for share, through in zip(found, (False, True), strict=True):
        expected = ideal_part(sheet(theirs), theta_deg, through=through, where=tmp_path)
        assert share == pytest.approx(expected, abs=4 * 0.5 / np.sqrt(4 * PHOTONS))


@pytest.mark.parametrize("theta_deg", [0.0, 45.0, 75.0])
def test_a_pane_of_dielectric_is_radiances(theta_deg: float, tmp_path: Path) -> None:
    """Two boundaries, all reflections between them, absorption on the way."""
    text = sheet_scenario(
        'kind = "dielectric"\nindex = 1.5\ntransmission_per_mm = 0.98',
        sample='kind = "window-glass"\nthickness_mm = 4.0\nsize_mm = 400.0',
    )
    found = reflected_and_transmitted(goniophotometer(text, (theta_deg, 0.0), tmp_path), 4 * PHOTONS)
    pane = sheet("void dielectric m\n0\n0\n5 0.98 0.98 0.98 1.5 0")
    pane += "m polygon back\n0\n0\n12 -1e4 -1e4 -4 -1e4 1e4 -4 1e4 1e4 -4 1e4 -1e4 -4\n"
    for share, through in zip(found, (False, True), strict=True):
        expected = ideal_part(pane, theta_deg, through=through, where=tmp_path)
        assert share == pytest.approx(expected, abs=4 * 0.5 / np.sqrt(4 * PHOTONS))
