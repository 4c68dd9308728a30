"""test_truth_beside.py: the truth put through the same sums and fits as the measurement."""

import numpy as np
import pytest
from synthetic_scan import Scan

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.geometry.directions import angle_between_deg, retro, unit_from_angles_deg
from gonio.reduce.integrals.truth_beside import beside, peak_points
from gonio.reduce.pipeline import reduce_rawlog
from gonio.simulate.closed_form import Truth

SCENARIO = """
[sample]
components = [
  { kind = "lambertian", reflectance = 0.3 },
  { kind = "gaussian", about = "mirror", sigma_deg = 1.2, integral = 0.2 },
  { kind = "gaussian", about = "retro", sigma_deg = 1.0, integral = 0.05 },
]
[beam]
kind = "focused"
divergence_deg = 1.0
edge_deg = 0.1
"""


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    path = tmp_path_factory.mktemp("beside") / "s.toml"
    path.write_text(SCENARIO)
    return Truth.from_scenario(path)


@pytest.fixture(scope="module")
def measured(truth: Truth, tmp_path_factory: pytest.TempPathFactory) -> Distribution:
    scan = Scan(truth)
    scan.dark()
    scan.reference()
    scan.coarse((30.0, 0.0), 12.0)
    scan.peak((30.0, 0.0), 6.0, 0.3)
    scan.dark()
    path = tmp_path_factory.mktemp("beside") / "m.h5"
    write_dataset(reduce_rawlog(scan.log()), path)
    return read_dataset(path).distributions[0]


def test_a_lobe_behind_the_head_is_in_neither_sum(measured: Distribution, truth: Truth) -> None:
    found, known = measured.integrals, beside(measured, truth)
    assert known["rho_truth"] == pytest.approx(0.55, abs=1e-6)
    assert known["rho_truth_measured"] < 0.51  # the retro lobe lies in the shade
    assert found["rho_measured"] == pytest.approx(known["rho_truth_measured"], rel=1e-3)
    assert found["rho_measured"] + found["rho_filled"] == pytest.approx(found["rho_estimate"], rel=1e-12)


def test_the_same_fit_is_applied_to_the_truth(measured: Distribution, truth: Truth) -> None:
    known = beside(measured, truth)
    assert known["peak mirror theta_deg_truth"] == pytest.approx(30.0, abs=1e-3)
    assert known["peak mirror sigma_deg_truth"] == pytest.approx(truth.peak_sigma_deg(1.2), rel=5e-3)
    for field in ("sigma_deg", "integral", "height_per_sr"):
        assert measured.integrals[f"peak mirror {field}"] == pytest.approx(
            known[f"peak mirror {field}_truth"], rel=1e-3
        )
    assert 0.0 < known["peak mirror direction_error_deg"] < 1e-3


def test_a_shifted_peak_shows_as_a_direction_error(measured: Distribution, truth: Truth) -> None:
    moved = dict(measured.integrals)
    moved["peak mirror theta_deg"] += 0.25
    known = beside(Distribution(**{**vars(measured), "integrals": moved}), truth)
    assert known["peak mirror direction_error_deg"] == pytest.approx(0.25, abs=1e-3)


def test_points_of_a_peak_are_those_flown_about_it(measured: Distribution) -> None:
    (part,) = peak_points(measured).values()
    unit = unit_from_angles_deg(measured.theta_deg[part], measured.phi_deg[part])
    off_deg = angle_between_deg(unit, unit_from_angles_deg(30.0, 180.0))
    assert off_deg.max() == pytest.approx(6.0, abs=0.01)
    assert off_deg.min() < 0.01
    shade = measured.flags & PointFlag.SHADOWED != 0
    near = angle_between_deg(
        unit_from_angles_deg(measured.theta_deg, measured.phi_deg), unit_from_angles_deg(*retro(30.0, 0.0))
    )
    assert np.all(near[shade] < 10.0)
