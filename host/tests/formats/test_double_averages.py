"""test_double_averages.py: averages over pairs of patches against closed forms, scipy's quadrature and Monte Carlo."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from lopsided_sample import Lopsided, exact_matrices
from numpy.typing import NDArray
from scipy.integrate import dblquad
from scipy.stats import qmc

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Features, FloatArray, IndexArray, Origin
from gonio.formats.patches import pairs, turned
from gonio.formats.patches.average import average
from gonio.formats.patches.hemispheres import Component
from gonio.formats.patches.rules import gauss, kronrod, moments_of_parts
from gonio.formats.window.klems import BASES, KlemsBasis, basis_from_rings, direction_of_patch_deg, to_radiance_deg
from gonio.geometry.directions import unit_from_angles_deg

FULL, QUARTER = BASES["klems-full"], BASES["klems-quarter"]
SMALL = basis_from_rings("small", (0, 40, 75), (0, 20, 60, 90), (1, 4, 6))


@dataclass(frozen=True)
class Formula:
    """DSF = 0.3 cos^power / pi + peak exp(-a^2 / 2 sigma^2) about a direction that follows the incident one: mirrored,
    then turned by `twist_deg` about the normal and shifted; all sides alike, by |z|, but for a factor of each side."""

    power: float = 1.0
    peak_per_sr: float = 0.0
    sigma_deg: float = 8.0
    twist_deg: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    only_front: bool = True

    def centre(self, incident: FloatArray) -> FloatArray:
        t = np.radians(180.0 + self.twist_deg)
        x = np.cos(t) * incident[:, 0] - np.sin(t) * incident[:, 1] + self.shift[0]
        y = np.sin(t) * incident[:, 0] + np.cos(t) * incident[:, 1] + self.shift[1]
        found = np.stack((x, y, np.abs(incident[:, 2])), axis=1)
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))

    def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
        rows = np.zeros(len(outgoing), dtype=np.int64) if which is None else which
        up = outgoing * np.array([1.0, 1.0, 0.0]) + np.abs(outgoing[:, 2:]) * np.array([0.0, 0.0, 1.0])
        chord = np.linalg.norm(up - self.centre(incident)[rows], axis=1)
        angle = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
        value = 0.3 / np.pi * up[:, 2] ** self.power
        value += self.peak_per_sr * np.exp(-0.5 * (angle / np.radians(self.sigma_deg)) ** 2)
        there = np.ones(len(rows), dtype=bool)
        if self.only_front:
            there = (incident[rows, 2] >= 0) & (outgoing[:, 2] >= 0)
        sides = np.where(outgoing[:, 2] >= 0, 1.0, 0.5) * np.where(incident[rows, 2] >= 0, 1.0, 0.7)
        return np.where(there, value * sides, np.nan)

    def origin(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> NDArray[np.uint8]:
        absent = np.isnan(self.dsf_per_sr(incident, outgoing, which))
        return np.where(absent, Origin.ABSENT, Origin.MEASURED).astype(np.uint8)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        return not self.only_front or (incident_front and outgoing_front)

    def features(self, incident: FloatArray) -> Features:
        if self.peak_per_sr == 0.0:
            return Features.none()
        rows = np.arange(len(incident))
        return Features(self.centre(incident), np.full(len(rows), np.radians(self.sigma_deg)), rows)


def sampled(
    formula: Formula, basis: KlemsBasis, process: str, side: str, faces: str, row: int, column: int
) -> tuple[float, float]:
    """B of one cell by quasi Monte Carlo in the four angles, and its standard error; independent of Component."""
    blocks = []
    for seed in range(8):
        u = qmc.Sobol(4, seed=seed).random(4096)
        angles = []
        for patch, (a, b) in ((column, u[:, :2].T), (row, u[:, 2:].T)):
            low, high, start, width = basis.bounds_deg[patch]
            s = np.sin(np.radians([low, high])) ** 2
            polar = np.degrees(np.arcsin(np.sqrt(s[0] + a * (s[1] - s[0]))))
            angles.append((polar, start + b * width))
        (polar_i, azimuth_i), (polar_o, azimuth_o) = angles
        interior = (side == "Front") == (process == "Transmission")
        theta = 180.0 - polar_i if side == "Front" else polar_i
        incident = unit_from_angles_deg(*to_radiance_deg(theta, azimuth_i + 180.0, faces))  # type: ignore[arg-type]
        theta = polar_o if interior else 180.0 - polar_o
        outgoing = unit_from_angles_deg(*to_radiance_deg(theta, azimuth_o, faces))  # type: ignore[arg-type]
        dsf = formula.dsf_per_sr(incident, outgoing, np.arange(len(u)))
        blocks.append(float(np.mean(dsf / np.cos(np.radians(polar_o)))))
    return float(np.mean(blocks)), float(np.std(blocks, ddof=1) / np.sqrt(len(blocks)))


def assert_within(found: FloatArray, exact: FloatArray, basis: KlemsBasis, tolerance: float) -> None:
    """Energies of all cells together are off by less than this share of their column's sum."""
    size = basis.projected_solid_angle_sr
    assert (size @ np.abs(found - exact) < tolerance * (size @ exact)).all()


@pytest.mark.parametrize("nodes", [7, 15])
def test_rules_integrate_polynomials_of_their_degree(nodes: int) -> None:
    pair = kronrod(nodes)
    fine, coarse = 3 * (nodes // 2) + 1 + (nodes // 2) % 2, 2 * (nodes // 2) - 1
    for weights, degree in ((pair.fine, fine), (pair.coarse, coarse)):
        powers = np.arange(degree + 1)
        exact = np.where(powers % 2, 0.0, 1.0 / (powers + 1))
        np.testing.assert_allclose(weights @ pair.nodes[:, None] ** powers, exact, atol=1e-14)


@pytest.mark.parametrize("parts", [1, 2, 5, 16])
def test_moments_of_parts_are_those_of_the_polynomial(parts: int) -> None:
    nodes, _ = gauss()
    polynomial = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.0])
    found = np.einsum("n,npm->pm", polynomial(nodes), moments_of_parts(parts))
    edges = np.linspace(-1, 1, parts + 1)
    for number, (low, high) in enumerate(pairwise(edges)):
        about = polynomial * np.polynomial.Polynomial([-(low + high) / 2, 1.0])
        exact = [p.integ()(high) - p.integ()(low) for p in (polynomial, about)]
        np.testing.assert_allclose(found[number], exact, atol=1e-14)


@pytest.mark.parametrize("symmetry", ["isotropic", "none"])
@pytest.mark.parametrize("basis", ["klems-quarter", "klems-half", "klems-full"])
def test_cosine_powers_have_a_closed_form(basis: str, symmetry: str) -> None:
    chosen = BASES[basis]
    if symmetry == "none" and basis != "klems-quarter":
        chosen = SMALL
    for power in (1.0, 4.0):
        values = average(Formula(power), chosen, "interior", symmetry=symmetry).matrices["Reflection", "Back"]  # type: ignore[arg-type]
        low, high = np.cos(np.radians(chosen.bounds_deg[:, :2])).T
        width = np.radians(chosen.bounds_deg[:, 3])
        energy = 0.3 / np.pi * width * (low ** (power + 1) - high ** (power + 1)) / (power + 1)
        expected = (energy / chosen.projected_solid_angle_sr)[:, None] * np.ones(chosen.size)
        assert_within(values, expected, chosen, 2e-5)


def test_sides_follow_window() -> None:
    """Front is light from the exterior; factors of Formula tell the four matrices apart."""
    sides = Formula(only_front=False)
    for faces, front in (("interior", "Back"), ("exterior", "Front")):
        back = "Front" if front == "Back" else "Back"
        found = average(sides, SMALL, faces, symmetry="isotropic").matrices  # type: ignore[arg-type]
        sums = {key: float(SMALL.projected_solid_angle_sr @ m[:, 0]) for key, m in found.items()}
        assert sums["Reflection", front] == pytest.approx(0.3, rel=1e-5)
        assert sums["Transmission", front] == pytest.approx(0.15, rel=1e-5)
        assert sums["Transmission", back] == pytest.approx(0.21, rel=1e-5)
        assert sums["Reflection", back] == pytest.approx(0.105, rel=1e-5)


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_lopsided_peak_against_sampling(faces: str) -> None:
    """No symmetry at all: twisted about the normal and shifted. Cells and sides against quasi Monte Carlo."""
    formula = Formula(2.0, 3.0, 12.0, 35.0, (0.15, -0.1), only_front=False)
    found = average(formula, SMALL, faces, symmetry="none").matrices  # type: ignore[arg-type]
    assert len(found) == 4
    for process, side, column in (("Transmission", "Front", 2), ("Reflection", "Back", 7), ("Reflection", "Front", 0)):
        values = found[process, side][:, column]  # type: ignore[index]
        for row in (int(np.argmax(values)), 3, 9):
            expected, error = sampled(formula, SMALL, process, side, faces, row, column)
            assert values[row] == pytest.approx(expected, abs=6 * error + 1e-6)


def test_an_isotropic_sample_that_is_no_mirror_image_of_itself() -> None:
    """A peak twisted about the normal: left and right differ; turned.py against pairs.py and sampling."""
    formula = Formula(1.0, 3.0, 10.0, 25.0)
    key = ("Reflection", "Front")
    values = average(formula, QUARTER, "exterior", symmetry="isotropic").matrices[key]  # type: ignore[index]
    columns = np.array([0, 5, 24])
    component = Component(formula, "Reflection", "Front", "exterior")
    direct, _ = pairs.matrix(component, QUARTER, 1e-4, columns)
    sums = QUARTER.projected_solid_angle_sr @ values
    off = np.abs(values - direct)[:, columns] * QUARTER.projected_solid_angle_sr[:, None]
    assert (off.sum(axis=0) < 1e-4 * sums[columns]).all()
    for column in (5, 24):
        row = int(np.argmax(values[:, column]))
        expected, error = sampled(formula, QUARTER, *key, "exterior", row, column)
        assert values[row, column] == pytest.approx(expected, abs=6 * error + 1e-6)
    mirrored = np.roll(values[9:21, 9][::-1], 1)
    assert np.abs(mirrored - values[9:21, 9]).max() > 0.1 * values.max()


@pytest.mark.parametrize("sigma_deg", [1.2, 0.3])
def test_narrow_peaks_meet_the_tolerance(sigma_deg: float) -> None:
    """Against scipy: energy of the retro peak that leaves through one patch, averaged over a ring of incident ones."""
    coating = RetroCoating(0.0, 1.0, sigma_deg, 0.0)
    found = average(coating, QUARTER, "interior", symmetry="isotropic")
    values = found.matrices["Reflection", "Back"]
    ring = 2
    own = QUARTER.rings[ring]
    low, high = np.radians([own.lower_deg, own.upper_deg])
    # Far from its borders all of the peak is inside: a flat Gaussian's power, less a curvature of sigma^2 / 3.
    sigma = np.radians(sigma_deg)
    power = 2 * np.pi * sigma**2 * (1 - sigma**2 / 3)
    sums = QUARTER.projected_solid_angle_sr @ values
    column = int(QUARTER.ring_start[ring])
    assert sums[column] == pytest.approx(power, rel=2e-4)
    assert (found.error["Reflection", "Back"] < 1e-4 * sums).all()
    # The diagonal: in theta and in azimuth the peak leaves over the borders, each an integral of an error function.
    incident = Component(coating, "Reflection", "Back", "interior")

    def inside(polar_i: float, azimuth_i: float) -> float:
        a = np.linspace(low, high, 61)
        b = np.linspace(-np.pi / own.patches, np.pi / own.patches, 61)
        polar, azimuth = (grid.ravel() for grid in np.meshgrid(a, b, indexing="ij"))
        source = incident.incident(np.array([polar_i]), np.array([azimuth_i]))
        # The retro direction has the source's azimuth: the column's plus 180 degrees.
        leaving = incident.outgoing(polar, azimuth + np.pi)
        dsf = coating.dsf_per_sr(source, leaving) * np.sin(polar)
        return float(np.trapezoid(np.trapezoid(dsf.reshape(61, 61), b, axis=1), a))

    if sigma_deg > 1.0:
        energy, _ = dblquad(
            lambda t, p: inside(t, p) * np.cos(t) * np.sin(t), 0.0, np.pi / own.patches, low, high, epsrel=1e-2
        )
        opposite = column + own.patches // 2
        expected = 2 * energy / own.projected_solid_angle_sr**2
        assert values[opposite, column] == pytest.approx(expected, rel=5e-3)


def test_what_a_tighter_tolerance_changes_is_within_the_estimate() -> None:
    coating = RetroCoating()
    usual, fine = (average(coating, QUARTER, "interior", symmetry="isotropic", tolerance=t) for t in (1e-4, 2e-5))
    key = ("Reflection", "Back")
    size = QUARTER.projected_solid_angle_sr
    change = size @ np.abs(usual.matrices[key] - fine.matrices[key])  # type: ignore[index]
    assert (change < usual.error[key]).all()  # type: ignore[index]
    assert (usual.error[key] < 1e-4 * (size @ fine.matrices[key])).all()  # type: ignore[index]


@pytest.mark.parametrize(
    ("symmetry", "formula"),
    [
        ("bilateral", Formula(1.0, 2.0, 15.0, 0.0, (0.2, 0.0))),
        ("bilateral", Formula(1.0, 2.0, 15.0, 0.0, (0.0, 0.2))),
        ("quadrilateral", Formula(1.0, 2.0, 15.0)),
        ("up", Formula(1.0, 2.0, 15.0, 20.0)),
        ("quadrilateral", Formula(1.0, 2.0, 15.0, 20.0, (0.1, 0.1))),  # declared, but it is not so
    ],
)
def test_declared_symmetries_change_nothing_but_the_work(symmetry: str, formula: Formula) -> None:
    component = Component(formula, "Reflection", "Back", "interior")
    plain, _ = pairs.matrix(component, SMALL, 1e-4, np.arange(SMALL.size))
    found = average(formula, SMALL, "interior", symmetry=symmetry).matrices["Reflection", "Back"]  # type: ignore[arg-type]
    assert_within(found, plain, SMALL, 1e-4)


def test_a_basis_whose_borders_meet_no_bins_is_done_the_long_way() -> None:
    odd = basis_from_rings("odd", (0, 60), (0, 30, 90), (1, 7))
    assert not turned.fits(odd)
    values = average(Formula(3.0), odd, "interior", symmetry="isotropic").matrices["Reflection", "Back"]
    low, high = np.cos(np.radians(odd.bounds_deg[:, :2])).T
    energy = 0.3 / np.pi * np.radians(odd.bounds_deg[:, 3]) * (low**4 - high**4) / 4
    expected = (energy / odd.projected_solid_angle_sr)[:, None] * np.ones(odd.size)
    assert_within(values, expected, odd, 1e-4)


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_lopsided_sample_in_closed_form(faces: str) -> None:
    """Affine in the direction cosines: all four matrices are known exactly."""
    found = average(Lopsided(), SMALL, faces, symmetry="none").matrices  # type: ignore[arg-type]
    for key, exact in exact_matrices(SMALL, faces).items():  # type: ignore[arg-type]
        assert_within(found[key], exact, SMALL, 2e-5)


def test_directions_are_those_of_the_writer() -> None:
    for faces in ("interior", "exterior"):
        for process in ("Transmission", "Reflection"):
            for side in ("Front", "Back"):
                own = Component(Formula(), process, side, faces)  # type: ignore[arg-type]
                polar, azimuth = np.radians(FULL.centres_deg[[17, 60]].T)
                incident, outgoing = direction_of_patch_deg(
                    FULL,
                    process,
                    side,
                    row=60,
                    column=17,
                    front_faces=faces,  # type: ignore[arg-type]
                )
                np.testing.assert_allclose(own.incident(polar, azimuth)[0], unit_from_angles_deg(*incident), atol=1e-12)
                np.testing.assert_allclose(own.outgoing(polar, azimuth)[1], unit_from_angles_deg(*outgoing), atol=1e-12)
                back = own.place_of_incident(own.incident(polar, azimuth))
                np.testing.assert_allclose(np.exp(1j * back[1]), np.exp(1j * azimuth), atol=1e-12)
                np.testing.assert_allclose(back[0], polar, atol=1e-12)
