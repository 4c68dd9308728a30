"""test_repeatability.py: variance components against a worked table, scipy, and simulated known ones; stated
uncertainties against scatter."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_form_sets import dataset, distribution, lambertian, rings
from scipy.stats import chi2, f_oneway

from gonio.merge.repeatability import Run, read_table, repeatability
from gonio.merge.repeatability_text import lines
from gonio.merge.variance_components import analyse
from gonio.units.errors import UsageError


def nested(rng, sizes, sigmas, mean=10.0):
    """Values and labels of a design: `sizes` groups within each group, `sigmas` outermost first."""
    values, labels = [], []
    for day in range(sizes[0]):
        a = sigmas[0] * rng.standard_normal()
        for mount in range(sizes[1]):
            b = sigmas[1] * rng.standard_normal()
            for position in range(sizes[2]):
                c = sigmas[2] * rng.standard_normal()
                for _ in range(sizes[3]):
                    values.append(mean + a + b + c + sigmas[3] * rng.standard_normal())
                    labels.append((str(day), str(mount), str(position)))
    return np.array(values), labels


TILE = distribution(rings(15.0), lambertian())
LEVELS = ("day", "mount", "position", "repeat")


def test_a_worked_table():
    """Purity of raw material: 3 suppliers, 4 batches each, 3 determinations (D. C. Montgomery, Design and Analysis of
    Experiments, nested designs, table 14.3: mean squares 7.53, 7.77, 2.64; F 0.97 and 2.94; batches' variance 1.71)."""
    purity = [
        [[1, -1, 0], [-2, -3, -4], [-2, 0, 1], [1, 4, 0]],
        [[1, -2, -3], [0, 4, 2], [-1, 0, -2], [0, 3, 2]],
        [[2, 4, 0], [-2, 0, 2], [1, -1, 2], [3, 2, 1]],
    ]
    rows = [(str(s), str(b), v) for s, of in enumerate(purity) for b, values in enumerate(of) for v in values]
    found = analyse(np.array([float(v) for *_, v in rows]), [row[:2] for row in rows], ("supplier", "batch", "error"))
    supplier, batch, error = found.components
    assert [c.dof for c in found.components] == [2, 9, 24]
    assert [c.mean_square for c in found.components] == pytest.approx([7.53, 7.77, 2.64], abs=0.006)
    assert (supplier.f, batch.f, error.f) == (pytest.approx(0.97, abs=0.005), pytest.approx(2.94, abs=0.006), None)
    assert batch.variance == pytest.approx(1.71, abs=0.006)
    assert supplier.variance < 0.0, "and is told as it is"
    assert error.variance == pytest.approx(2.64, abs=0.006)
    # The interval of the repeats is exact: SS over the quantiles of chi-square; here by 20000 draws.
    expected = 24 * error.variance / chi2.ppf([0.975, 0.025], 24)
    assert [error.low, error.high] == pytest.approx(expected, rel=0.02)


def test_one_way_is_scipys_analysis():
    """Unbalanced: F and its probability by scipy; the component by (MSA - MSE) / n0 (Searle 1971, sec. 11.3)."""
    rng = np.random.default_rng(2)
    groups = [rng.normal(size=n) + 2.0 * rng.normal() for n in (3, 7, 2, 5, 9)]
    values = np.concatenate(groups)
    labels = [(str(k),) for k, group in enumerate(groups) for _ in group]
    between, within = analyse(values, labels, ("day", "repeat")).components
    judge = f_oneway(*groups)
    assert between.f == pytest.approx(judge.statistic, rel=1e-12)
    assert between.p == pytest.approx(judge.pvalue, rel=1e-9)
    sizes = np.array([len(group) for group in groups])
    n0 = (sizes.sum() - (sizes**2).sum() / sizes.sum()) / (len(groups) - 1)
    assert between.variance == pytest.approx((between.mean_square - within.mean_square) / n0, rel=1e-12)
    assert within.variance == within.mean_square


@pytest.mark.parametrize("balanced", [True, False])
def test_known_components_come_back_without_bias(balanced):
    """300 simulated campaigns: means of the estimates are the variances put in, and intervals hold them in 95 %."""
    rng = np.random.default_rng(3)
    sigmas = np.array([2.0, 1.0, 0.5, 0.3])
    estimates, covered = [], []
    for _ in range(300):
        values, labels = nested(rng, (4, 3, 2, 2), sigmas)
        if not balanced:
            kept = rng.random(len(values)) < 0.8
            values, labels = values[kept], [label for label, k in zip(labels, kept, strict=True) if k]
        components = analyse(values, labels, LEVELS).components
        estimates.append([c.variance for c in components])
        covered.append([c.low <= s**2 <= c.high for c, s in zip(components, sigmas, strict=True)])
    error = np.std(estimates, axis=0) / np.sqrt(300)
    assert np.all(np.abs(np.mean(estimates, axis=0) - sigmas**2) < 4.0 * error)
    assert np.all(np.mean(covered, axis=0) > 0.90)
    assert np.mean(covered, axis=0)[3] == pytest.approx(0.95, abs=0.045)


def test_the_variance_of_the_mean_holds_all_components():
    rng = np.random.default_rng(4)
    means, stated = [], []
    for _ in range(400):
        values, labels = nested(rng, (5, 2, 1, 2), (1.0, 0.5, 0.0, 0.2))
        found = analyse(values, labels, LEVELS)
        means.append(found.mean)
        stated.append(found.variance_of_mean)
    assert np.var(means) == pytest.approx(np.mean(stated), rel=0.2)


def test_levels_that_the_design_does_not_tell():
    values = np.array([1.0, 1.1, 0.9, 1.05])
    day, mount, position, repeat = analyse(values, [("1", "1", "1")] * 4, LEVELS).components
    assert [c.dof for c in (day, mount, position, repeat)] == [0, 0, 0, 3]
    assert day.variance is mount.variance is position.variance is None
    assert repeat.variance == pytest.approx(np.var(values, ddof=1))


def campaign(rng, *, drift, budget=True, runs=12):
    """Datasets of a tile whose rho differs from run to run by `drift` (relative), and says 1 %: half of it the
    instrument's, which all share."""
    sets, labels = [], []
    for k in range(runs):
        rho = 0.6 * (1.0 + drift * rng.standard_normal())
        d = replace(TILE, integrals={"rho_measured": rho, "rho_u": 0.6 * np.hypot(0.01, 0.05)}, budgets={})
        if budget:
            d.budgets = {"rho": {"p_i": 0.6 * 0.01, "distance": 0.6 * 0.05, "independent": 1e-5}}
        sets.append(dataset(d, raw=str(k)))
        labels.append(Run(Path(f"{k}.h5"), (str(k % 3), str(k // 3 % 2), "1")))
    return repeatability(sets, labels)[0]


def test_scatter_is_held_against_what_runs_do_not_share():
    """Sessions' P_i is stated as 1 %, and the instrument's distance as 5 % that no repeat can show."""
    rng = np.random.default_rng(5)
    explained = [campaign(rng, drift=0.01).scatter for _ in range(40)]
    assert np.mean([s.explained for s in explained]) > 0.85
    assert np.mean([s.chi2 / s.dof for s in explained]) == pytest.approx(1.0, abs=0.2)
    assert not campaign(rng, drift=0.03).scatter.explained, "three times what is stated"
    blind = campaign(rng, drift=0.03, budget=False).scatter
    assert not blind.budgets
    assert blind.explained, "without budget the shared 5 % hides it"


def test_a_mount_is_shared_by_its_runs():
    """Two mounts of three runs each; within a mount all read alike. Stated: tilt of the mount. The chi-square sees two
    independent values, not six."""
    sets, labels = [], []
    for k in range(6):
        mount = k // 3
        d = replace(TILE, integrals={"rho_measured": 0.6 + 0.01 * mount, "rho_u": 0.01})
        d.budgets = {"rho": {"tilt_x": 0.01, "independent": 1e-4}}
        sets.append(dataset(d, raw=str(k)))
        labels.append(Run(Path(f"{k}.h5"), ("1", str(mount), "1")))
    scatter = repeatability(sets, labels)[0].scatter
    assert scatter.chi2 == pytest.approx(0.5, rel=0.01)


def test_quadrature_is_each_runs_own():
    """One mount: what is stated of the finite number of points explains that other points were hit."""
    sets, labels = [], []
    for k, off in enumerate((0.008, -0.011, 0.004, -0.001)):
        integrals = {"rho_measured": 0.6 + off, "rho_u": 0.01, "cone mirror 7": 0.1, "cone mirror 7_u": 1e-3}
        d = replace(TILE, integrals=integrals | {"cone mirror 7_measured_share": 0.9})
        d.budgets = {"rho": {"quadrature": 0.01, "independent": 1e-4}}
        sets.append(dataset(d, raw=str(k)))
        labels.append(Run(Path(f"{k}.h5"), ("1", "1", "1")))
    found = repeatability(sets, labels)
    assert [quantity.name for quantity in found] == ["rho_measured", "cone mirror 7"], "a share is no result"
    assert found[0].scatter.chi2 == pytest.approx(np.var([0.8, -1.1, 0.4, -0.1], ddof=0) * 4.0, rel=0.01)


def test_the_report_names_every_level():
    rng = np.random.default_rng(6)
    text = "\n".join(lines([campaign(rng, drift=0.03)]))
    assert "different day" in text
    assert "shifted position        not told by these runs" in text
    assert "NOT explained" in text


def test_tables_are_read_and_wrong_ones_told(tmp_path):
    table = tmp_path / "runs.csv"
    table.write_text("file,mount,position,day\na.h5,1,1,mo\nsub/b.h5,2,1,tu\n")
    runs = read_table(table)
    assert [run.labels for run in runs] == [("mo", "1", "1"), ("tu", "2", "1")]
    assert runs[1].path == tmp_path / "sub" / "b.h5"
    for text, problem in [
        ("file,mount,day\na.h5,1,1\n", "no column position"),
        ("file,mount,position,day\na.h5,1,,mo\n", "line 2: an empty cell"),
        ("file,mount,position,day\na.h5,1,1,mo\n", "1 runs"),
        ("file,mount,position,day\na.h5,1\n", "line 2: an empty cell"),
    ]:
        table.write_text(text)
        with pytest.raises(UsageError, match=problem):
            read_table(table)
