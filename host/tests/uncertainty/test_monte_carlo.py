"""test_monte_carlo.py: 2000 scans, every error drawn anew: stated 95 % intervals hold the truth in 93 to 97 %."""

import logging
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from repeated_scan import RepeatedScan, reference_scan

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import combined_u_per_sr, linear_result

FloatArray = NDArray[np.float64]

FIGURES = logging.getLogger("gonio.figures")  # pytest --log-cli-level=INFO prints them
COVERAGE_FACTOR = 1.96
SCANS, REPEATS = 20, 100  # so many scans state their uncertainty, each for so many repeats


@dataclass
class Coverage:
    """Share of 2000 repeats within 1.96 u: of every point (n,), and of integrals by name."""

    scan: RepeatedScan
    points: FloatArray
    integrals: dict[str, float]
    from_mirror_deg: FloatArray

    def of(self, chosen: NDArray[np.bool_]) -> float:
        return float(self.points[chosen].mean())


def coverage(scan: RepeatedScan, seed: int) -> Coverage:
    rng = np.random.default_rng(seed)
    theta, phi = np.radians(scan.incident_deg)
    mirror = np.array([-np.sin(theta) * np.cos(phi), -np.sin(theta) * np.sin(phi), np.cos(theta)])
    from_mirror_deg = np.degrees(np.arccos(np.clip(scan.unit @ mirror, -1.0, 1.0)))
    weights = integral_weights(scan.unit, scan.solid_angle_sr, from_mirror_deg)
    matrix = np.stack(list(weights.values()))
    inside, of_integrals = np.zeros(len(scan.unit)), np.zeros(len(matrix))
    for _ in range(SCANS):
        stated = scan.reduced(rng)
        u_points = combined_u_per_sr(stated)
        u_integrals = np.array([linear_result(stated, weight).u for weight in matrix])
        off = scan.repeats(REPEATS, rng)[0] - scan.true_dsf
        inside += np.count_nonzero(np.abs(off) <= COVERAGE_FACTOR * u_points, axis=0)
        of_integrals += np.count_nonzero(np.abs(off @ matrix.T) <= COVERAGE_FACTOR * u_integrals, axis=0)
    total = SCANS * REPEATS
    found = Coverage(scan, inside / total, dict(zip(weights, of_integrals / total, strict=True)), from_mirror_deg)
    FIGURES.info("coverage at %s: points %.4f, %s", scan.incident_deg, found.points.mean(), found.integrals)
    return found


def integral_weights(unit: FloatArray, omega: FloatArray, from_mirror_deg: FloatArray) -> dict[str, FloatArray]:
    """Weights (n,) of rho, cones about the mirror direction, and patches of some 14 x 14 degrees: far from the peak, in
    the lobe, and one whose border cuts the peak in two."""
    patches = {"patch in the lobe": (-25.0, 10.0), "patch far": (45.0, -20.0), "patch that cuts the peak": (-30.0, 7.0)}
    azimuth_deg = np.degrees(np.arctan2(unit[:, 0], unit[:, 2]))
    elevation_deg = np.degrees(np.arcsin(unit[:, 1]))
    weights = {"rho": omega}
    weights |= {f"cone {radius:g}": omega * (from_mirror_deg < radius) for radius in (2.0, 4.0, 10.0)}
    for name, centre in patches.items():
        near = (np.abs(azimuth_deg - centre[0]) < 7.0) & (np.abs(elevation_deg - centre[1]) < 7.0)
        weights[name] = omega * near
    return weights


@pytest.fixture(scope="module", params=[(30.0, 0.0), (5.0, 90.0)], ids=["oblique", "nearly normal, rolled"])
def covered(request: pytest.FixtureRequest) -> Coverage:
    """At 5 degrees the lobe about the mirror direction reaches over the retro direction, which would move otherwise."""
    return coverage(reference_scan(*request.param), seed=20261)


@pytest.mark.parametrize(
    ("what", "of_path", "nearer_deg", "from_deg"),
    [
        ("all points", None, 180.0, 0.0),
        ("top of the peak", 1, 0.3, 0.0),
        ("flanks of the peak", 1, 1.5, 0.3),
        ("points of the peak's spiral", 1, 180.0, 0.0),
        ("points of the coarse pass", 0, 180.0, 0.0),
        ("diffuse", 0, 180.0, 30.0),
    ],
)
def test_points(covered: Coverage, what: str, of_path: int | None, nearer_deg: float, from_deg: float) -> None:
    chosen = (covered.from_mirror_deg >= from_deg) & (covered.from_mirror_deg < nearer_deg)
    if of_path is not None:
        chosen &= covered.scan.flight.path == of_path
    FIGURES.info("coverage of %s: %.4f", what, covered.of(chosen))
    assert np.count_nonzero(chosen) > 10
    assert 0.93 <= covered.of(chosen) <= 0.97


@pytest.mark.parametrize(
    "name", ["rho", "cone 2", "cone 4", "cone 10", "patch in the lobe", "patch far", "patch that cuts the peak"]
)
def test_integrals(covered: Coverage, name: str) -> None:
    assert 0.93 <= covered.integrals[name] <= 0.97


@pytest.mark.parametrize("left_out", ["gain_ratio", "tilt_y", "p_i"])
def test_an_effect_left_out_is_seen(left_out: str) -> None:
    """The same judgement fails where the statement lacks one effect: it can tell."""
    scan = reference_scan(30.0)
    rng = np.random.default_rng(20262)
    stated = scan.reduced(rng)
    from_mirror_deg = np.degrees(np.arccos(scan.unit @ np.array([-0.5, 0.0, np.sqrt(0.75)])))
    weights = integral_weights(scan.unit, scan.solid_angle_sr, from_mirror_deg)
    weight = {"gain_ratio": weights["rho"], "p_i": weights["cone 4"]}.get(left_out)
    flank = (scan.flight.path == 1) & (np.abs(scan.unit[:, 1]) < 0.005)
    off = scan.repeats(400, rng)[0] - scan.true_dsf
    shares = []
    for of in (stated, without(stated, left_out)):
        if weight is None:
            inside = (np.abs(off) <= COVERAGE_FACTOR * combined_u_per_sr(of))[:, flank]
        else:
            inside = np.abs(off @ weight) <= COVERAGE_FACTOR * linear_result(of, weight).u
        shares.append(float(inside.mean()))
    assert shares[0] > 0.92
    assert shares[1] < 0.92


@pytest.mark.parametrize("unsigned", ["tilt_y", "axis arm azimuth", "axis_second"])
def test_a_column_that_lacks_its_signs_is_seen(unsigned: str) -> None:
    """A shift of a peak takes from one flank what it gives to the other: with the wrong sign on one of them they would
    not cancel, and the interval of the peak's integral would hold everything. (The sign of a whole column shows in no
    single distribution: test_effect_columns.py holds that.)"""
    scan = reference_scan(30.0)
    rng = np.random.default_rng(20263)
    stated = scan.reduced(rng)
    from_mirror_deg = np.degrees(np.arccos(scan.unit @ np.array([-0.5, 0.0, np.sqrt(0.75)])))
    weight = integral_weights(scan.unit, scan.solid_angle_sr, from_mirror_deg)["cone 4"]
    off = scan.repeats(400, rng)[0] - scan.true_dsf
    wrong = replace(stated, effects=stated.effects | {unsigned: np.abs(stated.effects[unsigned])})
    right, broken = (
        float(np.mean(np.abs(off @ weight) <= COVERAGE_FACTOR * linear_result(of, weight).u)) for of in (stated, wrong)
    )
    assert 0.92 <= right <= 0.98
    assert broken > 0.98


def without(distribution: Distribution, effect: str) -> Distribution:
    effects = {name: column for name, column in distribution.effects.items() if name != effect}
    return Distribution(**{**vars(distribution), "effects": effects})
