"""test_summary.py: summary.json holds measurement, truth and differences."""

import json
from pathlib import Path

import numpy as np
import pytest
from synthetic_bsdf import lambert_and_mirror, with_evaluation
from test_report_html import KnownTruth

from gonio.geometry.directions import unit_from_angles_deg
from gonio.report.summary import write_summary


def test_differences_are_measured_minus_truth(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((30.0,))
    d = dataset.distributions[0]
    d.dsf_per_sr *= 1.002
    with_evaluation(d)
    d.integrals["peak mirror 30/0 sigma_deg"] *= 1.02
    d.integrals["peak mirror 30/0 theta_deg"] += 0.01
    d.integrals["rho_u"] = float("nan")
    path = tmp_path / "summary.json"
    write_summary(dataset, path, truth=KnownTruth())
    entry = json.loads(path.read_text())["distributions"][0]
    differences = entry["differences"]
    for name in ("rho_measured", "tau_measured"):
        assert differences["integrals"][name]["relative"] == pytest.approx(0.002)
    assert differences["integrals"]["rho_estimate"]["absolute"] == pytest.approx(d.integrals["rho_estimate"] - 0.7)
    peak = differences["peaks"]["mirror 30/0"]
    assert peak["direction_deg"] == pytest.approx(0.01, abs=1e-5)
    assert peak["sigma"]["relative"] == pytest.approx(0.02, abs=1e-6)
    assert peak["integral"]["relative"] == pytest.approx(0.002, abs=1e-6)
    assert entry["truth"]["integrals"]["rho_estimate"] == 0.7
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    seen = d.measured & (unit[:, 2] > 0)
    by_hand = float(np.sum(KnownTruth().dsf_per_sr(30.0, 0.0, unit)[seen] * d.solid_angle_sr[seen]))
    assert entry["truth"]["integrals"]["rho_measured"] == pytest.approx(by_hand)
    assert entry["integrals"]["rho_u"] is None
    assert entry["points"] > entry["measured_points"]


def test_without_truth_there_are_no_differences(tmp_path: Path) -> None:
    summary = write_summary(lambert_and_mirror((0.0,)), tmp_path / "summary.json")
    assert "differences" not in summary["distributions"][0]
    assert summary["sample"].startswith("synthetic")
