"""test_sphere_fallback.py: the fallback by scipy gives what the compiled module gives."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.geometry import backend, fallback
from gonio.geometry.directions import unit_from_angles_deg

_sphere = pytest.importorskip("gonio.geometry._sphere")
FloatArray = NDArray[np.float64]
NONE = np.zeros(0, dtype=bool)


def random_directions(n: int, seed: int) -> FloatArray:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1)[:, None])


def grid() -> FloatArray:
    theta, phi = np.meshgrid(np.arange(0.0, 181.0, 10.0), np.arange(0.0, 360.0, 10.0), indexing="ij")
    return unit_from_angles_deg(theta.ravel(), phi.ravel())


SETS = {
    "one": random_directions(1, 1),
    "two": random_directions(2, 2),
    "three": random_directions(3, 3),
    "random": random_directions(800, 4),
    "many": random_directions(8000, 5),
    "grid": grid(),
    "circle": unit_from_angles_deg(30.0, np.arange(0.0, 360.0, 3.0)),
    "in a plane": unit_from_angles_deg(np.arange(0.0, 170.0, 1.0), 20.0),
    "patch": unit_from_angles_deg(*np.random.default_rng(6).uniform(40.0, 43.0, (2, 400))),
    "repeated": np.tile(random_directions(200, 7), (3, 1)),
}


def test_the_compiled_module_is_the_one_in_use() -> None:
    assert backend.sphere is _sphere


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("name", SETS)
def test_cells(name: str, cut: bool) -> None:
    points = SETS[name]
    for reach in (np.full(len(points), np.pi), np.full(len(points), 0.05)):
        ours, theirs = (module.cells(points, reach, NONE, cut) for module in (_sphere, fallback))
        for one, other in zip(ours, theirs, strict=True):
            # The fallback moves many points by 1e-8, and borders between a point and its image tilt with them.
            many = len(points) * (1 + cut) > 2000
            np.testing.assert_allclose(one, other, atol=(3e-4 if cut else 3e-6) if many else 2e-8)


@pytest.mark.parametrize("name", ["random", "many", "patch", "repeated"])
def test_edges(name: str) -> None:
    ours, theirs = (module.edges(SETS[name]) for module in (_sphere, fallback))
    pairs = [{tuple(pair) for pair in np.sort(SETS[name][:, 0][edges], axis=1)} for edges, _ in (ours, theirs)]
    assert len(pairs[0] ^ pairs[1]) <= 0.001 * len(pairs[0])
    assert len(np.unique(ours[1])) == len(np.unique(theirs[1]))


@pytest.mark.parametrize("cut", [False, True])
def test_locator(cut: bool) -> None:
    points, wanted = SETS["random"], random_directions(5000, 8)
    values = points @ [1.0, 2.0, 3.0]
    for reach in (np.pi, 0.06):
        ours, theirs = (module.Locator(points, np.full(800, reach), cut).at(wanted) for module in (_sphere, fallback))
        assert np.mean(ours[2] != theirs[2]) < 1e-3
        both = ours[2] & theirs[2]
        one, other = (np.einsum("ij,ij->i", found[1], values[found[0]])[both] for found in (ours, theirs))
        assert np.mean(np.abs(one - other) > 1e-9) < 1e-3


def test_local_fit() -> None:
    points = SETS["many"]
    value = np.exp(points @ [1.0, 2.0, 3.0])
    used = np.random.default_rng(9).random(len(points)) > 0.1
    ours, theirs = (module.local_fit(points, value, 0.01 * value, used, 0.1) for module in (_sphere, fallback))
    for one, other in zip(ours, theirs, strict=True):
        # Which radius is the first that does may differ where a smaller one does and the next does not.
        same = np.isclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())
        assert np.mean(same) > 0.995


def test_track_distances_and_shared_reach() -> None:
    azimuth = np.arange(0.0, 90.0, 0.5)
    points = np.concatenate([unit_from_angles_deg(90.0 - e, azimuth[:: 1 if k % 2 else -1])
                             for k, e in enumerate(np.arange(-20.0, 20.0, 4.0))])  # fmt: skip
    points += 1e-5 * np.random.default_rng(10).standard_normal(points.shape)
    points /= np.linalg.norm(points, axis=1)[:, None]
    ahead = np.gradient(points, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    length = 0.01 * np.arange(float(len(points)))
    path = np.zeros(len(points), dtype=np.int64)
    rules = (3.0, 0.8, 0.7, 0.001)
    ours, theirs = (module.track_distances(points, ahead, length, path, rules) for module in (_sphere, fallback))
    assert np.isfinite(ours).mean() > 0.8
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)
    reach, shared = np.random.default_rng(11).uniform(0.01, 0.15, len(points)), np.arange(len(points)) % 5 > 0
    ours, theirs = (module.shared_reach(points, reach, shared) for module in (_sphere, fallback))
    assert (ours[shared] > reach[shared]).any()
    np.testing.assert_array_equal(ours[~shared], reach[~shared])
    assert np.mean(np.abs(ours - theirs) > 1e-6) < 0.02  # pairs across the horizon's images
    of_cells = [module.cells(points, reach, shared, True)[0] for module in (_sphere, fallback)]
    np.testing.assert_allclose(of_cells[0], _sphere.cells(points, ours, NONE, True)[0])
    assert of_cells[0].sum() == pytest.approx(of_cells[1].sum(), rel=1e-3)
