"""test_compare_uncertainty.py: what comparisons say of noise and shared errors, against repeats and dense algebra."""

from dataclasses import replace

import numpy as np
import pytest
from compared_data import dataset, distribution, drawn, lattice, smooth_per_sr

from gonio.compare.comparing import compare_datasets
from gonio.compare.field import PointField
from gonio.compare.result import Metrics, Pair, Settings
from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.units.errors import UsageError

SCALE = "distance"  # an effect of the instrument
SESSION = "lamp"  # one of the session
UNIT = lattice(400)
TRUTH = smooth_per_sr(UNIT)


def clean(scale_rel: float = 0.02, lamp_rel: float = 0.01, u_rel: float = 0.01) -> Distribution:
    return distribution(UNIT, TRUTH, u_rel=u_rel, effects={SCALE: scale_rel * TRUTH, SESSION: lamp_rel * TRUTH})


def compared(a: Distribution, b: Distribution, *, instruments: tuple[str, str] = ("one", "one")) -> Pair:
    one, other = dataset(a, instrument=instruments[0]), dataset(b, instrument=instruments[1])
    return compare_datasets(one, other, ("a", "b"), Settings()).pairs[0]


def whole(pair: Pair) -> Metrics:
    return pair.metrics["whole"]


def test_two_measurements_of_one_truth() -> None:
    """One instrument, two sessions, 60 times: chi-square is 1 per point, f is what noise leaves of it, shares within
    1, 2, 3 u are those of the normal distribution, and the shared effect takes no part in it."""
    rng = np.random.default_rng(11)
    judged = []
    for _ in range(60):
        causes = {SCALE: rng.standard_normal()}
        pair = compared(drawn(clean(), rng, causes), drawn(clean(), rng, causes))
        assert pair.shared_effects == (SCALE,)
        judged.append(whole(pair))
    with_correlations = np.array([m.chi_square_with_correlations_per_point for m in judged])
    # 400 degrees of freedom: standard deviation sqrt(2 / 400) = 0.07 each, 0.009 of the mean of 60.
    assert with_correlations.mean() == pytest.approx(1.0, abs=0.03)
    assert np.all(np.abs(with_correlations - 1.0) < 0.3)
    # Plain chi-square moves with the two lamps: mean 1, and 2 of 4 parts of its variance are common to all points.
    assert np.mean([m.chi_square_per_point for m in judged]) == pytest.approx(1.0, abs=0.25)
    squares = [(100.0 - m.global_accordance_percent.value) ** 2 for m in judged]  # type: ignore[operator]
    expected = np.mean([(100.0 - m.global_accordance_percent.from_uncertainty) ** 2 for m in judged])  # type: ignore[operator]
    assert np.mean(squares) == pytest.approx(expected, rel=0.25)
    assert np.mean([m.rmse_per_sr.in_u**2 for m in judged]) == pytest.approx(1.0, abs=0.25)  # type: ignore[operator]


def test_without_systematic_effects_every_point_is_independent() -> None:
    """Then the normalised figures are sharp: 400 points, twice the noise."""
    rng = np.random.default_rng(12)
    quiet = clean(0.0, 0.0)
    m = whole(compared(drawn(quiet, rng), drawn(quiet, rng)))
    assert m.chi_square_per_point == pytest.approx(1.0, abs=0.2)
    assert m.chi_square_with_correlations_per_point == pytest.approx(m.chi_square_per_point)
    assert [share.value for share in m.within_u] == pytest.approx([68.27, 95.45, 99.73], abs=4.0)
    assert m.local_accordance_percent.in_u == pytest.approx(1.0, abs=0.08)
    # u(A - B) / (A + B) is 0.01 / sqrt(2) everywhere, and the mean of |x| is sqrt(2 / pi) sigma.
    assert m.local_accordance_percent.from_uncertainty == pytest.approx(
        100.0 * (1.0 - 0.01 / np.sqrt(2.0) * np.sqrt(2.0 / np.pi)), abs=0.02
    )
    assert m.local_accordance_beyond_uncertainty_percent == pytest.approx(100.0, abs=0.02)
    assert m.local_accordance_beyond_uncertainty_percent < 100.0
    assert m.global_accordance_percent.from_uncertainty == pytest.approx(100.0 * (1.0 - 0.01 / np.sqrt(2.0)), abs=0.02)


def test_only_one_instrument_shares() -> None:
    shared, apart = compared(clean(), clean()), compared(clean(), clean(), instruments=("one", "other"))
    assert apart.shared_effects == ()
    u_rel = {"independent": 0.01 * np.sqrt(2.0), "lamps": 0.01 * np.sqrt(2.0), "scales": 0.02 * np.sqrt(2.0)}
    expected = np.hypot(u_rel["independent"], u_rel["lamps"]) * TRUTH
    assert shared.u_difference_per_sr == pytest.approx(expected, rel=1e-9)
    assert apart.u_difference_per_sr == pytest.approx(np.hypot(expected, u_rel["scales"] * TRUTH), rel=1e-9)
    assert shared.u_a_per_sr == pytest.approx(apart.u_a_per_sr)
    of_shared, of_apart = ({i.name: i for i in pair.integrals} for pair in (shared, apart))
    noise = u_rel["independent"] * np.linalg.norm(TRUTH[UNIT[:, 2] > 0]) / TRUTH[UNIT[:, 2] > 0].sum()
    assert of_shared["rho_compared"].u_percent == pytest.approx(100.0 * np.hypot(noise, u_rel["lamps"]), rel=1e-6)
    assert of_apart["rho_compared"].u_percent == pytest.approx(
        100.0 * np.sqrt(noise**2 + u_rel["lamps"] ** 2 + u_rel["scales"] ** 2), rel=1e-6
    )


def test_a_dataset_without_instrument_text_shares_nothing() -> None:
    pair = compare_datasets(dataset(clean()), dataset(clean()), ("a", "b"), Settings()).pairs[0]
    assert pair.shared_effects == ()


def test_a_scope_of_a_merge_is_the_files_own() -> None:
    """ "distance #2" of one merged file is not that of another."""
    scoped = replace(clean(), effects={f"{SCALE} #2": 0.02 * TRUTH})
    assert compared(scoped, scoped).shared_effects == ()


def test_uncertainty_of_f_and_of_integrals_by_repeats() -> None:
    """Distributions that differ: the standard deviation of 100 repeats is the stated u within three of its own 7 %."""
    rng = np.random.default_rng(14)
    other = replace(clean(), dsf_per_sr=TRUTH * (1.1 + 0.05 * UNIT[:, 0]))
    f, f_omega, delta, stated = [], [], [], []
    for _ in range(100):
        causes = {SCALE: rng.standard_normal()}
        pair = compared(drawn(clean(), rng, causes), drawn(other, rng, causes))
        metric = whole(pair).global_accordance_percent
        rho = next(i for i in pair.integrals if i.name == "rho_compared")
        f.append(metric.value)
        f_omega.append(metric.by_solid_angle)
        delta.append(rho.signed_percent)
        stated.append((metric.u, metric.u_by_solid_angle, rho.u_percent))
    spread = [np.std(values, ddof=1) for values in (f, f_omega, delta)]
    assert spread == pytest.approx(np.mean(np.array(stated, dtype=np.float64), axis=0), rel=0.21)


def test_equal_values_have_the_uncertainty_that_noise_leaves() -> None:
    metric = whole(compared(clean(), clean())).global_accordance_percent
    assert metric.value == 100.0
    assert metric.u == pytest.approx(100.0 - metric.from_uncertainty)  # type: ignore[operator]
    assert metric.u > 0.0


def test_p_i_of_a_dataset_without_columns_is_an_effect() -> None:
    bare = replace(distribution(UNIT, TRUTH), p_i_u_rel=0.03)
    pair = compared(bare, bare)
    assert pair.u_a_per_sr == pytest.approx(0.03 * TRUTH)
    assert pair.u_difference_per_sr == pytest.approx(0.03 * np.sqrt(2.0) * TRUTH)  # two sessions, two beams
    with_column = replace(bare, effects={"p_i": 0.01 * TRUTH})
    assert compared(with_column, bare).u_a_per_sr == pytest.approx(0.01 * TRUTH)


def test_a_point_that_no_photon_reached_is_not_known_exactly() -> None:
    """Counts of mean 4: chi-square against the exact mean stays near 1, as it could not with exact zeros."""
    hits = np.random.default_rng(15).poisson(4.0, len(UNIT))
    per_photon = 0.025
    counted = replace(
        distribution(UNIT, hits * per_photon),
        variance_per_sr2=hits * per_photon**2,
        count=hits.astype(np.int32),
        flags=np.full(len(UNIT), PointFlag.SIMULATED, dtype=np.uint16),
    )
    assert (hits == 0).sum() > 3
    pair = compared(distribution(UNIT, np.full(len(UNIT), 4.0 * per_photon)), counted)
    assert pair.u_b_per_sr[hits == 0] == pytest.approx(per_photon)
    assert whole(pair).without_uncertainty == 0
    assert whole(pair).chi_square_per_point == pytest.approx(1.617, abs=0.4)  # E[(h - 4)^2 / max(h, 1)]


def test_interpolated_values_share_the_noise_of_their_corners() -> None:
    """A linear result of interpolated values against the dense matrix of the interpolation."""
    source = distribution(UNIT, TRUTH, u_rel=0.05)
    at = PointField(source).at(lattice(2000)).values
    weight = np.where(np.isfinite(at.dsf_per_sr), np.linspace(-1.0, 2.0, 2000), 0.0)
    assert at.spread is not None
    matrix = np.zeros((2000, len(UNIT)))
    np.add.at(matrix, (np.arange(2000)[:, None], at.spread.index), at.spread.weight)
    dense = weight @ matrix @ np.diag(source.variance_per_sr2) @ matrix.T @ weight
    assert at.linear(weight).independent == pytest.approx(np.sqrt(dense))
    naive = float(np.sqrt(weight**2 @ np.nan_to_num(at.variance_per_sr2)))
    assert at.linear(weight).independent > 1.2 * naive  # neighbours share points


def test_signal_that_is_not_normalised_is_refused() -> None:
    raw = replace(clean(), p_i=float("nan"), signal_unit="A")
    with pytest.raises(UsageError, match=r"b: visible \(30, 0\) is in A, not normalised"):
        compare_datasets(dataset(clean()), Dataset([raw]), ("a", "b"), Settings())
