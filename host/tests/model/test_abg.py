"""test_abg.py: the ABg family: closed forms, independent quadrature, the anchors of paper [2], both fits."""

import numpy as np
import pytest
from analytic_cases import ONE, dataset, hemisphere, integral_by_scipy, light, measured
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from gonio.dataset.scattering import Bsdf
from gonio.formats.patches.average import average
from gonio.formats.window.klems import BASES
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.analytic import AnalyticScattering, Component, fit_family
from gonio.model.analytic.abg import distance


def abg(a: float, b: float, g: float, process: str = "reflection") -> Component:
    return Component.of("abg", process, A=a, B=b, g=g)  # type: ignore[arg-type]


@pytest.mark.parametrize("theta", [0.0, 20.0, 60.0, 89.0])
def test_no_slope_is_lambertian(theta: float) -> None:
    component = abg(0.3, 0.5, 0.0)
    assert component.integral(np.array([theta]))[0] == pytest.approx(np.pi * 0.3 / 1.5, rel=1e-12)
    bsdf = component.bsdf_per_sr(light(theta), hemisphere(50), np.zeros(50, dtype=np.int64))
    assert bsdf == pytest.approx(np.full(50, 0.2), rel=1e-12)


@pytest.mark.parametrize("b", [1.0, 1e-3, 1e-8])
def test_slope_two_at_normal_incidence(b: float) -> None:
    """The integral of A / (B + r^2) 2 pi r from 0 to 1 is pi A ln(1 + 1/B)."""
    assert abg(0.02, b, 2.0).integral(np.zeros(1))[0] == pytest.approx(np.pi * 0.02 * np.log(1 + 1 / b), rel=1e-12)


def test_slope_one_at_normal_incidence() -> None:
    """2 pi A (1 - B ln(1 + 1/B))."""
    assert abg(0.1, 0.03, 1.0).integral(np.zeros(1))[0] == pytest.approx(
        2 * np.pi * 0.1 * (1 - 0.03 * np.log(1 + 1 / 0.03)), rel=1e-12
    )


@pytest.mark.parametrize("theta", [0.0, 35.0, 70.0, 85.0])
@pytest.mark.parametrize(("a", "b", "g"), [(0.02, 1e-2, 2.0), (0.05, 0.01, 1.3), (0.01, 0.001, 4.0)])
def test_integral_by_scipy(a: float, b: float, g: float, theta: float) -> None:
    assert abg(a, b, g).integral(np.array([theta]))[0] == pytest.approx(
        integral_by_scipy(abg(a, b, g), theta), rel=2e-6
    )


@pytest.mark.parametrize("theta", [30.0, 75.0, 89.0])
def test_sharp_core_by_one_dimensional_quadrature(theta: float) -> None:
    """Circles about beta0: their length inside the unit disc, by scipy, with breaks where the function bends."""
    a, b, g = 1e-7, 1e-9, 3.0
    c = float(np.sin(np.radians(theta)))

    def ring(r: float) -> float:
        inside = 2 * np.pi if r <= 1 - c else 2 * np.arccos(np.clip((r * r + c * c - 1) / (2 * r * c), -1, 1))
        return a / (b + r**g) * r * float(inside)

    breaks = sorted([0.0, 1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.02, 0.1, 1 - c, 1 + c])
    truth = sum(quad(ring, lo, hi, epsabs=0, epsrel=1e-11, limit=400)[0] for lo, hi in zip(breaks, breaks[1:]))  # noqa: B905, RUF007
    assert abg(a, b, g).integral(np.array([theta]))[0] == pytest.approx(truth, rel=1e-8)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.001, 10.0),
    st.floats(0.0, 6.0),
    st.floats(0, 85),
    st.floats(0, 360),
    st.floats(0, 85),
    st.floats(0, 360),
)
def test_reciprocity(b: float, g: float, ti: float, pi: float, to: float, po: float) -> None:
    i, o = light(ti, pi), light(to, po)
    there, back = (abg(0.1, b, g).bsdf_per_sr(x, y, ONE)[0] for x, y in ((i, o), (o, i)))
    assert there == pytest.approx(back, rel=1e-9)


def test_peak_and_features() -> None:
    """A / B in the mirror direction; half of it at |beta - beta0| = B^(1/g); the core is told to integrators."""
    component = abg(0.02, 1e-4, 2.0)
    i = light(40.0, 30.0)
    mirror = i * [-1, -1, 1]
    assert component.bsdf_per_sr(i, mirror, ONE)[0] == pytest.approx(200.0)
    across = np.cross(mirror[0], [0, 0, 1.0])
    across /= np.linalg.norm(across)
    xy = mirror[0, :2] + 0.01 * across[:2]
    aside = np.array([[*xy, np.sqrt(1 - xy @ xy)]])
    assert component.bsdf_per_sr(i, aside, ONE)[0] == pytest.approx(100.0, rel=1e-9)
    both = AnalyticScattering({(True, True): component, (True, False): abg(0.02, 1e-4, 2.0, "transmission")})
    found = both.features(i)
    assert found.incident.tolist() == [0, 0]
    assert found.centre == pytest.approx(np.concatenate((mirror, -i)))
    assert found.sigma_rad == pytest.approx(np.full(2, 0.01 / 1.1774), rel=1e-3)
    assert len(AnalyticScattering({(True, True): abg(1.0, 1.0, 2.0)}).features(i).sigma_rad) == 0


# Anchors of paper [2], section 4.2.1: which |beta - beta0| the Klems patches see.
FULL = BASES["klems-full"]


def _patch_40() -> tuple[float, float, float, float]:
    ring = next(r for r in FULL.rings if r.nominal_theta_deg == 40.0)
    return ring.lower_deg, ring.upper_deg, 180.0 / ring.patches, ring.nominal_theta_deg


def test_anchor_specular_patch() -> None:
    """Centre to the middle of a side 0.064 to 0.069, to a corner 0.109; the neighbours reach to 0.2."""
    lower, upper, half, middle = _patch_40()
    centre = unit_from_angles_deg(middle, 180.0)
    i = centre[None, :] * [-1, -1, 1]

    def to(theta: float, phi: float) -> float:
        return float(distance(i, unit_from_angles_deg([theta], [180.0 + phi]), ONE)[0])

    sides = [to(lower, 0), to(upper, 0), to(middle, half)]
    assert min(sides) == pytest.approx(0.064, abs=0.005)
    assert max(sides) < 0.09
    assert sorted(round(s, 3) for s in sides)[:2] == pytest.approx([0.064, 0.069], abs=0.001)
    corners = [to(t, p) for t in (lower, upper) for p in (-half, half)]
    assert max(corners) == pytest.approx(0.109, abs=0.001)
    # A disc of radius 0.2 (one digit) about the centre lies within the patch and its neighbours.
    block = [to(middle, half * 3), to(lower - 10, 0), to(upper + 10, 0)]
    assert round(min(block), 1) == 0.2


def test_anchor_lambertian_far_share() -> None:
    """At normal incidence 91 % of a Lambertian distribution lies beyond 0.3: the disc less that of radius 0.3."""
    phi_in = np.linspace(0, 1, 200001)
    far = np.trapezoid(2 * phi_in * (phi_in > 0.3), phi_in)
    unit = hemisphere(400_000)
    r = distance(light(0.0), unit, np.zeros(len(unit), dtype=np.int64))
    share = float(unit[r > 0.3, 2].sum() / unit[:, 2].sum())
    assert share == pytest.approx(0.91, abs=0.001)
    assert share == pytest.approx(far, abs=1e-4)


def test_centre_values_are_unacceptable() -> None:
    """Patch centre, or mean of centre and corners, times projected solid angle is far from the exact integral for a
    core that patches do not resolve; it can exceed 1. Subdivided patches come to the exact value."""
    component = abg(6.2e-3, 1e-4, 2.3, "transmission")
    angles = np.array([40.0])
    i = light(40.0, 0.0)
    exact = float(component.integral(angles)[0])
    assert exact == pytest.approx(0.30, abs=0.01)

    def bsdf(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
        unit = unit_from_angles_deg(np.minimum(theta, 89.999), phi)
        flat = unit.reshape(-1, 3)
        return component.bsdf_per_sr(i, flat, np.zeros(len(flat), dtype=np.int64)).reshape(unit.shape[:-1])

    projected = FULL.projected_solid_angle_sr
    centre = FULL.centres_deg
    lower, upper, start, width = FULL.bounds_deg.T
    at_centre = bsdf(centre[:, 0], centre[:, 1])
    corners = np.stack([bsdf(t, p) for t in (lower, upper) for p in (start, start + width)])
    mean_of_five = (at_centre + corners.sum(axis=0)) / 5
    by_centre, by_five = float(at_centre @ projected), float(mean_of_five @ projected)
    assert by_centre > 1.0  # more than all light
    assert by_five > 1.3 * exact
    node, weight = np.polynomial.legendre.leggauss(60)
    sine2 = [np.sin(np.radians(edge)) ** 2 for edge in (lower, upper)]
    total = 0.0
    for patch in range(FULL.size):
        s = sine2[0][patch] + (node + 1) / 2 * (sine2[1][patch] - sine2[0][patch])
        theta = np.degrees(np.arcsin(np.sqrt(s)))
        phi = start[patch] + (node + 1) / 2 * width[patch]
        value = bsdf(*np.meshgrid(theta, phi))
        total += float(weight @ value @ weight) / 4 * projected[patch]
    assert total == pytest.approx(exact, rel=0.02)


def test_patch_averages_keep_the_exact_integral() -> None:
    """The writers' double patch average, guided by this family's features: a column's sum is the exact integral
    averaged over the incident patch, 2 sin cos weighted in theta, to the 1e-4 that the average promises."""
    s = AnalyticScattering({(True, True): abg(0.05, 0.3, 1.5), (True, False): abg(2e-3, 3e-5, 2.3, "transmission")})
    basis = BASES["klems-quarter"]
    matrices = average(s, basis, "exterior", symmetry="isotropic").matrices
    node, weight = np.polynomial.legendre.leggauss(12)
    for process, sides in (("Reflection", (True, True)), ("Transmission", (True, False))):
        sums = basis.projected_solid_angle_sr @ matrices[process, "Front"]  # type: ignore[index]
        for ring, first in zip(basis.rings, basis.ring_start, strict=False):
            low, high = (np.sin(np.radians(edge)) ** 2 for edge in (ring.lower_deg, ring.upper_deg))
            theta = np.degrees(np.arcsin(np.sqrt(low + (node + 1) / 2 * (high - low))))
            exact = float(weight @ s.components[sides].integral(theta)) / 2
            assert sums[first] == pytest.approx(exact, rel=2e-4), (process, ring.nominal_theta_deg)


ANGLES = (0.0, 15.0, 30.0, 45.0, 60.0, 72.0)


def truth_at(theta: float) -> tuple[float, float, float]:
    s = np.sin(np.radians(theta))
    return 0.01 * (1 + s), 4e-3 * (1 - 0.5 * s), 1.8 + 0.4 * s


@pytest.fixture(scope="module")
def fitted() -> Bsdf:
    parts = [measured({True: abg(*truth_at(t))}, t, noise=0.05, seed=int(t) + 7) for t in ANGLES]
    return fit_family(dataset(*parts), "abg")


def test_recovers_parameters_within_their_uncertainty(fitted: Bsdf) -> None:
    """Chi-square of 18 parameters in units of their stated u: 18 on average, beyond 42 in 1 of 1000."""
    record = fitted.provenance["model"]["channels"]["visible"]["components"]["front reflection"]
    chi2 = 0.0
    for line, theta in zip(record["fits"], ANGLES, strict=True):
        for name, truth in zip(("A", "B", "g"), truth_at(theta), strict=True):
            found = line["weighted"][name]
            assert found["u"] < 0.2 * truth
            chi2 += ((found["value"] - truth) / found["u"]) ** 2
    # Parameters of one angle are correlated, so this sum scatters more than chi-square; its mean is the same.
    assert 3.0 < chi2 < 70.0


def test_both_fits_are_reported(fitted: Bsdf) -> None:
    record = fitted.provenance["model"]["channels"]["visible"]["components"]["front reflection"]
    for line, theta in zip(record["fits"], ANGLES, strict=True):
        published, better = line["as_published"], line["weighted"]
        for entry in (published, better):
            assert {"rms_per_sr", "cv", "misplaced", "integral"} <= set(entry)
            assert entry["integral"] == pytest.approx(line["measured_integral"], rel=0.05)
        # The simplex on plain BSDF differences leans on the points of the peak; with little noise it finds A / B.
        peak = truth_at(theta)[0] / truth_at(theta)[1]
        assert published["A"] / published["B"] == pytest.approx(peak, rel=0.05)
        assert better["A"]["value"] / better["B"]["value"] == pytest.approx(peak, rel=0.02)


def test_integral_is_tied_at_every_angle(fitted: Bsdf) -> None:
    """The model's integral, by scipy, is the tie's value between the fitted angles too; at them the measured one."""
    scattering = fitted.channels["visible"]
    assert isinstance(scattering, AnalyticScattering)
    component = scattering.components[True, True]
    assert component.tie is not None
    for theta in (0.0, 22.0, 60.0, 80.0):
        assert integral_by_scipy(component, theta) == pytest.approx(
            float(component.tie.at(np.array([theta]))[0]), rel=1e-5
        )
    for theta in ANGLES:
        assert integral_by_scipy(component, theta) == pytest.approx(
            float(abg(*truth_at(theta)).integral(np.array([theta]))[0]), rel=1e-5
        )


def test_left_out_angle_is_predicted(fitted: Bsdf) -> None:
    """Held-out error of a family that fits is the noise; misplaced light of 5 % noise is about 2 %."""
    held = fitted.provenance["model"]["channels"]["visible"]["components"]["front reflection"]["held_out"]
    assert held["rule"] == "leave one incident direction out"
    inner = [line["misplaced"] for line in held["table"][0]["directions"][1:-1]]
    assert max(inner) < 0.04


def test_constant_parameters_between_angles(fitted: Bsdf) -> None:
    """Parameters between the angles lie between those of the neighbours."""
    scattering = fitted.channels["visible"]
    assert isinstance(scattering, AnalyticScattering)
    component = scattering.components[True, True]
    between = component.parameters_at(np.array([37.5]))[0]
    a, b = component.parameters_at(np.array([30.0, 45.0]))
    assert np.all((between >= np.minimum(a, b)) & (between <= np.maximum(a, b)))
    assert component.parameters_at(np.array([85.0])) == pytest.approx(component.parameters_at(np.array([72.0])))
