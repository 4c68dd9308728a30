"""test_ggx.py: GGX surfaces: Fresnel's closed forms, normalisation, furnace, reciprocity, refraction."""

import numpy as np
import pytest
from analytic_cases import ONE, hemisphere, integral_by_scipy, light
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from gonio.model.analytic import Component, fresnel
from gonio.model.analytic.ggx import GGXThrough, distribution, facet_reflection, visible

N = 200_000


def test_fresnel_closed_forms() -> None:
    n = 1.52
    assert fresnel.dielectric(np.ones(1), n)[0] == pytest.approx(((n - 1) / (n + 1)) ** 2, rel=1e-12)
    # At Brewster's angle only s is reflected: half of ((n^2 - 1) / (n^2 + 1))^2.
    brewster = np.cos(np.arctan([n]))
    assert fresnel.dielectric(brewster, n)[0] == pytest.approx(0.5 * ((n**2 - 1) / (n**2 + 1)) ** 2, rel=1e-12)
    assert fresnel.dielectric(np.zeros(1), n)[0] == pytest.approx(1.0)
    critical = np.sqrt(1 - 1 / n**2)  # cosine, from inside: sin = 1 / n
    assert fresnel.dielectric(np.array([critical * 0.99]), 1 / n)[0] == 1.0
    # Stokes: the same from both sides of the interface along one ray.
    inside = np.sqrt(1 - (np.sin(0.6) / n) ** 2)
    assert fresnel.dielectric(np.array([np.cos(0.6)]), n) == pytest.approx(
        fresnel.dielectric(np.array([inside]), 1 / n)
    )
    assert fresnel.schlick(np.array([1.0, 0.0]), 0.04) == pytest.approx([0.04, 1.0])


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.5, 1.0])
def test_facets_cover_the_surface_once(alpha: float) -> None:
    """The integral of D cos over the hemisphere is 1 (Walter et al. 2007, eq. 4)."""
    total = quad(
        lambda c: 2 * np.pi * float(distribution(np.array(c), alpha)) * c, 0, 1, points=[1 - alpha**2 / 2], epsabs=0
    )[0]
    assert total == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize("alpha", [0.15, 0.4, 1.0])
@pytest.mark.parametrize("theta", [0.0, 40.0, 75.0])
def test_weak_furnace(alpha: float, theta: float) -> None:
    """With F = 1 and only the incident side's shadowing all light that meets visible facets leaves, some of it
    downwards: over the whole sphere the integral of G1(i) D / (4 cos) is 1 (Heitz 2014, section 5.2)."""
    z = 1 - (np.arange(N) + 0.5) / N * 2
    phi = np.pi * (3 - np.sqrt(5)) * np.arange(N)
    across = np.sqrt(1 - z**2)
    o = np.stack((across * np.cos(phi), across * np.sin(phi), z), axis=-1)
    i = light(theta)
    half = i + o
    half /= np.linalg.norm(half, axis=1)[:, None]
    d = np.where(half[:, 2] > 0, distribution(half[:, 2], alpha), 0.0)
    total = float(np.mean(visible(i[:, 2], alpha) * d / (4 * i[:, 2]))) * 4 * np.pi
    assert total == pytest.approx(1.0, abs=2e-3)
    # The family's BRDF is this with the leaving side's shadowing too.
    up = o[:, 2] > 0.01
    facet, _ = facet_reflection(np.repeat(i, up.sum(), axis=0), o[up], np.full(up.sum(), alpha))
    assert facet * o[up, 2] == pytest.approx(
        (visible(i[:, 2], alpha) * visible(o[:, 2], alpha) * d / (4 * i[:, 2]))[up]
    )


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("theta", [0.0, 30.0, 60.0, 85.0])
def test_mirror_facets_never_gain_light(alpha: float, theta: float) -> None:
    total = float(Component.of("ggx", "reflection", diffuse=0.0, alpha=alpha, f0=1.0).integral(np.array([theta]))[0])
    assert total <= 1.0 + 1e-9
    if alpha <= 0.05 and theta <= 60:
        assert total > 0.98  # smooth: nearly nothing is scattered twice


@pytest.mark.parametrize("theta", [0.0, 45.0, 80.0])
@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("ggx", {"diffuse": 0.2, "alpha": 0.3, "f0": 0.04}),
        ("ggx-dielectric", {"diffuse": 0.1, "alpha": 0.1, "index": 1.5}),
    ],
)
def test_integral_by_scipy(name: str, parameters: dict[str, float], theta: float) -> None:
    component = Component.of(name, "reflection", **parameters)
    assert component.integral(np.array([theta]))[0] == pytest.approx(integral_by_scipy(component, theta), rel=2e-5)


@settings(max_examples=80, deadline=None)
@given(st.floats(0.01, 1.0), st.floats(0, 88), st.floats(0, 360), st.floats(0, 88), st.floats(0, 360))
def test_reciprocity(alpha: float, ti: float, pi: float, to: float, po: float) -> None:
    i, o = light(ti, pi), light(to, po)
    for name, parameters in (("ggx", {"f0": 0.1}), ("ggx-dielectric", {"index": 1.6})):
        component = Component.of(name, "reflection", diffuse=0.1, alpha=alpha, **parameters)
        there, back = (component.bsdf_per_sr(x, y, ONE)[0] for x, y in ((i, o), (o, i)))
        assert there == pytest.approx(back, rel=1e-6)


@settings(max_examples=80, deadline=None)
@given(st.floats(0.05, 1.0), st.floats(1.1, 2.5), st.floats(0, 80), st.floats(0, 80), st.floats(0, 360))
def test_transmission_is_reciprocal_up_to_index_squared(
    alpha: float, n: float, ti: float, to: float, po: float
) -> None:
    """BTDF(i to o) / n_o^2 = BTDF(o to i) / n_i^2 (Walter et al. 2007, eq. 19 and the note on radiance)."""
    i, o = light(ti), light(to, po)
    family = GGXThrough()
    into, out = (np.array([[0.0, alpha, index]]) for index in (n, 1 / n))
    there, back = family.bsdf_per_sr(into, i, o, ONE)[0], family.bsdf_per_sr(out, o, i, ONE)[0]
    assert there / n**2 == pytest.approx(back, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("theta", [0.0, 30.0, 60.0])
def test_smooth_interface_refracts_as_snell_and_fresnel_say(theta: float) -> None:
    """A nearly smooth interface: all of 1 - R goes through, about sin(theta) / n; with reflection nothing is gained."""
    n, alpha = 1.5, 0.01
    component = Component.of("ggx-through", "transmission", diffuse=0.0, alpha=alpha, index=n)
    tau = float(component.integral(np.array([theta]))[0])
    reflected = float(fresnel.dielectric(np.cos(np.radians([theta])), n)[0])
    assert tau == pytest.approx(1 - reflected, abs=2e-3)
    peak = component.features(light(theta)).centre[0]
    assert np.hypot(peak[0], peak[1]) == pytest.approx(np.sin(np.radians(theta)) / n)
    z = np.linspace(0.3, 1, 4001)
    plane = np.stack((-np.sqrt(1 - z**2), np.zeros(len(z)), z), axis=-1)
    top = plane[np.argmax(component.bsdf_per_sr(light(theta), plane, np.zeros(len(z), dtype=np.int64)))]
    assert np.degrees(np.arccos(top @ peak)) < 1.0


@pytest.mark.parametrize("theta", [0.0, 40.0, 70.0])
def test_rough_interface_keeps_energy(theta: float) -> None:
    at = np.array([theta])
    rho = Component.of("ggx-dielectric", "reflection", diffuse=0.0, alpha=0.4, index=1.5).integral(at)[0]
    through = Component.of("ggx-through", "transmission", diffuse=0.0, alpha=0.4, index=1.5)
    assert 0.85 < rho + through.integral(at)[0] <= 1.0
    unit = hemisphere(N)
    plain = 2 * np.pi * float(np.mean(through.dsf_per_sr(light(theta), unit, np.zeros(N, dtype=np.int64))))
    assert through.integral(at)[0] == pytest.approx(plain, rel=3e-3)
