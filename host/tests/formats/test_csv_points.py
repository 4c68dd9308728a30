"""test_csv_points.py: the plain table gives every point back."""

import csv
from pathlib import Path

import numpy as np
from synthetic_bsdf import lambert_and_mirror

from gonio.formats import csv_points


def test_every_point_comes_back(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((30.0,))
    path = tmp_path / "points.csv"
    total = csv_points.write(dataset, path)
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    d = dataset.distributions[0]
    assert len(rows) == total == len(d.theta_deg)
    np.testing.assert_allclose([float(r["theta_s_deg"]) for r in rows], d.theta_deg, atol=1e-5)
    found = np.array([float(r["dsf_per_sr"] or "nan") for r in rows])
    np.testing.assert_allclose(found, d.dsf_per_sr, rtol=1e-8)
    bsdf = np.array([float(r["bsdf_per_sr"] or "nan") for r in rows])
    np.testing.assert_allclose(bsdf, d.dsf_per_sr / np.abs(np.cos(np.radians(d.theta_deg))), rtol=1e-6)
    masked = {r["flags"] for r, m in zip(rows, d.measured, strict=True) if not m}
    assert masked == {"shadowed"}
    assert {r["flags"] for r, m in zip(rows, d.measured, strict=True) if m} == {""}
