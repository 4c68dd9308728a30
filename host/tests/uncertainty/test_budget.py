"""test_budget.py: the table of contributions: words, order, shares, expanded uncertainty, JSON."""

import json

import numpy as np
import pytest
from few_points import distribution

from gonio.dataset.budget import budget_of, integral_budget, point_budget, words_of
from gonio.dataset.effects import EFFECTS
from gonio.dataset.uncertainty import combined_u_per_sr, linear_result


def test_rows_are_the_largest_first_and_make_up_u() -> None:
    d = distribution(1)
    result = linear_result(d, d.solid_angle_sr)
    budget = budget_of("rho", result.value, result.budget)
    parts = [row.contribution for row in budget.rows]
    assert parts == sorted(parts, reverse=True)
    assert budget.u == pytest.approx(result.u)
    assert budget.expanded_u == pytest.approx(2.0 * result.u)
    assert sum(row.variance_share for row in budget.rows) == pytest.approx(1.0)
    assert {row.effect for row in budget.rows} == {"independent", *d.effects}
    for row in budget.rows:
        assert row.relative == pytest.approx(row.contribution / result.value)


def test_stored_budget_of_an_integral() -> None:
    d = distribution(2)
    d.integrals = {"rho_measured": 0.5, "haze": 0.1}
    d.budgets = {"rho": {"lamp": -0.003, "independent": 0.004}, "haze": {"independent": 0.0}, "tau": {"lamp": 1.0}}
    rho = integral_budget(d, "rho")
    assert rho is not None
    assert (rho.value, rho.u) == (0.5, pytest.approx(0.005))
    assert [row.effect for row in rho.rows] == ["independent", "lamp"]
    assert rho.rows[1].contribution == 0.003
    haze = integral_budget(d, "haze")
    assert haze is not None
    assert (haze.u, haze.rows) == (0.0, ())
    assert integral_budget(d, "tau") is None  # no value
    assert integral_budget(d, "openness") is None


def test_budget_of_a_point() -> None:
    d = distribution(3)
    budget = point_budget(d, 2)
    assert budget is not None
    assert budget.unit == "1/sr"
    assert budget.u == pytest.approx(combined_u_per_sr(d)[2])
    assert point_budget(d, len(d.flags) - 1) is None


def test_json_holds_plain_finite_numbers() -> None:
    d = distribution(4)
    budget = point_budget(d, 0)
    assert budget is not None
    told = json.loads(json.dumps(budget.as_json(), allow_nan=False))
    assert told["coverage_factor"] == 2.0
    assert told["rows"][0]["words"] == words_of(told["rows"][0]["effect"])
    # A value of 0 has no relative contributions.
    zero = budget_of("background", 0.0, {"independent": np.float64(1e-6)}).as_json()
    assert json.loads(json.dumps(zero, allow_nan=False))["rows"][0]["relative"] is None


def test_words() -> None:
    assert words_of("lamp") == EFFECTS["lamp"].words
    assert words_of("axis arm azimuth") == f"{EFFECTS['axis'].words} (arm azimuth)"
    assert words_of("tilt_x #mount 2") == f"{EFFECTS['tilt_x'].words}, mount 2"
    assert words_of("axis arm azimuth #A") == f"{EFFECTS['axis'].words} (arm azimuth), A"
    assert words_of("of another version") == "of another version"
