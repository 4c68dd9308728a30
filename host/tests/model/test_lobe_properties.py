"""test_lobe_properties.py: two lobes that can be told apart are found; a scene turned or scaled has its lobes so."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gonio.model.lobe import Lobe
from gonio.model.lobes.fit import fit_lobes

COUNT = 8000


def _directions() -> np.ndarray:
    k = np.arange(COUNT) + 0.5
    z = 1.0 - k / COUNT
    phi = k * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z**2)
    return np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=1)


UNIT = _directions()
SOLID_ANGLE = np.full(COUNT, 2.0 * np.pi / COUNT)
ZERO = np.zeros(COUNT)


@st.composite
def lobes(draw: st.DrawFn) -> Lobe:
    theta = np.arccos(1.0 - draw(st.floats(0.0, 0.75)))
    phi = draw(st.floats(0.0, 6.28))
    first = np.radians(draw(st.floats(2.0, 10.0)))
    second = first * draw(st.floats(1.0, 1.6))
    turn = draw(st.floats(0.0, 3.14))
    axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    centre = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    peak = float(np.exp(draw(st.floats(np.log(0.3), np.log(200.0)))))
    return Lobe(centre, axes @ np.diag([first**2, second**2]) @ axes.T, peak)


def _told_apart(a: Lobe, b: Lobe) -> bool:
    apart = float(np.arccos(np.clip(a.centre @ b.centre, -1.0, 1.0)))
    if apart < 2.5 * max(a.sigma_rad[1], b.sigma_rad[1]):
        return False
    return all(
        g.peak_per_sr > 0.5 * (0.08 * g.centre[2] + float(o.dsf_per_sr(g.centre[None, :])[0]))
        for g, o in ((a, b), (b, a))
    )


def _off(found: Lobe, true: Lobe) -> float:
    """Largest difference over the true lobe's peak, on the hemisphere."""
    return float(np.abs(found.dsf_per_sr(UNIT) - true.dsf_per_sr(UNIT)).max()) / true.peak_per_sr


@settings(max_examples=40, deadline=None, derandomize=True)
@given(lobes(), lobes())
def test_two_lobes_on_a_cosine(a: Lobe, b: Lobe) -> None:
    assume(_told_apart(a, b))
    dsf = 0.08 * UNIT[:, 2] + a.dsf_per_sr(UNIT) + b.dsf_per_sr(UNIT)
    found = fit_lobes(UNIT, dsf, ZERO, SOLID_ANGLE)
    assert len(found) == 2
    for true in (a, b):
        assert min(_off(g, true) for g in found) < 0.03


@settings(max_examples=15, deadline=None, derandomize=True)
@given(lobes(), st.floats(0.3, 6.0), st.floats(-6.0, 6.0))
def test_a_turned_and_scaled_scene_has_turned_and_scaled_lobes(a: Lobe, turn: float, log_scale: float) -> None:
    cos, sin, scale = np.cos(turn), np.sin(turn), float(np.exp(log_scale))
    about_normal = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    dsf = 0.08 * UNIT[:, 2] + a.dsf_per_sr(UNIT)
    turned = UNIT @ about_normal.T
    (before,) = fit_lobes(UNIT, dsf, ZERO, SOLID_ANGLE)
    (after,) = fit_lobes(turned, scale * dsf, ZERO, SOLID_ANGLE)
    np.testing.assert_allclose(
        after.dsf_per_sr(turned), scale * before.dsf_per_sr(UNIT), atol=0.02 * scale * a.peak_per_sr
    )
