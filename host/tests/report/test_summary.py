"""test_summary.py: summary.json holds measurement, truth and differences; covered values are those of closed forms."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_bsdf import SIGMA_DEG, distribution, lambert_and_mirror, sphere_points
from test_report_html import KnownTruth

from gonio.dataset.bsdf import PointFlag
from gonio.report.covered import covered_reflectance, zero_forty_five
from gonio.report.summary import write_summary
from gonio.report.truth import expected_peaks


def test_differences_are_measured_minus_truth(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((30.0,))
    dataset.distributions[0].integrals = {
        "rho": 0.707,
        "tau": 0.1,
        "rho_u": float("nan"),
        "peak mirror theta_deg": 30.01,
        "peak mirror phi_deg": 180.0,
        "peak mirror sigma_deg": SIGMA_DEG * 1.02,
        "peak mirror integral": 0.199,
    }
    path = tmp_path / "summary.json"
    write_summary(dataset, path, truth=KnownTruth())
    entry = json.loads(path.read_text())["distributions"][0]
    differences = entry["differences"]
    assert differences["integrals"]["rho"]["relative"] == pytest.approx(0.01)
    assert differences["integrals"]["tau"]["absolute"] == pytest.approx(0, abs=1e-12)
    assert differences["peaks"]["mirror"]["direction_deg"] == pytest.approx(0.01, rel=1e-6)
    assert differences["peaks"]["mirror"]["sigma"]["relative"] == pytest.approx(0.02)
    assert differences["peaks"]["mirror"]["integral"]["relative"] == pytest.approx(-0.005)
    assert entry["truth"]["integrals"] == {"rho": 0.7, "tau": 0.1}
    assert entry["integrals"]["rho_u"] is None
    assert entry["points"] > entry["measured_points"]


def test_without_truth_there_are_no_differences(tmp_path: Path) -> None:
    summary = write_summary(lambert_and_mirror((0.0,)), tmp_path / "summary.json")
    assert "differences" not in summary["distributions"][0]
    assert summary["sample"].startswith("synthetic")


def test_two_lobes_about_one_direction_have_no_single_answer() -> None:
    truth = KnownTruth()
    truth.scenario = SimpleNamespace(components=(*KnownTruth.scenario.components, KnownTruth.scenario.components[1]))
    assert expected_peaks(truth, 30.0, 0.0) == {}
    truth.scenario = SimpleNamespace(components=({"kind": "straight-through", "transmittance": 0.3},))
    peak = expected_peaks(truth, 30.0, 0.0)["through"]
    assert (peak.theta_deg, peak.phi_deg, peak.integral) == (150.0, 180.0, 0.3)


@pytest.mark.parametrize("limit_deg", [50.0, 80.0])
def test_covered_reflectance_of_a_lambertian_is_its_share(limit_deg: float) -> None:
    """Closed form: rho sin^2(limit)."""
    d = distribution((0, 0), sphere_points(4000), lambda u: 0.8 / np.pi * np.abs(u[:, 2]))
    d.flags[d.theta_deg > limit_deg] = PointFlag.UNREACHABLE
    covered = covered_reflectance(d)
    assert covered.limit_deg == pytest.approx(limit_deg, abs=1.0)
    assert covered.share == pytest.approx(np.sin(np.radians(covered.limit_deg)) ** 2)
    assert covered.value == pytest.approx(0.8 * covered.share, rel=1e-9)


def test_zero_forty_five_of_a_lambertian_is_its_reflectance() -> None:
    d = distribution((0, 0), sphere_points(4000), lambda u: 0.8 / np.pi * np.abs(u[:, 2]))
    assert zero_forty_five(d) == pytest.approx(0.8, rel=1e-9)
    d.incident_theta_deg = 8.0
    assert zero_forty_five(d) is None
