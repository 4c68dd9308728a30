"""test_gtc.py: sums, ratios and products of points with shared errors, against the GUM Tree Calculator (GTC)."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from few_points import EFFECTS, N, distribution
from GTC import component, ureal

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import Uncertain, combined_u_per_sr, linear_result


class Judge:
    """The same points as GTC's uncertain numbers: every noise and every effect is one independent input."""

    def __init__(self, of: Distribution, effects: dict[str, Any] | None = None) -> None:
        self.effects = effects or {name: ureal(0.0, 1.0, label=name) for name in EFFECTS}
        self.points: list[Any] = []
        for i in np.flatnonzero(of.measured):
            point = ureal(float(of.dsf_per_sr[i]), float(np.sqrt(of.variance_per_sr2[i])))
            for name, column in of.effects.items():
                point = point + float(column[i]) * self.effects[name]
            self.points.append(point)

    def sum(self, weight: Any) -> Any:
        return sum(float(w) * point for w, point in zip(weight, self.points, strict=False))

    def agrees(self, ours: Uncertain, theirs: Any) -> None:
        assert ours.value == pytest.approx(theirs.x, rel=1e-12)
        assert ours.u == pytest.approx(theirs.u, rel=1e-9)
        for name, effect in self.effects.items():
            # The reporting of GTC gives |contribution|; ours are signed.
            assert abs(ours.effects.get(name, 0.0)) == pytest.approx(component(theirs, effect), rel=1e-9, abs=1e-15)


def test_points_and_their_sum() -> None:
    d = distribution(1)
    judge = Judge(d)
    assert combined_u_per_sr(d)[:-1] == pytest.approx([point.u for point in judge.points], rel=1e-9)
    assert np.isnan(combined_u_per_sr(d)[-1])
    judge.agrees(linear_result(d, d.solid_angle_sr), judge.sum(d.solid_angle_sr))


def test_weights_of_either_sign() -> None:
    """2 V - P1 has such weights, and so has the difference of two patches."""
    d = distribution(2)
    weight = np.linspace(-1.0, 1.0, N)
    judge = Judge(d)
    judge.agrees(linear_result(d, weight), judge.sum(weight))


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (Uncertain.plus, lambda a, b: a + b),
        (Uncertain.minus, lambda a, b: a - b),
        (Uncertain.times, lambda a, b: a * b),
        (Uncertain.over, lambda a, b: a / b),
    ],
)
def test_two_sums_of_different_points(ours: Callable[..., Uncertain], theirs: Callable[[Any, Any], Any]) -> None:
    """A product of a reflectance and a transmittance, say: their points are others, their lamp is one."""
    d = distribution(3)
    first = np.where(np.arange(N) < 4, d.solid_angle_sr, 0.0)
    second = d.solid_angle_sr - first
    judge = Judge(d)
    found = ours(linear_result(d, first), linear_result(d, second))
    judge.agrees(found, theirs(judge.sum(first), judge.sum(second)))


def test_haze() -> None:
    """Diffuse over all: numerator and denominator have points in common, so the ratio is made linear in the points
    before it is propagated: d(D / T) = (dD - h dT) / T."""
    d = distribution(4)
    diffuse = np.where(np.arange(N) > 2, d.solid_angle_sr, 0.0)
    total = linear_result(d, d.solid_angle_sr).value
    haze = linear_result(d, diffuse).value / total
    linear = linear_result(d, (diffuse - haze * d.solid_angle_sr) / total)
    judge = Judge(d)
    judge.agrees(Uncertain(haze, linear.independent, linear.effects), judge.sum(diffuse) / judge.sum(d.solid_angle_sr))
    # What scales all points alike cancels; the noise and the rest do not.
    assert abs(linear.effects["lamp"]) < 1e-15
    assert linear.u > 0.0


def test_two_distributions_of_one_session() -> None:
    """One key is one cause over all distributions: rho at two incident directions, and their mean."""
    one, two = distribution(5), distribution(6)
    first = Judge(one)
    second = Judge(two, first.effects)
    sums = [linear_result(d, d.solid_angle_sr) for d in (one, two)]
    theirs = 0.5 * (first.sum(one.solid_angle_sr) + second.sum(two.solid_angle_sr))
    first.agrees(sums[0].plus(sums[1]).scaled(0.5), theirs)
