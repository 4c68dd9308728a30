"""test_evaluate.py: resolved models at directions: closed forms, edges, and the compiled loop beside numpy's."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from sampled_nodes import directions

from gonio.model import evaluate as evaluation
from gonio.model import fallback
from gonio.model.evaluate import evaluate
from gonio.model.hemisphere import disc_from_unit, tangent_axes
from gonio.model.lobe import Lobe
from gonio.model.slices import LEAST_COSINE, PATCH_HALF_WIDTH, Grids, Slices

_model = pytest.importorskip("gonio.model._model")
FloatArray = NDArray[np.float64]


def whitening(covariance: FloatArray) -> FloatArray:
    """W with W C W' = 1."""
    return np.linalg.inv(np.linalg.cholesky(covariance))


def slices_of(
    lobes: list[Lobe],
    patches: list[list[tuple[int, float]]] | None = None,
    fields: list[tuple[int, float, FloatArray, FloatArray, bool]] | None = None,
    scale: float = 1.0,
) -> Slices:
    """One slice; patches of each lobe: grid, weight; fields: grid, weight, matrix, shift, whether as BSDF."""
    of = patches or [[] for _ in lobes]
    flat = [one for own in of for one in own]
    grounds = fields or []
    return Slices(
        scale=np.array([scale]),
        lobe_start=np.array([0, len(lobes)]),
        lobe_frame=tangent_axes(np.array([one.centre for one in lobes]).reshape(-1, 3)),
        lobe_whitening=np.array([whitening(one.covariance_rad2) for one in lobes]).reshape(-1, 2, 2),
        lobe_peak_per_sr=np.array([one.peak_per_sr for one in lobes]),
        patch_start=np.cumsum([0] + [len(own) for own in of]),
        patch_grid=np.array([one[0] for one in flat], dtype=np.int64),
        patch_weight=np.array([one[1] for one in flat], dtype=np.float64),
        field_start=np.array([0, len(grounds)]),
        field_grid=np.array([one[0] for one in grounds], dtype=np.int64),
        field_weight=np.array([one[1] for one in grounds], dtype=np.float64),
        field_matrix=np.array([one[2] for one in grounds]).reshape(-1, 2, 2),
        field_shift=np.array([one[3] for one in grounds]).reshape(-1, 2),
        field_as_bsdf=np.array([one[4] for one in grounds], dtype=np.bool_),
    )


def plane(size: int, half_width: float, constant: float, along_x: float, along_y: float) -> FloatArray:
    """Nodes of a linear function: bilinear interpolation has it exactly."""
    x = np.linspace(-half_width, half_width, size)
    return constant + along_x * x[None, :] + along_y * x[:, None]


def tilted(theta_deg: float, phi_deg: float) -> FloatArray:
    theta, phi = np.radians([theta_deg, phi_deg])
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


NO_GRIDS = Grids.of([])
STILL = (np.eye(2), np.zeros(2), False)


@given(
    theta=st.floats(0.0, 90.0),
    phi=st.floats(0.0, 360.0),
    sigma_deg=st.tuples(st.floats(0.05, 60.0), st.floats(0.05, 60.0)),
    slant=st.floats(-0.9, 0.9),
)
def test_a_lobe_is_the_lobe(theta: float, phi: float, sigma_deg: tuple[float, float], slant: float) -> None:
    a, b = np.radians(sigma_deg)
    lobe = Lobe(tilted(theta, phi), np.array([[a * a, slant * a * b], [slant * a * b, b * b]]), 3.0)
    unit = np.concatenate(
        (directions(300), lobe.centre + np.radians(0.5) * np.random.default_rng(2).normal(size=(300, 3)))
    )
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    np.testing.assert_allclose(
        evaluate(slices_of([lobe]), NO_GRIDS, unit), lobe.dsf_per_sr(unit), rtol=1e-9, atol=1e-14
    )


@pytest.mark.usefixtures("who_answers")
def test_what_lies_beside_a_lobe_ends_with_its_grid() -> None:
    lobe = Lobe(tilted(40.0, 70.0), np.array([[4e-4, 1e-4], [1e-4, 9e-4]]), 0.0)
    grids = Grids.of([plane(9, PATCH_HALF_WIDTH, 5.0, 0.5, -0.25), plane(5, PATCH_HALF_WIDTH, 1.0, 0.0, 0.125)])
    unit = lobe.centre + 0.07 * np.random.default_rng(3).normal(size=(4000, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    axes = tangent_axes(lobe.centre)
    local = unit @ axes.T
    across = np.hypot(local[:, 0], local[:, 1])
    u = local[:, :2] * (np.arctan2(across, local[:, 2]) / across)[:, None]
    x, y = whitening(lobe.covariance_rad2) @ u.T
    inside = np.maximum(np.abs(x), np.abs(y)) <= 4.0
    expected = np.where(inside, 0.75 * (5.0 + 0.5 * x - 0.25 * y) + 0.5 * (1.0 + 0.125 * y), 0.0)
    assert 0.2 < np.mean(inside) < 0.9
    found = evaluate(slices_of([lobe], [[(0, 0.75), (1, 0.5)]]), grids, unit)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.usefixtures("who_answers")
def test_backgrounds_at_rest_turned_and_moved() -> None:
    grids = Grids.of([plane(17, 1.0, 2.0, 0.5, -0.25)])
    unit = directions(2000)

    def at(x: FloatArray) -> FloatArray:
        """The grid's linear function at direction cosines (m, 2), moved to the rim where they are none."""
        x = x / np.maximum(np.linalg.norm(x, axis=1), 1.0)[:, None]
        z = np.sqrt(np.maximum(1.0 - np.sum(x**2, axis=1), 0.0))
        disc = x / np.sqrt(1.0 + z)[:, None]
        return 2.0 + disc @ np.array([0.5, -0.25])

    turn = np.array([[0.6, 0.8], [0.8, -0.6]])
    shift = np.array([0.4, -0.2])
    for matrix, by in ((np.eye(2), np.zeros(2)), (turn, np.zeros(2)), (np.eye(2), shift), (turn, shift)):
        found = evaluate(slices_of([], fields=[(0, 0.5, matrix, by, False)]), grids, unit)
        np.testing.assert_allclose(found, 0.5 * at(unit[:, :2] @ matrix.T + by), rtol=1e-7)  # z is lost by the horizon
    moved = unit[:, :2] + shift
    z = np.sqrt(np.maximum(1.0 - np.sum(moved**2, axis=1), 0.0))
    found = evaluate(slices_of([], fields=[(0, 1.0, np.eye(2), shift, True)]), grids, unit)
    np.testing.assert_allclose(found, at(moved) * unit[:, 2] / np.maximum(z, LEAST_COSINE), rtol=1e-7)


@pytest.mark.usefixtures("who_answers")
def test_a_sum_is_not_negative_and_scaled_after() -> None:
    grids = Grids.of([plane(3, 1.0, 0.0, 1.0, 0.0)])
    unit = directions(500)
    found = evaluate(slices_of([], fields=[(0, 1.0, *STILL)], scale=0.5), grids, unit)
    np.testing.assert_allclose(found, 0.5 * np.maximum(disc_from_unit(unit)[:, 0], 0.0), rtol=1e-12, atol=1e-16)
    lobe = Lobe(np.array([0.0, 0.0, 1.0]), np.eye(2), 10.0)  # more than fills what is missing
    both = evaluate(slices_of([lobe], fields=[(0, 1.0, *STILL)]), grids, unit)
    np.testing.assert_allclose(both, lobe.dsf_per_sr(unit) + disc_from_unit(unit)[:, 0], rtol=1e-12)


def any_slices(seed: int, k: int = 7) -> tuple[Slices, Grids]:
    """k slices with none to five lobes, none to two patches each, none to three fields."""
    random = np.random.default_rng(seed)
    lobes, patches, fields = (random.integers(0, most, k) for most in (6, 1, 4))
    patches = random.integers(0, 3, lobes.sum())
    total, beside, grounds = lobes.sum(), patches.sum(), fields.sum()
    sigma = np.radians(random.choice([0.3, 1.2, 6.0, 25.0], size=(total, 2)))
    turn = random.random(total) * 7.0
    rotation = np.stack((np.cos(turn), np.sin(turn), -np.sin(turn), np.cos(turn)), axis=1).reshape(-1, 2, 2)
    angle = random.random(grounds) * 7.0
    slices = Slices(
        scale=random.random(k) + 0.5,
        lobe_start=np.concatenate(([0], np.cumsum(lobes))),
        lobe_frame=tangent_axes(directions(total + 2, seed)[:-2]),
        lobe_whitening=rotation / sigma[:, :, None],
        lobe_peak_per_sr=10.0 ** random.uniform(-2, 2, total),
        patch_start=np.concatenate(([0], np.cumsum(patches))),
        patch_grid=random.integers(0, 2, beside),
        patch_weight=random.normal(size=beside),
        field_start=np.concatenate(([0], np.cumsum(fields))),
        field_grid=random.integers(0, 3, grounds),
        field_weight=random.normal(size=grounds),
        field_matrix=np.stack((np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)), 1).reshape(-1, 2, 2),
        field_shift=random.choice([0.0, 0.2, -0.7], size=(grounds, 2)),
        field_as_bsdf=random.random(grounds) < 0.5,
    )
    return slices, Grids.of([random.normal(size=(n, n)) for n in (9, 33, 2)])


@pytest.mark.parametrize("seed", range(12))
def test_compiled_and_numpy_agree(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    slices, grids = any_slices(seed)
    unit = directions(20_000, seed)  # enough for several threads
    which = np.random.default_rng(seed).integers(0, 7, len(unit))
    compiled = evaluate(slices, grids, unit, which)
    first = evaluate(slices, grids, unit)
    monkeypatch.setattr(evaluation, "model", fallback)
    np.testing.assert_allclose(compiled, evaluate(slices, grids, unit, which), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(first, evaluate(slices, grids, unit), rtol=1e-9, atol=1e-12)


@pytest.mark.usefixtures("who_answers")
def test_far_from_the_hemisphere_and_no_direction() -> None:
    wide = Lobe(np.array([1.0, 0.0, 0.0]), np.eye(2), 1.0)
    grids = Grids.of([plane(3, 1.0, 1.0, 0.0, 0.0)])
    slices = slices_of([wide], fields=[(0, 1.0, *STILL)])
    antipode = np.array([[-1.0, 0.0, 0.0]])
    np.testing.assert_allclose(evaluate(slices, grids, antipode), 1.0 + np.exp(-(np.pi**2) / 2), rtol=1e-9)
    nowhere = np.array([[np.nan, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0], [np.inf, 0.0, 0.0]])
    assert np.all(np.isnan(evaluate(slices, grids, nowhere)))
    assert len(evaluate(slices, grids, np.zeros((0, 3)), np.zeros(0, dtype=np.int64))) == 0


@pytest.mark.usefixtures("who_answers")
def test_indices_that_lead_nowhere_are_refused() -> None:
    slices, grids = any_slices(4)
    unit = directions(3)
    assert len(slices.patch_grid)
    assert len(slices.field_grid)
    broken = [
        replace(slices, patch_grid=slices.patch_grid + 3),
        replace(slices, field_grid=slices.field_grid - 3),
        replace(slices, lobe_start=slices.lobe_start + 1),
        replace(slices, field_start=slices.field_start[:-1]),
        replace(slices, patch_start=slices.patch_start[::-1].copy()),
        replace(slices, lobe_peak_per_sr=slices.lobe_peak_per_sr[1:]),
        replace(slices, field_shift=slices.field_shift[1:]),
    ]
    for one in broken:
        with pytest.raises(ValueError, match=r"do not fit|is needed|are needed|does not lie|no such grid|as long as"):
            evaluate(one, grids, unit)
    for which in (np.array([0, 7, 0]), np.array([-1, 0, 0]), np.array([0, 0])):
        with pytest.raises(ValueError, match="slice"):
            evaluate(slices, grids, unit, which)
    for bad in (
        replace(grids, start=grids.start + 5),
        replace(grids, size=grids.size - 1),
        replace(grids, start=grids.start[1:]),
    ):
        with pytest.raises(ValueError, match=r"do not fit|is needed|are needed|does not lie|no such grid|as long as"):
            evaluate(slices, bad, unit)
