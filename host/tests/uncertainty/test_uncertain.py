"""test_uncertain.py: what must hold of uncertain values whatever their numbers."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gonio.dataset.uncertainty import Uncertain

NAMES = ("lamp", "p_i", "tilt_x")
NUMBERS = st.floats(-1e3, 1e3, allow_nan=False)
NOT_ZERO = st.floats(0.1, 1e3) | st.floats(-1e3, -0.1)


@st.composite
def uncertain(draw: st.DrawFn) -> Uncertain:
    effects = draw(st.dictionaries(st.sampled_from(NAMES), NUMBERS))
    return Uncertain(draw(NOT_ZERO), draw(st.floats(0.0, 1e2)), effects)


def same(a: Uncertain, b: Uncertain) -> bool:
    names = {*a.effects, *b.effects}
    pairs = [(a.value, b.value), (a.independent, b.independent)]
    pairs += [(a.effects.get(name, 0.0), b.effects.get(name, 0.0)) for name in names]
    return all(math.isclose(x, y, rel_tol=1e-9, abs_tol=1e-6) for x, y in pairs)


@given(uncertain(), uncertain(), uncertain())
def test_sums_and_products_do_not_depend_on_the_order(a: Uncertain, b: Uncertain, c: Uncertain) -> None:
    assert same(a.plus(b), b.plus(a))
    assert same(a.times(b), b.times(a))
    assert same(a.plus(b).plus(c), a.plus(b.plus(c)))


@given(uncertain(), uncertain())
def test_a_product_is_undone_by_the_ratio_but_for_noise(a: Uncertain, b: Uncertain) -> None:
    back = a.times(b).over(Uncertain(b.value, 0.0, b.effects))
    assert math.isclose(back.value, a.value, rel_tol=1e-9)
    for name in NAMES:
        assert math.isclose(back.effects.get(name, 0.0), a.effects.get(name, 0.0), rel_tol=1e-6, abs_tol=1e-3)
    assert back.independent >= a.independent - 1e-9


@given(uncertain())
def test_what_is_shared_cancels_in_a_difference(a: Uncertain) -> None:
    shared = Uncertain(a.value, 0.0, a.effects)
    assert shared.minus(shared).u == 0.0
    assert math.isclose(shared.over(shared).u, 0.0, abs_tol=1e-12)
    assert math.isclose(shared.plus(shared).u, 2.0 * shared.u, rel_tol=1e-12, abs_tol=1e-150)


@given(uncertain(), NUMBERS)
def test_scaling(a: Uncertain, factor: float) -> None:
    scaled = a.scaled(factor)
    assert scaled.independent >= 0.0
    assert math.isclose(scaled.u, abs(factor) * a.u, rel_tol=1e-9, abs_tol=1e-12)


@given(uncertain())
def test_the_budget_makes_up_u_largest_first(a: Uncertain) -> None:
    parts = list(a.budget.values())
    assert parts == sorted(parts, reverse=True)
    assert math.isclose(float(np.linalg.norm(parts)), a.u, rel_tol=1e-12, abs_tol=1e-150)


@given(uncertain(), NUMBERS)
def test_changes_of_one_effect_add_up(a: Uncertain, change: float) -> None:
    twice = a.with_effect("lamp", change).with_effect("lamp", -change)
    assert same(twice, a)
    assert a.with_effect("other", change).effects["other"] == change
