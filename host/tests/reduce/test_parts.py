"""test_parts.py: regular and diffuse parts, openness and haze of closed-form samples seen through beam and aperture."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from signature_scene import beam_scan, circles, distribution, spiral, truth_of

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import mirror, through
from gonio.reduce.integrals.cones import cone
from gonio.reduce.integrals.hemispheres import evaluated
from gonio.reduce.integrals.parts import regular_part
from gonio.reduce.integrals.quadrature import side_weights
from gonio.reduce.signature.profile import BeamProfile
from gonio.simulate.closed_form import Truth

SCREEN = '{ kind = "straight-through", transmittance = 0.05 }, { kind = "lambertian", transmittance = 0.1 }'


def measured(
    truth: Truth,
    incident_deg: tuple[float, float],
) -> Distribution:
    """Transmitted hemisphere with a spiral about straight through."""
    about = tuple(float(angle) for angle in through(*incident_deg))
    coarse = circles(2.0)
    parts = [coarse[coarse[:, 2] < 0.0], spiral((about[0], about[1]), 3.5, 0.08, 0.05)]
    path = np.repeat([0, 1], [len(part) for part in parts])
    unit = np.concatenate(parts)
    return distribution(incident_deg, unit, truth.dsf_per_sr(*incident_deg, unit), path)


@pytest.mark.parametrize("incident_deg", [(0.0, 0.0), (40.0, 0.0)])
def test_regular_and_diffuse_part_of_a_screen(incident_deg: tuple[float, float], tmp_path: Path) -> None:
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    results = evaluated(measured(truth, incident_deg), beam=beam)
    found = results.values
    assert found["tau_direct"] == pytest.approx(0.05, rel=5e-4)
    assert found["tau_diffuse"] == pytest.approx(0.1, rel=1e-3)
    assert found["tau_direct"] + found["tau_diffuse"] == pytest.approx(found["tau_measured"], rel=1e-3)
    assert found["tau_direct_off_deg"] < 5e-3
    assert found["tau_direct_half_angle_deg"] > 1.0
    assert ("openness" in found) == (incident_deg[0] == 0.0)
    if "openness" in found:
        assert found["openness"] == found["tau_direct"]
        # Of the diffuse 0.1, sin^2(2.5 degrees) lies within 2.5 degrees; the regular part makes no haze.
        assert found["haze"] == pytest.approx(0.1 * np.cos(np.radians(2.5)) ** 2 / 0.15, rel=3e-3)
        assert "haze" in results.budgets
        assert "p_i" not in results.budgets["haze"] or results.budgets["haze"]["p_i"] < 1e-12


def test_a_regular_part_off_its_ideal_direction_is_found(tmp_path: Path) -> None:
    """The beam of the reference scan stands 0.1 degrees off; the sample's regular part does not."""
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth, off_deg=0.1)
    found = evaluated(measured(truth, (0.0, 0.0)), beam=beam).values
    assert found["tau_direct"] == pytest.approx(0.05, rel=1e-3)
    assert found["tau_direct_off_deg"] == pytest.approx(0.1, abs=5e-3)


def test_a_diffuse_lobe_is_no_regular_part(tmp_path: Path) -> None:
    truth = truth_of(tmp_path, '{ kind = "gaussian", about = "through", sigma_deg = 6.0, integral = 0.3 }')
    _, beam = beam_scan(truth)
    found = evaluated(measured(truth, (0.0, 0.0)), beam=beam).values
    assert abs(found["tau_direct"]) < 2e-4
    assert found["tau_diffuse"] == pytest.approx(0.3, rel=5e-3)
    assert found["haze"] == pytest.approx(np.exp(-0.5 * (2.5 / 6.0) ** 2), abs=0.01)


def test_a_lobe_hardly_wider_than_the_beam_is_no_regular_part(tmp_path: Path) -> None:
    """Shape alone tells a lobe of 1.2 degrees from the beam of 1 degree: what it cannot tell is in the uncertainty."""
    truth = truth_of(tmp_path, '{ kind = "gaussian", about = "mirror", sigma_deg = 1.2, integral = 0.2 }')
    _, beam = beam_scan(truth)
    unit = spiral((30.0, 180.0), 5.0, 0.15, 0.05)
    found = evaluated(distribution((30.0, 0.0), unit, truth.dsf_per_sr(30.0, 0.0, unit)), beam=beam).values
    assert abs(found["rho_direct"]) < found["rho_direct_u"] < 3e-3
    assert abs(found["rho_direct"]) < 5e-4
    assert found["rho_direct_off_deg"] == 0.0


def test_where_the_regular_part_lies_is_no_part_of_its_share(tmp_path: Path) -> None:
    """Every axis off by as much: the truth is moved, the share stays; of the second order the points' columns, which
    keep the beam where it is, would make 0.1 to 1 %."""
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    unit = spiral((180.0, 0.0), 3.0, 0.08, 0.05)
    shares = []
    for off_deg in (0.0, 0.02):
        seen = truth.dsf_per_sr(0.0, 0.0, unit @ _turn(off_deg).T)
        shares.append(evaluated(distribution((0.0, 0.0), unit, seen), beam=beam).values["tau_direct"])
    assert shares[1] == pytest.approx(shares[0], rel=3e-4)
    d = distribution((0.0, 0.0), unit, truth.dsf_per_sr(0.0, 0.0, unit))
    moved = [truth.dsf_per_sr(0.0, 0.0, unit @ _turn(sign * 0.02).T) for sign in (1.0, -1.0)]
    d.effects = {"axis x": 0.5 * (moved[0] - moved[1]), "axis_second": 0.5 * (moved[0] + moved[1]) - d.dsf_per_sr}
    budget = evaluated(d, beam=beam).budgets["tau_direct"]
    assert budget["axis x"] < 3e-4 * shares[0]
    assert "axis_second" not in budget


def test_haze_beside_coarse_tracks(tmp_path: Path) -> None:
    """A spiral that ends at 2.5 degrees: its last turn owns directions far outside the cone of the haze."""
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    coarse = circles(6.0)
    paths = [coarse[coarse[:, 2] < 0.0], spiral((180.0, 0.0), 2.5, 0.1, 0.05)]
    unit = np.concatenate(paths)
    number = np.repeat([0, 1], [len(part) for part in paths])
    seen = distribution((0.0, 0.0), unit, truth.dsf_per_sr(0.0, 0.0, unit), number)
    constant = replace(seen, dsf_per_sr=np.ones(len(unit)), linear_solid_angle_sr=np.zeros(0))
    for half_angle_deg in (2.0, 2.5, 3.0, 5.0, 7.0):
        cone_sr = 2.0 * np.pi * (1.0 - np.cos(np.radians(half_angle_deg)))
        assert cone(constant, (180.0, 0.0), half_angle_deg).value == pytest.approx(cone_sr, rel=0.01)
    found = evaluated(seen, beam=beam).values
    assert found["haze"] == pytest.approx(0.1 * np.cos(np.radians(2.5)) ** 2 / 0.15, rel=2e-3)


def test_noise_of_the_regular_part_is_that_of_repeats(tmp_path: Path) -> None:
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    profile = BeamProfile.of(beam)
    unit = spiral((180.0, 0.0), 3.0, 0.12, 0.05)
    seen = truth.dsf_per_sr(0.0, 0.0, unit)
    quiet = distribution((0.0, 0.0), unit, seen, noise_per_sr=2.0)
    quiet.p_i_u_rel = 0.01
    rng = np.random.default_rng(3)
    values, stated = [], []
    for _ in range(40):
        noisy = replace(quiet, dsf_per_sr=seen + 2.0 * rng.standard_normal(len(unit)))
        weights = side_weights(noisy, unit, np.ones(len(unit), dtype=bool))
        regular = regular_part(noisy, unit, weights, profile, "through")
        assert regular is not None
        values.append(regular.share.value)
        stated.append(regular.share.independent)
        assert "p_i" not in regular.share.effects  # sample and beam were divided by the same P_i
    assert np.mean(stated) == pytest.approx(np.std(values, ddof=1), rel=0.4)
    assert np.mean(values) == pytest.approx(0.05, rel=1e-3)


def test_a_mirror_has_a_direct_reflectance(tmp_path: Path) -> None:
    """The free beam, turned over in the sample's plane, stands about the mirror direction."""
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    incident_deg = (35.0, 20.0)
    about = tuple(float(angle) for angle in mirror(*incident_deg))
    unit = spiral((about[0], about[1]), 4.0, 0.08, 0.05)
    flipped = unit * [1.0, 1.0, -1.0]
    seen = truth.dsf_per_sr(*incident_deg, flipped) / 0.05 * 0.9
    found = evaluated(distribution(incident_deg, unit, seen), beam=beam).values
    assert found["rho_direct"] == pytest.approx(0.9, rel=5e-4)
    assert "tau_direct" not in found


def test_a_coarse_pass_alone_tells_nothing_of_the_regular_part(tmp_path: Path) -> None:
    truth = truth_of(tmp_path, SCREEN)
    _, beam = beam_scan(truth)
    unit = circles(2.0)
    unit = unit[unit[:, 2] < 0.0] @ _turn(3.0)
    d = distribution((0.0, 0.0), unit / np.linalg.norm(unit, axis=1)[:, None], np.full(len(unit), 0.1))
    assert "tau_direct" not in evaluated(d, beam=beam).values


def _turn(angle_deg: float) -> np.ndarray:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
