"""test_integrals.py: hemispheres, holes and cones against closed forms and published data."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from signature_scene import circles, distribution, spiral

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.formats.tables import nist as nist_csv
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, tangent_frame, unit_from_angles_deg
from gonio.reduce.imported import reduce_dataset
from gonio.reduce.integrals.cones import cone, cone_solid_angle_sr
from gonio.reduce.integrals.fill import fill_holes
from gonio.reduce.integrals.hemispheres import evaluated, zero_forty_five

FloatArray = NDArray[np.float64]
NIST = Path(__file__).resolve().parents[3] / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"


def lattice(n: int, limit_deg: float = 90.0) -> FloatArray:
    """Directions (n, 3) of a Fibonacci lattice over the cap that ends at `limit_deg`."""
    z = 1.0 - (1.0 - np.cos(np.radians(limit_deg))) * (np.arange(n) + 0.5) / n
    phi = np.arange(n) * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z * z)
    return np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)


def lambertian(limit_deg: float, n: int = 4000, reflectance: float = 0.8) -> Distribution:
    unit = lattice(n, limit_deg)
    return imported(*angles_deg_from_unit(unit), reflectance / np.pi * unit[:, 2])


def imported(theta: FloatArray, phi: FloatArray, dsf: FloatArray) -> Distribution:
    n = len(theta)
    return Distribution(
        incident_theta_deg=0.0,
        incident_phi_deg=0.0,
        theta_deg=theta,
        phi_deg=phi,
        dsf_per_sr=dsf,
        variance_per_sr2=np.zeros(n),
        signal=dsf,
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=np.zeros(n),
        time_ns=np.zeros(n, dtype=np.int64),
    )


def masked(d: Distribution, hole: NDArray[np.bool_]) -> Distribution:
    d.flags[hole] = PointFlag.SHADOWED
    d.dsf_per_sr[hole] = np.nan
    d.variance_per_sr2[hole] = np.nan
    return d


def lobe(unit: FloatArray, about: tuple[float, float], sigma_deg: float, integral: float) -> FloatArray:
    off = angle_between_deg(unit, unit_from_angles_deg(*about)) / sigma_deg
    return np.asarray(integral * np.exp(-0.5 * off**2) / (2.0 * np.pi * np.radians(sigma_deg) ** 2))


def shiny(unit: FloatArray) -> FloatArray:
    """A Lambertian of 0.4, a narrow lobe of 0.2 and a broad one."""
    return np.asarray(
        0.4 / np.pi * np.maximum(unit[:, 2], 0.0)
        + lobe(unit, (30.0, 180.0), 1.2, 0.2)
        + lobe(unit, (35.0, 100.0), 12.0, 0.1)
    )


def over_hemisphere(function: Callable[[FloatArray], FloatArray]) -> float:
    nodes = lattice(1_000_000)
    return float(function(nodes).sum() * 2.0 * np.pi / len(nodes))


def scan(limit_deg: float, pitch_deg: float = 2.5, noise_per_sr: float = 0.0) -> Distribution:
    """Circles over the reflected hemisphere out to `limit_deg`, and a spiral about the mirror direction (30, 180)."""
    parts = [circles(pitch_deg, limit_deg), spiral((30.0, 180.0), 6.0, 0.2, 0.1)]
    path = np.repeat([0, 1], [len(part) for part in parts])
    unit = np.concatenate(parts)
    return distribution((30.0, 0.0), unit, shiny(unit), path, noise_per_sr)


@pytest.mark.parametrize("limit_deg", [20.0, 50.0, 80.0])
def test_reflectance_over_the_covered_part_of_a_lambertian_is_its_share(limit_deg: float) -> None:
    """Closed form: rho sin^2(limit); points own no more than 1.5 times their distance beyond."""
    found = reduce_dataset(Dataset([lambertian(limit_deg)])).distributions[0].integrals
    least, most = (np.sin(np.radians(limit)) ** 2 for limit in (limit_deg, limit_deg + 4.0))
    assert least < found["rho_measured_share"] < most
    assert found["rho_measured"] == pytest.approx(0.8 * found["rho_measured_share"], rel=1e-9)
    uncovered = 2.0 * np.pi - found["measured_share_front"] * 2.0 * np.pi
    assert found["uncovered_sr_front"] == pytest.approx(uncovered, rel=1e-9)


def test_nothing_is_guessed_far_from_every_point() -> None:
    found = reduce_dataset(Dataset([lambertian(50.0)])).distributions[0].integrals
    assert found["unfilled_sr_front"] == found["uncovered_sr_front"] > 1.0
    assert found["rho_estimate"] == found["rho_measured"]


def test_cosine_over_an_irregular_path_of_100000_points_is_within_a_hundredth_of_a_percent() -> None:
    """Circles of wavering pitch with jitter in both angles; the integral of the DSF cos(theta) / pi is 1."""
    rng = np.random.default_rng(5)
    theta = np.repeat(np.linspace(0.0, 90.0, 318)[1:-1], 317)[:100_000]
    theta = np.clip(theta + 0.08 * np.sin(theta) + rng.uniform(-0.1, 0.1, len(theta)), 0.0, 89.999)
    phi = np.arange(len(theta)) * (360.0 / 317.0) * 1.0007 + rng.uniform(-0.3, 0.3, len(theta))
    unit = unit_from_angles_deg(theta, phi)
    d = distribution((0.0, 0.0), unit, unit[:, 2] / np.pi)
    found = evaluated(d).values
    assert found["rho_measured"] == pytest.approx(1.0, rel=1e-4)
    assert abs(found["rho_voronoi"] - 1.0) <= 1e-4
    assert found["rho_quadrature"] < 1e-4


def test_a_constant_is_not_corrected_whatever_is_masked() -> None:
    """Around masks V and P1 lack different areas: that is no curvature, and must not look like one."""
    unit = lattice(3000)
    d = distribution((0.0, 0.0), unit, np.full(len(unit), 0.3), np.full(len(unit), -1))
    rng = np.random.default_rng(2)
    hole = (rng.random(len(unit)) < 0.05) | (angle_between_deg(unit, unit_from_angles_deg(40.0, 10.0)) < 8.0)
    found = evaluated(masked(d, hole)).values
    assert found["rho_measured"] == pytest.approx(0.3 * d.solid_angle_sr[~hole].sum(), rel=1e-12)
    assert found["rho_quadrature"] < 1e-12


@pytest.mark.parametrize("shade_deg", [2.5, 5.0, 7.5])
def test_a_hole_is_filled_with_an_uncertainty_that_holds(shade_deg: float) -> None:
    whole = over_hemisphere(shiny)
    d = scan(90.0)
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    hole = angle_between_deg(unit, unit_from_angles_deg(30.0, 0.0)) < shade_deg
    truth = float(shiny(unit[hole]) @ d.solid_angle_sr[hole])
    found = evaluated(masked(d, hole)).values
    missed = found["rho_filled"] - truth
    assert abs(missed) < 2.0 * found["rho_filled_u"]
    assert abs(missed) < 0.01 * truth
    assert found["rho_filled_u"] < 0.1 * truth
    assert found["rho_estimate"] == pytest.approx(found["rho_measured"] + found["rho_filled"], rel=1e-12)
    assert abs(found["rho_estimate"] - whole) < 2.0 * found["rho_estimate_u"]
    assert found["masked_sr_front"] == pytest.approx(d.solid_angle_sr[hole].sum(), rel=1e-12)


def test_a_peak_in_a_hole_is_unknown_and_the_uncertainty_does_not_pretend() -> None:
    """A lobe half hidden: the model cannot know it, its trials next to the hole can, as the lobe's flank is steep."""
    d = scan(90.0)
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    hole = angle_between_deg(unit, unit_from_angles_deg(30.0, 186.0)) < 3.0
    truth = float(shiny(unit[hole]) @ d.solid_angle_sr[hole])
    found = evaluated(masked(d, hole)).values
    assert abs(found["rho_filled"] - truth) < 3.0 * found["rho_filled_u"]


@pytest.mark.parametrize("beside_deg", [4.5, 6.0])
def test_a_hole_beside_a_bright_narrow_peak_is_honest(beside_deg: float) -> None:
    """The straight-through beam of paper [1], 400/sr within a degree, in the ring about a hole of 3 degrees: no value
    leaves the range of the ring, and the uncertainty tells."""
    parts = [circles(2.0, 90.0), spiral((30.0, 180.0), 3.0, 0.1, 0.1)]
    unit = np.concatenate(parts)
    dsf = 0.3 / np.pi * unit[:, 2] + lobe(unit, (30.0, 180.0), 0.4, 0.12)
    d = distribution((30.0, 0.0), unit, dsf, np.repeat([0, 1], [len(part) for part in parts]))
    hole = angle_between_deg(unit, unit_from_angles_deg(30.0 - beside_deg, 180.0)) < 3.0
    truth = float(dsf[hole] @ d.solid_angle_sr[hole])
    found = evaluated(masked(d, hole)).values
    assert found["rho_filled"] > 0.0
    assert abs(found["rho_filled"] - truth) < 2.0 * found["rho_filled_u"]
    assert found["rho_filled_u"] < 0.12


def test_a_hole_at_the_horizon() -> None:
    """Closed form of a Lambertian: 0.8 / pi times the hole's projected solid angle; there the DSF falls to 0."""
    d = scan(90.0)
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    d.dsf_per_sr = 0.8 / np.pi * unit[:, 2]
    hole = (d.theta_deg > 84.0) & (d.phi_deg < 90.0)
    truth = float(d.dsf_per_sr[hole] @ d.solid_angle_sr[hole])
    found = evaluated(masked(d, hole)).values
    assert found["rho_filled"] == pytest.approx(truth, rel=0.1)
    assert abs(found["rho_filled"] - truth) < found["rho_filled_u"] < 3.0 * truth


def test_a_fill_keeps_a_constant_and_no_value_leaves_the_range() -> None:
    d = scan(90.0)
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    hole = angle_between_deg(unit, unit_from_angles_deg(40.0, 100.0)) < 6.0
    fill = fill_holes(masked(d, hole), unit, np.ones(len(unit), dtype=bool))
    assert (fill.weight >= 0.0).all()
    assert fill.weight.sum() == pytest.approx(d.solid_angle_sr[hole].sum(), rel=1e-9)
    assert not fill.weight[hole].any()


def test_holes_of_sets_that_lie_over_each_other() -> None:
    """Two sets of tracks, as a merge leaves them, with holes apart and one in both."""
    parts = [circles(2.0, 90.0), circles(3.0, 90.0, 0.7)]
    unit = np.concatenate(parts)
    number = np.repeat([0, 1], [len(part) for part in parts])
    d = distribution((30.0, 0.0), unit, 0.8 / np.pi * unit[:, 2], number)
    both = angle_between_deg(unit, unit_from_angles_deg(50.0, 20.0)) < 4.0
    one = (angle_between_deg(unit, unit_from_angles_deg(30.0, 200.0)) < 4.0) & (number == 0)
    found = evaluated(masked(d, both | one)).values
    assert abs(found["rho_estimate"] - 0.8) < 2.0 * found["rho_estimate_u"] + 2e-4
    assert found["rho_filled_u"] < 5e-3


def test_all_masked_is_no_result() -> None:
    d = scan(90.0)
    found = evaluated(masked(d, np.ones(len(d.dsf_per_sr), dtype=bool))).values
    assert not any(name.startswith("rho_") for name in found)


def test_an_outermost_track_owns_what_it_reaches() -> None:
    """Its cells reach 1.5 pitches out with the value of their point: of a DSF that falls by 1/rad that is a track's
    length times the square of the pitch too much, and no uncertainty tells."""
    whole = over_hemisphere(shiny)
    found = evaluated(scan(84.0)).values
    assert found["uncovered_sr_front"] == pytest.approx(2.0 * np.pi * np.cos(np.radians(83.75 + 3.75)), rel=0.01)
    assert found["unfilled_sr_front"] == 0.0
    assert "coverage" not in evaluated(scan(84.0)).budgets["rho"]
    too_much = 0.4 / np.pi * 2.0 * np.pi * np.radians(2.5) ** 2
    assert found["rho_estimate"] - whole == pytest.approx(too_much, rel=0.2)


def test_uncertainties_add_up_as_their_budgets_say() -> None:
    d = scan(90.0, noise_per_sr=0.01)
    d.p_i_u_rel = 2e-3
    d.effects = {"lamp": 3e-3 * d.dsf_per_sr, "dark": np.full(len(d.dsf_per_sr), 1e-4)}
    results = evaluated(d)
    value, budget = results.values["rho_measured"], results.budgets["rho"]
    assert budget["lamp"] == pytest.approx(3e-3 * value, rel=1e-9)
    assert budget["p_i"] == pytest.approx(2e-3 * value, rel=1e-9)
    assert budget["dark"] == pytest.approx(1e-4 * 2.0 * np.pi, rel=1e-3)
    weight = 2.0 * d.solid_angle_sr - d.linear_solid_angle_sr
    assert budget["independent"] == pytest.approx(0.01 * np.linalg.norm(weight), rel=1e-3)
    for name, parts in results.budgets.items():
        assert results.values[f"{name}_u"] == pytest.approx(np.linalg.norm(list(parts.values())), rel=1e-12)
    names = {name.removesuffix("_u") for name in results.values if name.endswith("_u")}
    assert names == set(results.budgets)


def test_noise_alone_is_no_quadrature_error() -> None:
    rng = np.random.default_rng(4)
    unit = lattice(2000)
    d = distribution((0.0, 0.0), unit, np.zeros(len(unit)), np.full(len(unit), -1), 0.1)
    left = []
    for _ in range(10):
        noise = 0.1 * rng.standard_normal(len(unit))
        noisy = replace(d, dsf_per_sr=noise, flags=d.flags.copy(), variance_per_sr2=d.variance_per_sr2.copy())
        found = evaluated(masked(noisy, rng.random(len(unit)) < 0.1))
        left.append(found.values["rho_quadrature"] < found.budgets["rho"]["independent"])
    assert np.mean(left) >= 0.9


def test_points_in_one_plane_cover_a_strip() -> None:
    theta = np.arange(2.0, 80.0, 2.0)
    both = np.concatenate((theta, theta))
    phi = np.repeat([30.0, 210.0], len(theta))
    dsf = np.cos(np.radians(both)) / np.pi
    found = reduce_dataset(Dataset([imported(both, phi, dsf)])).distributions[0].integrals
    assert found["rho_measured_share"] < 0.12
    assert found["rho_measured"] == pytest.approx(found["rho_measured_share"], rel=1e-6)


def test_nist_ptfe_reflects_less_than_all_light_over_the_covered_part() -> None:
    """Sintered PTFE reflects 0.97 to 0.995 of the visible (V. R. Weidner and J. J. Hsia, J. Opt. Soc. Am. 71, 1981)."""
    found = reduce_dataset(nist_csv.read(NIST)).distributions
    normal = [d.integrals for d in found if d.incident_theta_deg < 1.0]
    assert len(normal) == 4
    for of_wavelength in normal:
        assert 0.96 < of_wavelength["rho_measured_share"] <= 1.0
        assert 0.97 < of_wavelength["rho_measured"] / of_wavelength["rho_measured_share"] < 0.995
    assert all(d.integrals["rho_measured"] < 0.995 for d in found)


def test_zero_forty_five_of_a_lambertian_is_its_reflectance() -> None:
    d = lambertian(80.0)
    assert zero_forty_five(d) == pytest.approx(0.8, rel=1e-9)
    d.incident_theta_deg = 8.0
    assert zero_forty_five(d) is None


@pytest.mark.parametrize("axis_deg", [0.0, 30.0, 80.0, 85.0, 90.0])
@pytest.mark.parametrize("half_angle_deg", [2.5, 7.0, 40.0])
def test_solid_angle_of_a_cone_above_the_horizon(axis_deg: float, half_angle_deg: float) -> None:
    """Counted on a lattice over the cone."""
    cap = lattice(100_000, half_angle_deg)
    turned = cap @ tangent_frame(unit_from_angles_deg(axis_deg, 77.0))
    counted = np.mean(turned[:, 2] > 1e-12) * 2.0 * np.pi * (1.0 - np.cos(np.radians(half_angle_deg)))
    assert cone_solid_angle_sr(np.cos(np.radians(axis_deg)), half_angle_deg) == pytest.approx(counted, rel=1e-3)


@pytest.mark.parametrize(("half_angle_deg", "within"), [(3.0, 2e-3), (7.0, 1e-3), (20.0, 3e-4)])
def test_a_cone_of_a_lambertian_has_its_closed_form(half_angle_deg: float, within: float) -> None:
    """The integral of cos(theta) over a cone about a direction at theta0: pi sin^2(half angle) cos(theta0)."""
    d = reduce_dataset(Dataset([lambertian(90.0, 20_000, 1.0)])).distributions[0]
    truth = np.sin(np.radians(half_angle_deg)) ** 2 * np.cos(np.radians(40.0))
    assert cone(d, (40.0, 200.0), half_angle_deg).value == pytest.approx(truth, rel=within)


def test_a_cone_about_a_lobe_holds_its_share() -> None:
    """A Gaussian of the angle: 1 - exp(-7^2 / 2 / 3^2) within 7 degrees, to the flatness of the sphere."""
    unit = spiral((150.0, 180.0), 14.0, 0.25, 0.2)
    d = distribution((30.0, 0.0), unit, lobe(unit, (150.0, 180.0), 3.0, 0.4))
    results = evaluated(d)
    assert results.values["cone through 7"] == pytest.approx(0.4 * (1.0 - np.exp(-0.5 * (7.0 / 3.0) ** 2)), rel=2e-3)
    assert results.values["cone through 7_measured_share"] == pytest.approx(1.0, abs=2e-3)
    assert "cone through 7" in results.budgets
    assert "cone mirror 7" not in results.values  # nothing was measured there


def test_a_cone_must_have_an_angle() -> None:
    with pytest.raises(ValueError, match="between 0 and 90 degrees, not 0"):
        cone(lambertian(80.0), (0.0, 0.0), 0.0)
