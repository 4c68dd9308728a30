"""test_effect_columns.py: every column is the change of the DSF when its error is made, in size and sign."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from repeated_scan import POWER_COUNTS_SR, Flight, RepeatedScan, Truth, sample_frame, tilted

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.dataset.effects import effect_of
from gonio.reduce.corrections.light import Gains
from gonio.reduce.corrections.linearity import linearised
from gonio.reduce.effects.angles import AngleChanges, angle_changes
from gonio.reduce.effects.columns import effect_columns, pose_variance
from gonio.reduce.effects.gradient import Slope, slope_of
from gonio.reduce.effects.power import ReferenceBeam, reference_beam
from gonio.reduce.effects.signal import Level
from gonio.reduce.points import Points, Scale, distribution_of
from gonio.units.instrument import Instrument, load_instrument

FloatArray = NDArray[np.float64]

LOBE = Truth(reflectance=0.0, peaks=((0.2, 4.0),))
INCIDENT_DEG = (35.0, 20.0)
BEAM = ReferenceBeam(POWER_COUNTS_SR, 1e-3, Level(np.array([0.1]), np.array([0.4])))


def noise_free(instrument: Instrument | None = None) -> tuple[RepeatedScan, Points, Distribution]:
    """A lobe of sigma 4 degrees about the mirror direction, without any noise."""
    scan = RepeatedScan(LOBE, Flight.about_mirror(*INCIDENT_DEG), instrument or load_instrument(None), INCIDENT_DEG)
    signal = POWER_COUNTS_SR * scan.true_dsf
    weight = np.where(signal < 6000.0, 1.0, 0.0)
    points = scan.points(signal, weight, scan.unit, scan.flight.path)
    scale = Scale(1.0, POWER_COUNTS_SR, BEAM.p_i_u_rel, 1e-3, 0.0)
    return scan, points, distribution_of(points, scan.solid_angle_sr, INCIDENT_DEG, scale)


def exact_slope(scan: RepeatedScan) -> Slope:
    """Gradients by differences of the truth; no second order."""
    incident, outgoing = sample_frame(np.radians(scan.flight.q_deg.T))
    gradient, step = np.empty((len(scan.unit), 3)), 1e-6
    for k in range(3):
        ahead, behind = outgoing.copy(), outgoing.copy()
        ahead[k] += step
        behind[k] -= step
        values = [LOBE.dsf_per_sr(incident, v / np.linalg.norm(v, axis=0)) for v in (ahead, behind)]
        gradient[:, k] = (values[0] - values[1]) / (2.0 * step)
    n = len(gradient)
    return Slope(scan.unit, gradient, np.zeros(n), np.zeros((n, 6)), np.arange(n))


def near_mirror(scan: RepeatedScan, within_deg: float = 8.0) -> NDArray[np.bool_]:
    theta, phi = np.radians(INCIDENT_DEG)
    mirror = np.array([-np.sin(theta) * np.cos(phi), -np.sin(theta) * np.sin(phi), np.cos(theta)])
    return np.asarray(scan.unit @ mirror > np.cos(np.radians(within_deg)))


def dsf_with(scan: RepeatedScan, *, zero_rad: FloatArray, tilt_rad: tuple[float, float]) -> FloatArray:
    incident, outgoing = sample_frame(np.radians(scan.flight.q_deg.T) + zero_rad[:, None])
    turned = (tilted(v, *(np.full(len(scan.unit), t) for t in tilt_rad)) for v in (incident, outgoing))
    return LOBE.dsf_per_sr(*turned)


@pytest.mark.parametrize("name", ["sample azimuth", "sample roll", "arm azimuth", "arm elevation", "tilt_x", "tilt_y"])
def test_angle_columns_are_what_an_error_does(name: str) -> None:
    scan, points, distribution = noise_free()
    calibration = scan.instrument.calibration
    columns = angle_changes(points, distribution, scan.instrument, exact_slope(scan)).columns
    names = [axis.name for axis in scan.instrument.axes]
    tilt = np.zeros(2)
    zero = np.zeros(4)
    step = 1e-6
    if name in names:
        zero[names.index(name)] = step
        stated = columns[f"axis {name}"] / np.radians(calibration.axis_zero_u_deg)
    else:
        tilt["xy".index(name[-1])] = step
        stated = columns[name] / np.radians(calibration.tilt_u_deg)
    both = [dsf_with(scan, zero_rad=s * zero, tilt_rad=(s * tilt[0], s * tilt[1])) for s in (1.0, -1.0)]
    made = (both[0] - both[1]) / (2.0 * step)
    near = near_mirror(scan)
    # What the distribution follows is the mirror direction but for a share of a percent that the others have.
    steepest = float(np.linalg.norm(exact_slope(scan).gradient, axis=1).max())
    assert stated[near] == pytest.approx(made[near], abs=0.02 * steepest)
    # A sample that is the same all round does not tell how it is turned in its plane.
    assert (np.abs(made[near]).max() > 0.5 * steepest) == (name != "sample roll")


def test_sample_offset_moves_light_and_direction() -> None:
    scan, points, distribution = noise_free()
    column = angle_changes(points, distribution, scan.instrument, exact_slope(scan)).columns["sample_offset"]
    incident, outgoing = sample_frame(np.radians(scan.flight.q_deg.T))
    radius_mm, offset_mm = scan.instrument.arm_radius_mm, 1e-3
    towards = radius_mm * outgoing - offset_mm * incident / incident[2]
    distance = np.linalg.norm(towards, axis=0)
    made = LOBE.dsf_per_sr(incident, towards / distance) * (radius_mm / distance) ** 2 - scan.true_dsf
    made *= scan.instrument.calibration.sample_offset_u_mm / offset_mm
    assert column == pytest.approx(made, abs=1e-3 * float(np.abs(made).max()))


def signal_error(name: str, step: float) -> Callable[[RepeatedScan, Points], FloatArray]:
    """DSF (n,) where the receiver's error is `step` in sample and beam alike."""

    def made(scan: RepeatedScan, points: Points) -> FloatArray:
        signal, p_i = points.signal, POWER_COUNTS_SR
        if name == "gain_ratio":
            signal = signal * (1.0 + step * points.high_weight)
            p_i *= 1.0 + step * BEAM.level.high_share[0]
        elif name == "linearity":
            signal, _ = linearised(signal, points.high_weight, Gains.of(scan.instrument), step)
            p_i *= 1.0 + step * BEAM.level.of_full_scale[0]
        elif name == "lamp":
            signal = signal * (1.0 + step)
        elif name == "p_i":
            p_i *= 1.0 + step
        elif name == "dark":
            signal = signal + step * points.dark_u_counts
        return np.asarray(signal / p_i)

    return made


@pytest.mark.parametrize("name", ["gain_ratio", "linearity", "lamp", "p_i", "dark", "stray_light"])
def test_signal_columns_are_what_an_error_does(name: str) -> None:
    instrument = load_instrument(None)
    stray_u = 1e-2
    instrument = replace(instrument, calibration=replace(instrument.calibration, stray_light_u_per_sr=stray_u))
    scan, points, distribution = noise_free(instrument)
    points.dark_u_counts[:] = 40.0
    nothing = AngleChanges()
    stated = effect_columns(points, distribution, instrument, BEAM, nothing)[name]
    if name == "stray_light":
        assert stated == pytest.approx(np.full(len(stated), stray_u))
        return
    u = {"gain_ratio": 1e-3, "linearity": 5e-4, "lamp": 5e-4, "p_i": BEAM.p_i_u_rel, "dark": 1.0}[name]
    error, step = signal_error, 1e-6
    made = (error(name, step)(scan, points) - error(name, -step)(scan, points)) * (u / (2.0 * step))
    assert stated == pytest.approx(made, abs=1e-6 * float(np.abs(made).max()))
    assert np.abs(stated).max() > 0.0


def test_gain_ratio_counts_only_where_sample_and_beam_differ() -> None:
    scan, points, distribution = noise_free()
    nothing = AngleChanges()
    points.high_weight[:] = 1.0
    all_high = replace(BEAM, level=Level(np.ones(1), BEAM.level.of_full_scale))
    assert "gain_ratio" not in effect_columns(points, distribution, scan.instrument, all_high, nothing)
    assert "gain_ratio" in effect_columns(points, distribution, scan.instrument, BEAM, nothing)


def test_keys_are_known_and_masked_points_have_no_value() -> None:
    scan, points, distribution = noise_free()
    distribution.flags[::7] = PointFlag.SHADOWED
    distribution.dsf_per_sr[::7] = distribution.variance_per_sr2[::7] = np.nan
    angles = angle_changes(points, distribution, scan.instrument, slope_of(points, distribution, 0.005))
    columns = effect_columns(points, distribution, scan.instrument, BEAM, angles)
    assert {"lamp", "p_i", "tilt_x", "axis arm azimuth", "axis_second", "tilt_second", "sample_offset"} <= set(columns)
    for name, column in columns.items():
        assert effect_of(name).words
        assert np.array_equal(np.isnan(column), np.isnan(distribution.dsf_per_sr)), name


def test_effects_too_small_to_show_are_left_out() -> None:
    def kept(latch_u_us: float) -> set[str]:
        instrument = load_instrument(None)
        axes = tuple(replace(axis, latch_delay_u_us=latch_u_us) for axis in instrument.axes)
        scan, points, distribution = noise_free(replace(instrument, axes=axes))
        angles = angle_changes(points, distribution, scan.instrument, exact_slope(scan))
        return set(effect_columns(points, distribution, scan.instrument, BEAM, angles))

    assert "pose_time arm azimuth" not in kept(0.5)
    late = kept(5000.0)
    assert {"pose_time arm azimuth", "pose_time arm elevation"} <= late
    assert "pose_time sample roll" not in late  # it stands still


def test_stamps_of_the_sync_are_independent_noise() -> None:
    """A time error dt moves the reading by rate dt: the DSF along the path, dt later, says by how much."""
    scan, points, distribution = noise_free()
    angles = angle_changes(points, distribution, scan.instrument, exact_slope(scan))
    step_s = 1e-6
    later = [
        LOBE.dsf_per_sr(*sample_frame(np.radians(scan.flight.q_deg + s * step_s * scan.flight.rate_deg_per_s).T))
        for s in (1.0, -1.0)
    ]
    per_second = (later[0] - later[1]) / (2.0 * step_s)
    stated = np.sqrt(pose_variance(angles, stamp_u_us=200.0) - angles.resolution_variance)
    assert stated == pytest.approx(np.abs(per_second) * 2e-4, abs=1e-4 * float(np.abs(per_second).max()) * 2e-4)


def test_resolution_of_the_readings_is_independent_noise() -> None:
    """Readings rounded to whole counts, against those that were not, at many places of the arm within a few counts:
    the scatter of the DSF is the stated one. The sample's axes stand: their rounding is no noise."""
    axes = tuple(
        replace(axis, counts_per_deg_ratio=axis.counts_per_deg_ratio / 4) for axis in load_instrument(None).axes
    )
    scan, points, distribution = noise_free(replace(load_instrument(None), axes=axes))
    angles = angle_changes(points, distribution, scan.instrument, exact_slope(scan))
    rng = np.random.default_rng(9)
    counts_per_deg = np.array([axis.counts_per_deg for axis in axes])
    square = np.zeros(len(scan.unit))
    for _ in range(200):
        arm_deg = scan.flight.q_deg + np.array([0.0, 0.0, 0.01, 0.01]) * rng.uniform(size=scan.flight.q_deg.shape)
        read_deg = np.rint(arm_deg * counts_per_deg) / counts_per_deg
        read_deg[:, :2] = arm_deg[:, :2]
        seen, taken = (LOBE.dsf_per_sr(*sample_frame(np.radians(q).T)) for q in (arm_deg, read_deg))
        square += (taken - seen) ** 2 / 200
    stated = pose_variance(angles, stamp_u_us=0.0)
    steep = near_mirror(scan) & (stated > 0.1 * stated.max())
    assert np.mean(square[steep] / stated[steep]) == pytest.approx(1.0, abs=0.02)


def test_level_of_the_reference_beam() -> None:
    """Two points of equal light, one from the high gain; the dark of both errs together."""
    scan, points, _ = noise_free()
    few = Points(**{name: values[:2].copy() for name, values in vars(points).items()})
    few.signal[:] = 4000.0
    few.high_weight[:] = (1.0, 0.0)
    few.dark_u_counts[:] = 2.0
    beam = reference_beam(few, np.array([0.001, 0.001]), 3e-4, scan.instrument)
    assert beam.p_i == pytest.approx(8.0)
    assert beam.level.high_share == pytest.approx([0.5])
    assert beam.level.of_full_scale == pytest.approx([0.5 * (4e6 + 4e3) / 8388607])
    assert beam.p_i_u_rel == pytest.approx(np.hypot(3e-4, 2.0 / 4000.0))


def test_slope_of_a_measured_peak() -> None:
    """With noise, from the points alone: the slope of the lobe where it is steep, within a tenth."""
    scan, points, distribution = noise_free()
    rng = np.random.default_rng(5)
    distribution.dsf_per_sr += np.sqrt(distribution.variance_per_sr2) * rng.standard_normal(len(scan.unit))
    found, exact = slope_of(points, distribution, 0.005), exact_slope(scan)
    on_spiral = (scan.flight.path == 1) & near_mirror(scan, 1.8)
    steep = np.linalg.norm(exact.gradient, axis=1)
    chosen = on_spiral & (steep > 0.3 * steep[on_spiral].max())
    gradient, variance, _ = found.at(scan.unit, slice(None))
    off = np.linalg.norm(gradient - exact.gradient, axis=1)
    assert np.median((off / steep)[chosen]) < 0.1
    # Its noise is as stated.
    assert np.median((off / np.sqrt(2.0 * variance))[chosen]) < 3.0
