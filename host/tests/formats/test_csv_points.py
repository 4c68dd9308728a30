"""test_csv_points.py: the plain table gives every point back, to the last bit; others' tables are read with care."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_bsdf import lambert_and_mirror

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.effects import effect_of
from gonio.dataset.uncertainty import combined_u_per_sr
from gonio.formats.tables import csv_read
from gonio.formats.tables import csv_write as csv_points
from gonio.units.errors import UsageError

ANGLES = "theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg"


def table_of(path: Path) -> list[dict[str, str]]:
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def test_the_table_holds_what_the_dataset_holds(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((30.0,))
    d = dataset.distributions[0]
    d.effects = {"gain_ratio": 0.003 * d.dsf_per_sr, "dark": np.where(d.measured, -1e-4, np.nan)}
    path = tmp_path / "points.csv"
    total = csv_points.write(dataset, path)
    rows = table_of(path)
    assert len(rows) == total == len(d.theta_deg)
    assert [float(r["theta_s_deg"]) for r in rows] == d.theta_deg.tolist()
    found = {name: np.array([float(r[name] or "nan") for r in rows]) for name in csv_points.HEADER[5:9]}
    np.testing.assert_array_equal(found["dsf_per_sr"], d.dsf_per_sr)
    np.testing.assert_allclose(found["u_dsf_per_sr"], 0.002 * d.dsf_per_sr, rtol=1e-11)
    combined = np.sqrt((0.002**2 + 0.003**2) * d.dsf_per_sr**2 + 1e-8)
    np.testing.assert_allclose(found["u_combined_per_sr"], combined, rtol=1e-11)
    np.testing.assert_allclose(found["bsdf_per_sr"], d.dsf_per_sr / np.abs(np.cos(np.radians(d.theta_deg))), rtol=1e-6)
    masked = {r["flags"] for r, m in zip(rows, d.measured, strict=True) if not m}
    assert masked == {"shadowed"}
    assert {r["flags"] for r, m in zip(rows, d.measured, strict=True) if m} == {""}


def test_our_own_export_comes_back_and_goes_out_the_same(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((0.0, 30.0), coarse=500)
    dataset.sample_name = "name: with; all, sorts"
    for d in dataset.distributions:
        d.wavelength_nm = 632.8
        d.effects = {"gain_ratio": 0.003 * d.dsf_per_sr, "dark": np.where(d.measured, 1e-4, np.nan)}
        d.flags[3] |= np.uint16(PointFlag.LOW_SIGNAL | PointFlag.INTERPOLATED_POSE)
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    csv_points.write(dataset, first)
    back = csv_read.read(first)
    csv_points.write(back, second)
    assert first.read_bytes() == second.read_bytes()
    for name in (*csv_points.FIELDS, "thickness_mm"):
        assert getattr(back, name) == getattr(dataset, name)
    for mine, found in zip(dataset.distributions, back.distributions, strict=True):
        for name in ("theta_deg", "phi_deg", "dsf_per_sr", "solid_angle_sr", "count", "flags"):
            np.testing.assert_array_equal(getattr(found, name), getattr(mine, name))
        assert (found.channel, found.wavelength_nm) == (mine.channel, mine.wavelength_nm)
        np.testing.assert_allclose(np.sqrt(found.variance_per_sr2), np.sqrt(mine.variance_per_sr2), rtol=1e-11)
        np.testing.assert_allclose(combined_u_per_sr(found), combined_u_per_sr(mine), rtol=1e-11)
        assert [effect_of(name).name for name in found.effects] == [csv_read.SYSTEMATIC]


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    rows=st.lists(
        st.tuples(
            st.floats(0, 180, allow_subnormal=False),
            st.floats(0, 360, exclude_max=True, allow_subnormal=False),
            st.floats(-1e6, 1e6),
            st.floats(0, 1e6, allow_subnormal=False),
        ),
        min_size=1,
        max_size=20,
    )
)
def test_any_numbers_come_back_bit_for_bit(tmp_path: Path, rows: list[tuple[float, float, float, float]]) -> None:
    theta, phi, dsf, u = (np.array(column, dtype=np.float64) for column in zip(*rows, strict=True))
    n = len(rows)
    d = Distribution(
        12.5, 300.0, theta, phi, dsf, u**2, dsf, np.ones(n), np.ones(n, np.int32), np.zeros(n, np.uint16),
        np.full(n, 1e-3), np.zeros(n, np.int64),
    )  # fmt: skip
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    csv_points.write(Dataset([d]), first)
    back = csv_read.read(first)
    (found,) = back.distributions
    assert found.theta_deg.tolist() == theta.tolist()
    assert found.phi_deg.tolist() == phi.tolist()
    assert found.dsf_per_sr.tolist() == dsf.tolist()
    csv_points.write(back, second)
    assert first.read_bytes() == second.read_bytes()


def read(tmp_path: Path, text: str | bytes) -> Dataset:
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return csv_read.read(path)


def test_the_smallest_table_of_others(tmp_path: Path) -> None:
    (d,) = read(tmp_path, f"{ANGLES},dsf_per_sr\n30,0,20,180,0.25\n30,0,-20,0,-1e-3\n").distributions
    assert (d.incident_theta_deg, d.incident_phi_deg, d.channel) == (30.0, 0.0, "visible")
    assert (d.theta_deg.tolist(), d.phi_deg.tolist()) == ([20, 20], [180, 180])
    assert d.dsf_per_sr.tolist() == [0.25, -0.001]
    np.testing.assert_allclose(np.sqrt(12 * d.variance_per_sr2), [0.01, 0.001])
    assert not d.solid_angle_sr.any()
    assert not d.effects


def test_columns_of_a_bsdf_with_uncertainty_in_any_order(tmp_path: Path) -> None:
    text = (
        "# somebody's remark: sample_name\r\n"
        "u, phi_s_deg, theta_s_deg, phi_i_deg, theta_i_deg, bsdf_per_sr, channel\r\n"
        "0.02,0,60,0,10,0.5,red\r\n0.02,0,120,0,10,0.5,blue\r\n\r\n0.02,0,60,0,20,0.5,red\r\n"
    )
    dataset = read(tmp_path, text)
    assert [(d.channel, d.incident_theta_deg) for d in dataset.distributions] == [
        ("red", 10),
        ("blue", 10),
        ("red", 20),
    ]
    for d in dataset.distributions:
        np.testing.assert_allclose(d.dsf_per_sr, 0.25)
        np.testing.assert_allclose(np.sqrt(d.variance_per_sr2), 0.01)
    assert dataset.sample_name == ""


GOOD = f"{ANGLES},dsf_per_sr,u,flags,solid_angle_sr,count\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no column theta_i_deg"),
        (f"{ANGLES}\n1,2,3,4\n", "no column dsf_per_sr or bsdf_per_sr"),
        (GOOD, "empty"),
        (GOOD + "1,2,3,4,5,6\n", "line 2 has 6 cells instead of 9"),
        ("# x\n" + GOOD + "1,2,3,4,five,0,,,\n", "line 3: dsf_per_sr 'five' is no number"),
        (GOOD + "1,2,3,4,5,0,,,\n1,2,300,400,,0,,,\n", "line 3 holds no dsf_per_sr"),
        (GOOD + "1,2,400,4,5,0,,,\n", "an impossible theta_s_deg"),
        (GOOD + "1,2,nan,4,5,0,,,\n", "no finite theta_s_deg"),
        (GOOD + "1,2,3,4,inf,0,,,\n", "no finite dsf_per_sr"),
        (GOOD + "1,2,3,4,5,-1,,,\n", "no or a negative u"),
        (GOOD + "1,2,3,4,5,,,,\n", "no or a negative u"),
        (GOOD + "1,2,3,4,5,0,shaded,,\n", "no flag is called 'shaded'"),
        (GOOD + "1,2,3,4,5,0,,99,\n", "an impossible solid_angle_sr"),
        (GOOD + "1,2,3,4,5,0,,,1.5\n", "an impossible count"),
        (f"{ANGLES},dsf_per_sr,dsf_per_sr\n1,2,3,4,5,6\n", "names a column twice"),
        ("# gonio points\n# front_faces: up\n" + GOOD + "1,2,3,4,5,0,,,\n", "front_faces 'up' is none of"),
        ("# gonio points\n# thickness_mm: thin\n" + GOOD + "1,2,3,4,5,0,,,\n", "no length"),
        (GOOD + '1,2,3,4,5,0,"a\nb",,\n', "no table of points|not readable"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)


def test_a_raw_signal_is_not_written(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((30.0,), coarse=500)
    dataset.distributions[0].p_i = np.nan
    with pytest.raises(UsageError, match=r"raw signal \(unit counts\), not normalised"):
        csv_points.write(dataset, tmp_path / "x.csv")
    assert not list(tmp_path.iterdir())
