"""test_integrals.py: sums over the measured part of a hemisphere, and 0:45, against closed forms and published data."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.formats import nist_csv
from gonio.geometry.directions import angles_deg_from_unit
from gonio.reduce.integrals.hemispheres import zero_forty_five
from gonio.reduce.pipeline import reduce_dataset

NIST = Path(__file__).resolve().parents[3] / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"


def lambertian(limit_deg: float, n: int = 4000, reflectance: float = 0.8) -> Distribution:
    """A Fibonacci lattice of the cap that ends at `limit_deg`."""
    z = 1.0 - (1.0 - np.cos(np.radians(limit_deg))) * (np.arange(n) + 0.5) / n
    phi = np.arange(n) * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z * z)
    theta_deg, phi_deg = angles_deg_from_unit(np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1))
    return measured(theta_deg, phi_deg, reflectance / np.pi * z)


def measured(theta: NDArray[np.float64], phi: NDArray[np.float64], dsf: NDArray[np.float64]) -> Distribution:
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


@pytest.mark.parametrize("limit_deg", [20.0, 50.0, 80.0])
def test_reflectance_over_the_covered_part_of_a_lambertian_is_its_share(limit_deg: float) -> None:
    """Closed form: rho sin^2(limit); the lattice's outermost points lie a little inside."""
    found = reduce_dataset(Dataset([lambertian(limit_deg)])).distributions[0].integrals
    share = np.sin(np.radians(limit_deg)) ** 2
    assert found["rho_measured_share"] == pytest.approx(share, rel=0.015)
    assert found["rho_measured_share"] < share
    assert found["rho_estimate"] == pytest.approx(0.8 * found["rho_measured_share"], rel=1e-12)


def test_masked_points_are_in_the_value_but_not_in_the_measured_share() -> None:
    d = lambertian(80.0)
    d.flags[d.theta_deg < 5.0] = PointFlag.SHADOWED
    d.dsf_per_sr[d.theta_deg < 5.0] = np.nan
    found = reduce_dataset(Dataset([d])).distributions[0].integrals
    whole = reduce_dataset(Dataset([lambertian(80.0)])).distributions[0].integrals
    hole = np.sin(np.radians(5.0)) ** 2
    assert whole["rho_measured_share"] - found["rho_measured_share"] == pytest.approx(hole, rel=0.05)
    assert found["rho_measured"] == pytest.approx(0.8 * found["rho_measured_share"], rel=1e-12)
    assert found["rho_estimate"] == pytest.approx(whole["rho_estimate"], rel=1e-3)


def test_points_in_one_plane_cover_nothing() -> None:
    theta = np.arange(2.0, 80.0, 2.0)
    both = np.concatenate((theta, theta))
    phi = np.repeat([30.0, 210.0], len(theta))
    found = reduce_dataset(Dataset([measured(both, phi, np.cos(np.radians(both)) / np.pi)])).distributions[0]
    assert not [name for name in found.integrals if name.startswith(("rho", "tau"))]  # no value, not a zero


def test_nist_ptfe_reflects_less_than_all_light_over_the_covered_part() -> None:
    """Sintered PTFE reflects 0.97 to 0.995 of the visible (V. R. Weidner and J. J. Hsia, J. Opt. Soc. Am. 71, 1981);
    the table's outermost points, at 80 and 82 degrees, surround 97 % of the cosine-weighted hemisphere."""
    found = reduce_dataset(nist_csv.read(NIST)).distributions
    normal = [d.integrals for d in found if d.incident_theta_deg < 1.0]
    assert len(normal) == 4
    for of_wavelength in normal:
        assert of_wavelength["rho_measured_share"] == pytest.approx(0.970, abs=0.001)
        assert 0.97 < of_wavelength["rho_estimate"] / of_wavelength["rho_measured_share"] < 0.995
    assert all(d.integrals["rho_estimate"] < 0.97 for d in found)


def test_zero_forty_five_of_a_lambertian_is_its_reflectance() -> None:
    d = lambertian(80.0)
    assert zero_forty_five(d) == pytest.approx(0.8, rel=1e-9)
    d.incident_theta_deg = 8.0
    assert zero_forty_five(d) is None
