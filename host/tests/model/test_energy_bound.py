"""test_energy_bound.py: integrals of resolved models against closed forms, and the scales that bound them."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from sampled_nodes import MIRROR, dataset, gaussian, node_with, spread, towards

from gonio.model.between.energy import BOUND_SLACK, LARGEST_CORRECTION, Bound, integrals, with_node_scales
from gonio.model.between.resolve import Resolver
from gonio.model.between.scheme import SCHEMES
from gonio.model.channel import Fitted
from gonio.model.evaluate import evaluate
from gonio.model.fitted import fit_bsdf
from gonio.model.nodes.points import points_of
from gonio.model.nodes.symmetry import IDENTITY, Images

FloatArray = NDArray[np.float64]
ALONE = Images("none", (IDENTITY,))


def test_integrals_of_lobes_and_ground() -> None:
    # A lobe of s rad has 2 pi peak s^2 (1 - s^2 / 3 + ...) on the sphere: the exact value by fine rings.
    nodes = []
    for theta, sigma in ((20.0, 1.0), (40.0, 6.0), (65.0, 12.0)):
        ground = np.full((3, 3), 0.2, dtype=np.float32)
        nodes.append(replace(node_with(towards(theta), [(towards(theta), 5.0, sigma)]), background=ground))
    resolver = Resolver(nodes, ALONE, SCHEMES[0])
    found = integrals(resolver.slices(np.array([n.incident for n in nodes])), resolver.grids)
    every = spread(2_000_000)
    for node, integral in zip(nodes, found, strict=True):
        sigma = float(np.degrees(node.sigma_rad[0, 0]))
        right = 2.0 * np.pi * (0.2 + gaussian(every, node.incident, 5.0, sigma).mean())
        assert integral == pytest.approx(right, rel=BOUND_SLACK)


def test_the_integral_of_a_ground_with_a_direct_beam() -> None:
    # As a louver's: a few nodes of 65 across; the mean over the disc, which keeps areas, is the answer.
    ground = np.full((65, 65), 0.05, dtype=np.float32)
    ground[13:15, 32:34] += 60.0
    node = replace(node_with(towards(30.0), []), background=ground)
    resolver = Resolver([node], ALONE, SCHEMES[0])
    found = integrals(resolver.slices(node.incident[None]), resolver.grids)[0]
    assert found == pytest.approx(2.0 * np.pi * 0.05 + 2.0 * 60.0 * 4 * (2.0 / 64) ** 2, rel=0.02)


def test_a_node_is_scaled_to_the_sum_over_its_points() -> None:
    def mirror(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        return 0.1 + gaussian(outgoing, incident * MIRROR, 5.0, 6.0)

    points = next(iter(points_of(dataset(mirror, [(30.0, 0.0)], number=4000), "visible").values()))
    off = node_with(towards(30.0), [(towards(30.0, 180.0), 5.0, 5.97)])  # 1 % too weak
    off = replace(off, background=np.full((3, 3), 0.1, dtype=np.float32), integral=points[0].integral)
    resolver = Resolver([off], ALONE, SCHEMES[0])
    scaled, needed = with_node_scales(resolver, points)
    assert needed[0] == pytest.approx(scaled[0].scale)
    assert 1.001 < scaled[0].scale < 1.0 + LARGEST_CORRECTION
    again = resolver.with_nodes(scaled)
    model = evaluate(again.slices(points[0].incident[None]), again.grids, points[0].unit)
    assert model @ points[0].solid_angle_sr == pytest.approx(points[0].integral, rel=1e-12)
    far = replace(off, log_peak=off.log_peak - 1.0)
    scaled, needed = with_node_scales(Resolver([far], ALONE, SCHEMES[0]), points)
    assert scaled[0].scale == pytest.approx(1.0 + LARGEST_CORRECTION)
    assert needed[0] > 1.2


@pytest.mark.parametrize("isotropic", [True, False])
def test_no_direction_between_exceeds_its_neighbours(isotropic: bool) -> None:
    # Powers are equal, peaks and widths are not: the mean of logarithms of both is no mean of the power where a
    # lobe fades in beside it. A third node has more.
    nodes = [
        node_with(towards(10.0), [(towards(10.0), 40.0, 2.0)]),
        node_with(towards(50.0), [(towards(50.0), 2.0, 9.0), (towards(50.0, 180.0), 8.0, 2.0)]),
        node_with(towards(70.0, 0.0 if isotropic else 50.0), [(towards(70.0), 2.5, 9.0)]),
    ]
    images = Images("isotropic", (IDENTITY, (-1, -1))) if isotropic else ALONE
    resolver = Resolver(nodes, images, SCHEMES[0])
    bound = Bound.of(resolver)
    incident = np.array([towards(t) for t in np.arange(0.0, 90.0, 1.7)])
    free = resolver.slices(incident)
    held = bound.applied(resolver, incident, free)
    stencil = resolver.locate(incident)
    most = np.max(np.where(stencil.weight > 1e-9, bound.node_integral[stencil.node], 0.0), axis=1)
    assert np.all(integrals(held, resolver.grids) <= most * (1.0 + 3.0 * BOUND_SLACK))
    assert np.all(held.scale <= free.scale)
    loud = resolver.with_nodes([replace(n, log_peak=n.log_peak + k) for k, n in enumerate(nodes)])
    assert np.any(integrals(loud.slices(incident), loud.grids) > 0.0)


def test_a_bound_that_bites() -> None:
    # Lobes that follow retro and are cut by the horizon where they were measured: moved back they would be whole.
    nodes = [node_with(towards(88.0), [(towards(88.0), 5.0, 10.0)])]
    resolver = Resolver(nodes, Images("isotropic", (IDENTITY, (-1, -1))), SCHEMES[0])
    bound, incident = Bound.of(resolver), np.array([towards(20.0), towards(88.0)])
    free = integrals(resolver.slices(incident), resolver.grids)
    held = integrals(bound.applied(resolver, incident, resolver.slices(incident)), resolver.grids)
    assert free[0] > 1.5 * free[1]
    assert held[0] == pytest.approx(free[1], rel=2e-3)
    assert held[1] == pytest.approx(free[1], rel=2e-3)


def test_the_model_is_never_negative() -> None:
    def noisy(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        random = np.random.default_rng(3).standard_normal(len(outgoing))
        return gaussian(outgoing, incident * MIRROR, 5.0, 3.0) + 0.02 * random

    fitted = fit_bsdf(dataset(noisy, [(t, 0.0) for t in (10.0, 30.0, 50.0)])).channels["visible"]
    assert isinstance(fitted, Fitted)
    incident = np.array([towards(t) for t in (10.0, 25.0, 80.0)])
    found = fitted.dsf_per_sr(incident, np.tile(spread(2000), (3, 1)), np.repeat(np.arange(3), 2000))
    assert found.min() >= 0.0
