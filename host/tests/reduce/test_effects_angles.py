"""test_effects_angles.py: displacements, slopes and second order against closed forms and exact geometry."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from gonio.geometry.directions import unit_from_angles_deg
from gonio.geometry.kinematics import Kinematics
from gonio.reduce.corrections.distance import seen_from_spot
from gonio.reduce.effects.angles import second_order
from gonio.reduce.effects.features import Followed, retro_weight
from gonio.reduce.effects.receiver import nearer_rel, shift_rad, spot_per_offset
from gonio.reduce.effects.turns import Turns, rotation
from gonio.units.instrument import load_instrument

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Axle:
    vector: tuple[float, float, float]
    carries: str


AXLES = [
    tuple(load_instrument(None).axes),
    (
        Axle((0.3, -1.0, 0.1), "sample"),
        Axle((0.0, 1.0, 0.2), "detector"),
        Axle((0.1, 0.2, -1.0), "sample"),
        Axle((-1.0, 0.1, 0.3), "detector"),
    ),
]


@pytest.mark.parametrize("axes", AXLES)
@given(q_deg=st.tuples(*[st.floats(-180.0, 180.0)] * 4))
def test_turn_vectors_are_the_derivative_of_the_kinematics(axes: tuple[Axle, ...], q_deg: tuple[float, ...]) -> None:
    q = np.array([q_deg])
    turns = Turns(axes, q[0]).at(np.radians(q.T))
    kinematics, step_deg = Kinematics(axes), 1e-4
    incident, outgoing = kinematics.directions(q)
    for number, axis in enumerate(axes):
        ahead, behind = q.copy(), q.copy()
        ahead[0, number] += step_deg
        behind[0, number] -= step_deg
        rate = [
            (after - before)[0] / np.radians(2.0 * step_deg)
            for after, before in zip(kinematics.directions(ahead), kinematics.directions(behind), strict=True)
        ]
        turn = turns[number][:, 0]
        assert np.cross(turn, outgoing[0]) == pytest.approx(rate[1], abs=1e-7)
        expected = np.cross(turn, incident[0]) if axis.carries == "sample" else np.zeros(3)
        assert expected == pytest.approx(rate[0], abs=1e-7)


def ideal(incident: FloatArray) -> list[FloatArray]:
    """Mirror, retro, through for a surface whose normal is z."""
    return [np.array([-incident[0], -incident[1], incident[2]]), incident, -incident]


@pytest.mark.parametrize("theta_deg", [0.0, 20.0, 50.0, 80.0, 130.0])
def test_the_distribution_moves_with_its_nearest_ideal_direction(theta_deg: float) -> None:
    incident = unit_from_angles_deg(theta_deg, 40.0)
    followed = Followed.of(theta_deg, 40.0, retro_weight=1.0 if theta_deg > 10.0 else 0.0)
    turn, small = np.array([0.5, -0.7, 0.4]), 1e-6
    moved = rotation(turn / np.linalg.norm(turn), small * float(np.linalg.norm(turn))) @ incident
    for number, (before, after) in enumerate(zip(ideal(incident), ideal(moved), strict=True)):
        if number == 1 and theta_deg < 10.0:
            continue
        share = followed.share(before[:, None])
        assert share[number, 0] > 0.99
        carried = np.cross(followed.turn(share, turn)[:, 0], before)
        assert carried == pytest.approx((after - before) / small, abs=0.03)


def test_a_tilt_moves_the_mirror_direction_twice_and_the_others_not() -> None:
    """Against the sample that is turned with them: retro and straight through stay, the mirror direction goes 2 t."""
    theta_deg = 40.0
    followed = Followed.of(theta_deg, 0.0, 1.0)
    turn = -np.eye(3)[1]
    displacement = []
    for direction in ideal(unit_from_angles_deg(theta_deg, 0.0)):
        share = followed.share(direction[:, None])
        displacement.append(np.linalg.norm(np.cross(turn - followed.turn(share, turn)[:, 0], direction)))
    assert displacement == pytest.approx([2.0, 0.0, 0.0], abs=0.02)


def test_far_from_every_ideal_direction_the_distribution_stays() -> None:
    followed = Followed.of(0.0, 0.0, 0.0)
    assert followed.share(unit_from_angles_deg(85.0, 10.0)[:, None]).sum() < 0.03
    assert followed.share(unit_from_angles_deg(10.0, 10.0)[:, None]).sum() > 0.97


def test_a_retro_peak_is_told_from_the_mirrors_lobe() -> None:
    rng = np.random.default_rng(3)
    unit = unit_from_angles_deg(np.degrees(np.arccos(rng.uniform(0.5, 1.0, 20000))), rng.uniform(0.0, 360.0, 20000))
    incident = unit_from_angles_deg(12.0, 90.0)

    def lobe(about: FloatArray) -> FloatArray:
        return np.asarray(np.exp(-0.5 * (np.arccos(np.clip(unit @ about, -1, 1)) / np.radians(8.0)) ** 2))

    mirror_only = retro_weight(unit, lobe(ideal(incident)[0]) + 0.1, 12.0, 90.0)
    retro_too = retro_weight(unit, lobe(ideal(incident)[0]) + 3.0 * lobe(incident) + 0.1, 12.0, 90.0)
    assert mirror_only < 0.1
    assert retro_too > 0.8
    # Nothing measured there: the angle between both decides.
    none = np.full(len(unit), np.nan)
    assert retro_weight(unit, none, 0.0, 0.0) == 0.0
    assert retro_weight(unit, none, 40.0, 0.0) > 0.99


def test_second_order_is_the_rms_of_the_quadratic_form() -> None:
    """1/2 d^T H d with d ~ N(0, C), by a million draws: exact along one direction, up to 1.22 times it at a round
    peak, and both columns together make the whole."""
    rng = np.random.default_rng(7)
    draws = rng.standard_normal((1_000_000, 2))
    for h, c_axes, c_mount, ratio in (
        ((-900.0, 0.0), (2e-7, 0.0), (3e-7, 0.0), 1.0),
        ((-900.0, -900.0), (1e-7, 1e-7), (4e-7, 4e-7), np.sqrt(1.5)),
        ((-900.0, -300.0), (1e-7, 1e-7), (0.0, 0.0), None),
    ):
        total = np.add(c_axes, c_mount)
        rms = float(np.sqrt(np.mean((0.5 * (draws**2 * total) @ np.array(h)) ** 2)))
        six = [np.array([[a], [b], [0.0], [0.0], [0.0], [0.0]]) for a, b in (h, c_axes, c_mount)]
        found = second_order(*six)
        stated = float(np.hypot(found["axis_second"], found["tilt_second"])[0])
        if ratio is not None:
            assert stated == pytest.approx(ratio * rms, rel=0.01)
        assert rms * 0.99 <= stated <= rms * 1.24
        assert found["axis_second"][0] < 0.0


@given(st.floats(0.0, 75.0), st.floats(0.0, 360.0), st.floats(-0.5, 0.5))
def test_sample_offset_to_first_order(theta_deg: float, phi_deg: float, offset_mm: float) -> None:
    """Distance and direction from the spot, as exact vectors (the correction's) and as the columns have them."""
    radius_mm = 1020.0
    unit = unit_from_angles_deg([10.0, 60.0, 120.0], [0.0, 130.0, 250.0])
    spot = spot_per_offset(theta_deg, phi_deg) * offset_mm
    assert spot[2] == pytest.approx(offset_mm)
    towards, squared = seen_from_spot(unit, (theta_deg, phi_deg), offset_mm, radius_mm)
    left = 10.0 * float(spot @ spot) / radius_mm**2 + 1e-12
    assert nearer_rel(unit.T, spot, radius_mm) == pytest.approx(1.0 / squared - 1.0, abs=left)
    shift = shift_rad(unit.T, spot, radius_mm).T
    assert shift == pytest.approx(towards - unit, abs=left)


def test_at_normal_incidence_only_the_height_counts() -> None:
    unit = unit_from_angles_deg([0.0, 45.0, 90.0, 180.0], [0.0, 20.0, 0.0, 0.0])
    rise = nearer_rel(unit.T, spot_per_offset(0.0, 0.0) * 0.1, 1000.0)
    assert rise == pytest.approx(2.0 * 0.1 * np.array([1.0, np.sqrt(0.5), 0.0, -1.0]) / 1000.0)


def test_distance_and_aperture_cancel_in_e_over_p_i() -> None:
    """A receiver of area A at distance r: sample I(o) in W/sr, beam of power Phi. E = I A / r^2; P_i = sum E Omega over
    the beam, whose light through the sphere of radius r is Phi in all."""
    intensity, power = 0.3, 1.7

    def dsf(radius_mm: float, diameter_mm: float) -> float:
        area_mm2 = np.pi * diameter_mm**2 / 4.0
        e = intensity * area_mm2 / radius_mm**2
        cell_sr = 1e-4
        density_per_mm2 = power / (50 * cell_sr * radius_mm**2)  # evenly over 50 cells of the sphere
        p_i = sum(density_per_mm2 * area_mm2 * cell_sr for _ in range(50))
        return float(e / p_i)

    assert dsf(1020.0, 10.0) == pytest.approx(intensity / power, rel=1e-12)
    assert dsf(1025.0, 10.0) == pytest.approx(dsf(1020.0, 10.0), rel=1e-12)
    assert dsf(1020.0, 10.3) == pytest.approx(dsf(1020.0, 10.0), rel=1e-12)


def test_zero_uncertainty_has_nosecond_order() -> None:
    nothing = np.zeros((6, 3))
    found = second_order(np.ones((6, 3)), nothing, nothing)
    assert not any(column.any() for column in found.values())
