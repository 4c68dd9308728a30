"""test_pairing.py: poses between SYNCs against motion known in closed form, and losses that must leave flags only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.protocol.generated.records import POSE_CLOCK_STEP, POSE_DTYPE, POSE_ECHO_LOST, POSE_TPDO_LATE
from gonio.reduce.samples.pairing import PoseTrack
from gonio.units.instrument import load_instrument

AXES = load_instrument(None).axes
BOOT_NS = 1_700_000_000_123_456_789  # far beyond what a float holds to the nanosecond
AMPLITUDE_DEG = np.array([15.0, 14.0, 13.0, 12.0])
RATE_PER_S = 30.0 / AMPLITUDE_DEG  # 30 degrees/s in the middle of the swing


def motion_deg(time_ns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Readings (n, 4) at times (n,) in ns after BOOT_NS."""
    return np.asarray(20.0 + AMPLITUDE_DEG * np.sin(RATE_PER_S * time_ns[:, None] * 1e-9 + np.arange(4)))


def make_poses(count: int, *, jitter_us: float = 120.0, quantised: bool = True, seed: int = 1) -> NDArray[np.void]:
    rng = np.random.default_rng(seed)
    poses = np.zeros(count, dtype=POSE_DTYPE)
    relative_ns = np.rint(np.arange(count) * 2e6 + rng.uniform(-jitter_us, jitter_us, count) * 1e3)
    poses["sync_time_ns"] = BOOT_NS + relative_ns.astype(np.int64)
    poses["sync_number"] = np.arange(1, count + 1)
    latch_ns = np.array([1e3 * axis.latch_delay_us for axis in AXES])
    for number, axis in enumerate(AXES):
        exact = motion_deg(relative_ns + latch_ns[number])[:, number] * axis.counts_per_deg
        poses["position_counts"][:, number] = np.rint(exact) if quantised else exact
    poses["valid"] = 0b1111
    return poses


def sample_times(count: int) -> NDArray[np.int64]:
    return BOOT_NS + 20_000_000 + np.arange(count, dtype=np.int64) * 1_000_137


def test_quantised_jittered_positions_give_the_pose_within_the_encoder() -> None:
    track = PoseTrack.from_poses(make_poses(5000), AXES)
    times = sample_times(9900)
    delay_ns = 180_000.0
    q_deg, flags = track.pose_at(times, delay_ns)
    error = np.abs(q_deg - motion_deg((times - BOOT_NS).astype(float) - delay_ns))
    # Half a count, spread by weights whose absolute values add up to at most 1.25 at equal spacing (more with jitter).
    assert error.max() < 0.5 * 1.5 / (400_000 / 360)
    assert not flags.any()


def test_a_cubic_in_time_is_found_exactly_at_unequal_spacing() -> None:
    poses = make_poses(100)
    t = (poses["sync_time_ns"] - BOOT_NS).astype(float)
    cubic = np.polynomial.Polynomial([1.0, 3e-7, 2e-15, -1e-23])
    poses["position_counts"] = np.rint(cubic(t) * 1e6)[:, None]
    times = sample_times(150)
    found = PoseTrack.from_poses(poses, AXES).poses_at(times)
    per_count = 1.0 / AXES[0].counts_per_deg
    expected = cubic((times - BOOT_NS).astype(float)) * 1e6 * per_count
    np.testing.assert_allclose(found.q_deg[:, 0], expected, rtol=0.0, atol=per_count)
    rate = cubic.deriv()((times - BOOT_NS).astype(float)) * 1e15 * per_count
    # Two counts, rounded, over a spacing of 2 ms; jitter brings some nearer.
    np.testing.assert_allclose(found.rate_deg_per_s[:, 0], rate, rtol=0.0, atol=per_count / 1.5e-3)


@pytest.mark.parametrize("lost", ["sync", "one_drive", "late", "echo", "clock_step"])
def test_a_lost_position_widens_the_stencil_and_is_flagged(lost: str) -> None:
    poses = make_poses(200)
    if lost == "sync":
        poses = np.delete(poses, 100)
    elif lost in ("echo", "clock_step"):  # the position is right, its time is not
        poses["flags"][100] = POSE_ECHO_LOST if lost == "echo" else POSE_CLOCK_STEP
        poses["sync_time_ns"][100] += 700_000
    else:
        # What the drive sent too late, or not at all, must not be used.
        poses["valid"][100] = 0b1011
        poses["flags"][100] = POSE_TPDO_LATE if lost == "late" else 0
        poses["position_counts"][100, 2] += 5000
    times = sample_times(350)
    q_deg, flags = PoseTrack.from_poses(poses, AXES).pose_at(times)
    assert np.abs(q_deg - motion_deg((times - BOOT_NS).astype(float))).max() < 0.001
    near = np.abs((times - BOOT_NS) - 200_000_000) < 3_500_000
    assert (flags[near] == PointFlag.INTERPOLATED_POSE).all()
    assert not flags[np.abs((times - BOOT_NS) - 200_000_000) > 4_500_000].any()


def test_a_long_gap_and_the_time_outside_the_track_are_lost() -> None:
    poses = np.delete(make_poses(200), np.s_[100:104])
    times = np.concatenate(([BOOT_NS - 1_000_000], sample_times(350), [BOOT_NS + 10**9]))
    q_deg, flags = PoseTrack.from_poses(poses, AXES).pose_at(times)
    lost = flags == PointFlag.POSE_LOST
    assert lost[0]
    assert lost[-1]
    assert lost[(times > BOOT_NS + 199_000_000) & (times < BOOT_NS + 207_000_000)].all()
    assert np.isnan(q_deg[lost]).all()
    assert np.abs(q_deg[~lost] - motion_deg((times[~lost] - BOOT_NS).astype(float))).max() < 0.001


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 0.7))
def test_whatever_is_lost_no_direction_is_wrong(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    poses = make_poses(300, seed=seed)
    poses["valid"] = np.packbits(rng.random((300, 8)) >= share, axis=1)[:, 0]
    # Positions that are not valid are garbage.
    for number in range(4):
        invalid = (poses["valid"] >> number) & 1 == 0
        poses["position_counts"][invalid, number] = rng.integers(-(2**31), 2**31 - 1, invalid.sum())
    poses = poses[rng.random(300) >= 0.2 * share]
    times = sample_times(560)
    q_deg, flags = PoseTrack.from_poses(poses, AXES).pose_at(times)
    error = np.abs(q_deg - motion_deg((times - BOOT_NS).astype(float)))
    kept = flags != PointFlag.POSE_LOST
    # A stencil with up to three SYNCs missing may look from one side: weights up to some twenty at its worst place.
    assert error[kept].max(initial=0.0) < 0.01
    assert error[flags == 0].max(initial=0.0) < 0.0007
    assert np.isnan(q_deg[~kept]).all()


def test_no_or_too_few_poses_are_lost_poses() -> None:
    for count in (0, 3):
        q_deg, flags = PoseTrack.from_poses(make_poses(count), AXES).pose_at(sample_times(5))
        assert (flags == PointFlag.POSE_LOST).all()
        assert np.isnan(q_deg).all()
