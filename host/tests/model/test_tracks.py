"""test_tracks.py: lobes of neighbouring incident directions: who is who, and what follows what."""

import numpy as np
from sampled_nodes import MIRROR, node_with, towards

from gonio.model.between.mesh import Line
from gonio.model.between.tracks import Lobes, Matcher, match, track

NO_IMAGE = np.array([1.0, 1.0])


def _at(theta: float, *, weak: bool = True) -> Lobes:
    """Retro 1.2 degrees wide, mirror 12 degrees wide and a hundredth as strong; listed in turns."""
    incident = towards(theta)
    lobes = [(incident, 150.0, 1.2), (incident * MIRROR, 0.4, 12.0)][: 2 if weak else 1]
    return Lobes.of(node_with(incident, lobes[:: 1 if int(theta) % 20 else -1]), NO_IMAGE)


def test_a_weak_lobe_keeps_its_name_beside_a_strong_one() -> None:
    thetas = [10.0, 20.0, 30.0, 40.0, 50.0]
    nodes = [_at(t) for t in thetas]
    line = Line(np.array([n.incident for n in nodes]))
    tracks = track(nodes, line.edges, Matcher(nodes))
    assert sorted(tracks.follows) == ["opposite", "same"]
    for column, follows in enumerate(tracks.follows):
        strong = [nodes[k].log_peak[tracks.lobe[k, column]] > 0.0 for k in range(len(nodes))]
        assert all(strong) == (follows == "same")
        assert any(strong) == (follows == "same")


def test_lobes_that_cross_are_not_exchanged() -> None:
    # Near the normal retro and mirror pass each other: 5 degrees on one side, 5 on the other.
    nodes = [_at(-5.0), _at(5.0)]
    nodes[0] = Lobes.of(
        node_with(towards(5.0), [(towards(5.0), 150.0, 1.2), (towards(5.0, 180.0), 20.0, 1.5)]), -NO_IMAGE
    )
    nodes[1] = Lobes.of(
        node_with(towards(5.0), [(towards(5.0), 150.0, 1.2), (towards(5.0, 180.0), 20.0, 1.5)]), NO_IMAGE
    )
    assert sorted((i, j) for _, i, j in match(nodes[0], nodes[1])) == [(0, 0), (1, 1)]


def test_a_lobe_without_partner_stays_alone() -> None:
    nodes = [_at(10.0), _at(20.0), _at(30.0, weak=False)]
    line = Line(np.array([n.incident for n in nodes]))
    tracks = track(nodes, line.edges, Matcher(nodes))
    weak = tracks.follows.index("opposite")
    assert tracks.lobe[2, weak] == -1
    assert np.all(tracks.lobe[:2, weak] >= 0)


def test_a_resting_lobe_is_at_rest() -> None:
    nodes = [
        Lobes.of(node_with(towards(t), [(towards(35.0, 70.0), 3.0, 5.0), (towards(t), 9.0, 2.0)]), NO_IMAGE)
        for t in (0.0, 15.0, 30.0, 45.0)
    ]
    line = Line(np.array([n.incident for n in nodes]))
    tracks = track(nodes, line.edges, Matcher(nodes))
    assert sorted(tracks.follows) == ["fixed", "same"]


def test_two_lobes_of_one_node_never_share_a_track() -> None:
    # Around a triangle the matches contradict each other: the dearest ones give way.
    double = [(towards(30.0), 5.0, 3.0), (towards(30.0), 4.9, 3.1)]
    nodes = [Lobes.of(node_with(towards(t), double), NO_IMAGE) for t in (28.0, 30.0, 32.0)]

    def matches(first: int, second: int) -> list[tuple[float, int, int]]:
        crossed = (first, second) == (0, 2)
        return [(2.0, 0, 1), (2.0, 1, 0)] if crossed else [(1.0, 0, 0), (1.0, 1, 1)]

    tracks = track(nodes, np.array([[0, 1], [1, 2], [0, 2]]), matches)
    assert sorted(map(tuple, tracks.lobe.T.tolist())) == [(0, 0, 0), (1, 1, 1)]


def test_lobes_in_one_place_are_told_apart_by_their_width() -> None:
    nested = [(towards(20.0), 50.0, 1.5), (towards(20.0), 2.0, 9.0)]
    one = Lobes.of(node_with(towards(20.0), nested), NO_IMAGE)
    moved = [(towards(30.0), 2.0, 9.0), (towards(30.2), 50.0, 1.5)]
    other = Lobes.of(node_with(towards(30.0), moved), NO_IMAGE)
    assert sorted((i, j) for _, i, j in match(one, other)) == [(0, 1), (1, 0)]
