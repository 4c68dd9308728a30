"""What models compute themselves because scipy loads slowly, against scipy; and that fit does load without it."""

import subprocess
import sys

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import binary_dilation
from scipy.optimize import linear_sum_assignment
from scipy.spatial import ConvexHull

from gonio.model.assignment import assigned
from gonio.model.monotone_cubic import monotone_cubic
from gonio.model.nodes.coverage import _grown, _in_hull

SIZES = st.integers(1, 9)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_an_assignment_costs_as_little_as_scipys(data: st.DataObject) -> None:
    n = data.draw(SIZES)
    cost = data.draw(arrays(np.float64, (n, n), elements=st.floats(-50.0, 1e6)))
    column = assigned(cost)
    assert sorted(column) == list(range(n))
    least = cost[linear_sum_assignment(cost)].sum()
    np.testing.assert_allclose(cost[np.arange(n), column].sum(), least, rtol=1e-9, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_monotone_cubic_is_scipys(data: st.DataObject) -> None:
    k = data.draw(st.integers(2, 9))
    steps = data.draw(arrays(np.float64, k, elements=st.floats(0.05, 2.0)))
    knots = np.cumsum(steps)
    values = data.draw(arrays(np.float64, (k, 2, 2), elements=st.integers(-40, 40).map(lambda n: n / 8.0)))
    at = np.linspace(knots[0], knots[-1], 31)
    wanted = PchipInterpolator(knots, values, axis=0)(at)
    np.testing.assert_allclose(monotone_cubic(knots, values, at), wanted, rtol=1e-9, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(3, 40), st.integers(0, 10_000))
def test_a_hull_holds_what_scipys_holds(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    disc, cells = rng.uniform(-1.0, 1.0, (count, 2)), rng.uniform(-1.2, 1.2, (400, 2))
    plane = ConvexHull(disc).equations
    inside = np.all(cells @ plane[:, :2].T + plane[:, 2] <= 1e-9, axis=1)
    np.testing.assert_array_equal(_in_hull(disc, cells), inside)


def test_points_on_a_line_hold_nothing() -> None:
    line = np.linspace(-0.5, 0.5, 9)[:, None] * np.array([1.0, 0.3])
    assert not _in_hull(line, line).any()
    assert not _in_hull(line[:2], line).any()


def test_cells_grow_to_their_sides() -> None:
    near = np.random.default_rng(1).random((64, 64)) < 0.02
    np.testing.assert_array_equal(_grown(near), binary_dilation(near))


def test_fit_loads_without_scipy() -> None:
    code = (
        "import sys, gonio.cli.fit, gonio.model.fitted, gonio.model.model_file, gonio.model.fit_text, "
        "gonio.dataset.nexus; sys.exit(', '.join(m for m in sys.modules if m.split('.')[0] == 'scipy') or None)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
