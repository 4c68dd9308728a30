"""test_patch_uncertainty.py: uncertainty of Klems patches against the patch's own weights, one point at a time.

A patch value is linear in the points' DSF. Given as effects, the unit vectors of all points make the layers the weights
themselves, so that variance and correlation can be formed plainly.
"""

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_bsdf import distribution, lambert_and_mirror, lobe_per_sr, sphere_points, spiral_about

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.formats.window import patch_table
from gonio.formats.window import read as window_reader
from gonio.formats.window import write as window_xml
from gonio.formats.window.klems import BASES
from gonio.formats.window.matrices import build
from gonio.formats.window.patch_average import HemisphereProfile, hemisphere_profile, mean_profile
from gonio.formats.window.patch_uncertainty import PatchUncertainty
from gonio.units.errors import CheckFailed

BASIS = BASES["klems-half"]
SIZE = BASIS.projected_solid_angle_sr


def points(coarse: int = 260, seed: int = 1) -> Distribution:
    """Large cells that cross borders and a fine spiral, each point with a variance of its own."""
    about = (35.0, 170.0)
    units = np.concatenate([sphere_points(coarse), spiral_about(*about, 3.0, 0.6)])
    d = distribution((30, 0), units, lambda u: lobe_per_sr(u, about, 0.2) + 0.1 * np.abs(u[:, 2]), masked_below_deg=8)
    random = np.random.default_rng(seed)
    d.variance_per_sr2 = np.where(d.measured, random.uniform(0.1, 2.0, len(units)) ** 2, np.nan)
    d.p_i_u_rel = 0.0
    return d


def with_unit_effects(d: Distribution) -> Distribution:
    columns = np.where(d.measured, np.eye(len(d.theta_deg)), np.nan)
    return replace(d, effects={f"axis {k}": column for k, column in enumerate(columns)})


def profile(d: Distribution) -> HemisphereProfile:
    found = hemisphere_profile(BASIS, d, d.theta_deg, d.phi_deg)
    assert found is not None
    return found


@pytest.mark.parametrize("turned", ["plain", "shifted", "smeared"])
def test_variance_is_that_of_the_weights(turned: str) -> None:
    d = with_unit_effects(points())
    own = profile(d)
    if turned == "shifted":
        own = own.shifted(33.25)
    if turned == "smeared":
        own = own.smeared(30.0).shifted(30.0)
    values = own.patches()
    weight = np.array([values.effects[f"axis {k}"] for k in range(len(d.theta_deg))]).T
    used = d.measured
    np.testing.assert_allclose(weight[:, used] @ d.dsf_per_sr[used], values.bsdf_per_sr, rtol=1e-9)
    seen = ~values.filled
    expected = weight[:, used] ** 2 @ d.variance_per_sr2[used]
    np.testing.assert_allclose(values.variance_per_sr2[seen], expected[seen], rtol=1e-9)
    assert np.isnan(values.variance_per_sr2[values.filled]).all()
    # The energy of the hemisphere: neighbouring patches share points.
    total = (SIZE * seen) @ weight[:, used]
    assert values.total_variance == pytest.approx(float(total**2 @ d.variance_per_sr2[used]), rel=1e-9)
    apart = float((SIZE**2 * seen) @ np.nan_to_num(values.variance_per_sr2))
    assert values.total_variance > 1.1 * apart


def test_a_mean_of_two_incident_directions_averages_noise_but_not_shared_causes() -> None:
    first, second = points(seed=1), points(coarse=300, seed=2)
    first.effects = {"gain_ratio": 0.01 * first.dsf_per_sr, "dark": np.where(first.measured, 0.002, np.nan)}
    second.effects = {"gain_ratio": 0.01 * second.dsf_per_sr}
    one, two = profile(first).patches(), profile(second).patches()
    both = mean_profile([profile(first), profile(second)]).patches()
    seen = ~(one.filled | two.filled | both.filled)
    np.testing.assert_allclose(both.effects["gain_ratio"], 0.01 * both.bsdf_per_sr, rtol=1e-9)
    full = seen & (one.coverage > 0.999) & (two.coverage > 0.999)
    assert full.sum() > 30
    np.testing.assert_allclose(
        both.variance_per_sr2[full], (one.variance_per_sr2 + two.variance_per_sr2)[full] / 4, rtol=2e-3
    )
    np.testing.assert_allclose(both.effects["dark"][full], one.effects["dark"][full] / 2, rtol=2e-3)


def test_p_i_is_an_effect_where_none_speaks_of_it() -> None:
    d = points()
    d.p_i_u_rel = 0.02
    values = profile(d).patches()
    np.testing.assert_allclose(values.effects["p_i"], 0.02 * values.bsdf_per_sr, rtol=1e-9)
    stated = profile(replace(d, effects={"p_i": 0.005 * d.dsf_per_sr})).patches()
    np.testing.assert_allclose(stated.effects["p_i"], 0.005 * stated.bsdf_per_sr, rtol=1e-9)


@pytest.mark.parametrize("symmetry", ["none", "isotropic"])
def test_columns_carry_it_and_filled_ones_do_not(symmetry) -> None:  # type: ignore[no-untyped-def]
    dataset = lambert_and_mirror((30.0, 60.0), coarse=1500)
    dataset.symmetry = symmetry
    built = build(dataset, fill="nearest")
    block = built.bands["Visible"]
    for key, own in block.uncertainty.items():
        direct = np.isin(block.origin[key], (1, 2))
        known = np.isfinite(own.u_per_sr)
        assert known[:, direct].mean() > 0.95
        assert not known[:, ~direct].any()
        p_i = own.effects["p_i"]
        np.testing.assert_allclose(p_i[known], 0.001 * block.matrices[key][known], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(own.u_per_sr**2, own.variance_per_sr2 + p_i**2, rtol=1e-12)
    assert set(built.bands["Solar"].uncertainty) == set()


def bright(excess: float, **columns: float) -> Dataset:
    """Reflects 1 + excess at 30 degrees; effects are relative to the DSF."""
    dataset = lambert_and_mirror((30.0,), reflectance=0.7 + excess, transmittance=0.1, mirror=0.2)
    for d in dataset.distributions:
        d.p_i_u_rel = 0.0
        d.effects = {name: share * d.dsf_per_sr for name, share in columns.items()}
    return dataset


def test_energy_is_judged_by_what_patches_share() -> None:
    """All patches wrong by the same share: nothing averages out, in reflection and transmission together."""
    with pytest.raises(CheckFailed, match=r"by more than twice its uncertainty 0\.0[01]"):
        build(bright(0.05, gain_ratio=0.01))
    built = build(bright(0.05, gain_ratio=0.03))
    total = 1.05
    assert any(
        f"within 2 u = {2 * 0.03 * total:.3f}"[:-1] in finding.message for finding in built.findings.of("warning")
    )
    with pytest.raises(CheckFailed):  # two causes of half the size are less than one
        build(bright(0.05, gain_ratio=0.015, linearity=0.015))


def test_changes_of_opposite_sign_cancel_in_the_energy() -> None:
    dataset = bright(0.05)
    (d,) = dataset.distributions
    sign = np.where(np.cos(np.radians(d.phi_deg - d.incident_phi_deg)) > 0, 1.0, -1.0)
    d.effects = {"tilt_x": 0.2 * sign * np.where(d.measured, np.abs(np.cos(np.radians(d.theta_deg))), np.nan)}
    with pytest.raises(CheckFailed):
        build(dataset)
    d.effects = {"tilt_x": np.abs(d.effects["tilt_x"])}
    assert build(dataset).findings.codes == {"energy"}


def test_the_table_and_the_comments_say_it(tmp_path: Path) -> None:
    dataset = lambert_and_mirror((0.0, 30.0), coarse=1500)
    for d in dataset.distributions:
        d.effects = {"gain_ratio": 0.003 * d.dsf_per_sr, "axis elevation": -0.004 * d.dsf_per_sr}
    xml, table = tmp_path / "a.xml", tmp_path / "u.csv"
    built = window_xml.write(dataset, xml, assume_flat=True, uncertainty=table)
    lines = table.read_text(encoding="utf-8").splitlines()
    assert "# gain_ratio: signal: ratio of the gains" in lines
    assert "# axis elevation: scatter angle: zero of an axis" in lines
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert {row["band"] for row in rows} == {"Visible"}  # the copy says nothing new
    block = built.bands["Visible"]
    direct = sum(int(np.sum(np.isin(origin, (1, 2)))) for origin in block.origin.values())
    assert len(rows) == direct * 145
    for row in rows[:: len(rows) // 50]:
        key = row["process"], row["light_from"]
        place = int(row["outgoing_patch"]) - 1, int(row["incident_patch"]) - 1
        assert float(row["bsdf_per_sr"]) == pytest.approx(block.matrices[key][place], rel=1e-6, abs=1e-12)
        parts = [
            float(row[c]) for c in ("u_independent_per_sr", "gain_ratio per_sr", "axis elevation per_sr", "p_i per_sr")
        ]
        assert float(row["u_per_sr"]) == pytest.approx(np.linalg.norm(parts), rel=1e-6)
        assert parts[2] == pytest.approx(-4 / 3 * parts[1], rel=1e-6)
    (remark,) = [line for line in built.remarks() if "largest relative standard uncertainty" in line]
    largest = max(
        own.largest_relative(block.matrices[key])[0]  # type: ignore[index]
        for key, own in block.uncertainty.items()
    )
    assert f"{largest:.2%}" in remark
    assert remark in window_reader.read(xml).text["Comments"]
    assert 0.005 < largest < 0.02  # hypot(0.3, 0.4, 0.1) % and the noise of a few points


def test_an_empty_table_has_its_header() -> None:
    built = build(lambert_and_mirror((30.0,), coarse=800))
    for block in built.bands.values():
        block.uncertainty.clear()
    text = patch_table.render(built).decode()
    assert list(csv.reader(io.StringIO(text)))[-1][:3] == ["band", "process", "light_from"]
    assert not any("relative standard uncertainty" in line for line in built.remarks())


def test_largest_relative_leaves_dark_patches_out() -> None:
    values: NDArray[np.float64] = np.array([[1.0, 0.005], [0.02, 0.0]])
    u = PatchUncertainty(np.array([[1e-4, 1e-2], [1e-6, np.nan]]), {}, np.zeros(2), {})
    assert u.largest_relative(values) == (pytest.approx(0.05), 1, 0)
