"""test_corrections.py: dark over time and temperature, saturation, the blend of the gains, noise estimates."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.dataset.bsdf import PointFlag
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated.records import (
    SAMPLE_DTYPE,
    SAMPLE_HIGH_SATURATED,
    SAMPLE_LOW_SATURATED,
    SAMPLE_MONITOR_SATURATED,
)
from gonio.reduce.corrections.dark import Dark
from gonio.reduce.corrections.light import Gains, light_of
from gonio.reduce.corrections.noise import shot_variance_per_count
from gonio.reduce.samples.timeline import counted, inside, path_intervals, shutter_closed_ns
from gonio.units.instrument import load_instrument

GAINS = Gains.of(load_instrument(None))
ORIGIN_NS = 1_700_000_000_000_000_001


def recorded(
    light: NDArray[np.float64], temperature_c: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.void]]:
    """A sample each ms; dark 350 + 2 per degree above 20 + 10 per s on the high channel, 12 on the low one."""
    samples = np.zeros(len(light), dtype=SAMPLE_DTYPE)
    seconds = np.arange(len(light)) * 1e-3
    samples["high_counts"] = np.rint(1000.0 * light + 350.0 + 2.0 * (temperature_c - 20.0) + 10.0 * seconds)
    samples["low_counts"] = np.rint(light + 12.0)
    samples["monitor_counts"] = 4_000_000
    samples["temperature_centi_c"] = np.rint(100.0 * temperature_c)
    return ORIGIN_NS + np.arange(len(light), dtype=np.int64) * 1_000_000, samples


def test_dark_follows_time_and_temperature_between_the_darks() -> None:
    n = 40_000
    seconds = np.arange(n) * 1e-3
    temperature_c = 20.0 + 3.0 * np.sin(seconds / 6.0)
    closed = (seconds % 10.0) < 1.5
    light = np.where(closed, 0.0, 0.4)
    time_ns, samples = recorded(light, temperature_c)
    dark = Dark.measure(time_ns, samples, closed)
    assert dark is not None
    found = light_of(samples, time_ns, np.ones(n), dark, GAINS)
    assert np.abs(found.signal - light)[(seconds > 1.0) & (seconds < 31.0)].max() < 2e-3
    constant = replace(dark, per_c=np.zeros(2))
    without = light_of(samples, time_ns, np.ones(n), constant, GAINS)
    assert np.abs(without.signal - light)[(seconds > 1.0) & (seconds < 31.0)].max() > 2e-3


def test_no_dark_no_offset() -> None:
    time_ns, samples = recorded(np.ones(100), np.full(100, 20.0))
    assert Dark.measure(time_ns, samples, np.zeros(100, dtype=bool)) is None
    assert Dark.measure(time_ns, samples, np.arange(100) < 20) is None


def test_gains_blend_without_a_step_and_saturation_is_masked() -> None:
    light = np.linspace(0.0, 9000.0, 30_000)
    time_ns, samples = recorded(light, np.full(30_000, 20.0))
    samples["high_counts"] = np.minimum(samples["high_counts"], 8388607)
    samples["flags"] = np.where(samples["high_counts"] == 8388607, SAMPLE_HIGH_SATURATED, 0)
    samples["flags"][100] = SAMPLE_LOW_SATURATED  # does not matter: the high channel has the say
    samples["flags"][-1] |= SAMPLE_LOW_SATURATED
    samples["flags"][200] = SAMPLE_MONITOR_SATURATED
    weight = GAINS.high_weight(samples)
    assert np.all(weight[light < 6700.0] == 1.0)
    assert np.all(weight[light > 7975.0] == 0.0)
    assert np.abs(np.diff(weight)).max() < 0.001
    one = np.array([[350.0, 12.0]])
    dark = Dark(time_ns[:1], np.array([20.0]), one, np.array([64.0, 0.25]), np.zeros(2), np.zeros((1, 2)))
    samples["high_counts"] -= np.where(
        samples["flags"] & SAMPLE_HIGH_SATURATED, 0, np.rint(np.arange(30_000) * 0.01)
    ).astype(np.int32)
    found = light_of(samples, time_ns, weight, dark, GAINS)
    np.testing.assert_allclose(found.signal, light, atol=0.6)
    assert list(np.flatnonzero(found.flags & PointFlag.SATURATED)) == [200, 29_999]
    assert found.dark_variance[0] == pytest.approx(64e-6)
    assert found.dark_variance[-1] == pytest.approx(0.25)


def test_delay_is_that_of_the_channel_used() -> None:
    high, low = GAINS.high.delay_us, GAINS.low.delay_us
    np.testing.assert_allclose(
        GAINS.delay_ns(np.array([1.0, 0.0, 0.5])), 1e3 * np.array([high, low, 0.5 * (high + low)])
    )


def test_shot_noise_is_found_beside_edges_and_absent_when_absent() -> None:
    rng = np.random.default_rng(8)
    level = 2000.0 * (1.0 + np.sin(np.arange(50_000) / 300.0)) + 3000.0 * (np.arange(50_000) % 5000 < 700)
    floor = np.full(50_000, 0.25)
    quiet = level + 0.5 * rng.standard_normal(50_000)
    noisy = quiet + np.sqrt(0.01 * level) * rng.standard_normal(50_000)
    joined = np.arange(50_000) > 0
    assert shot_variance_per_count(noisy, floor, joined) == pytest.approx(0.01, rel=0.05)
    assert shot_variance_per_count(quiet, floor, joined) < 1e-5


def test_light_without_any_noise_has_no_shot_noise_and_shot_noise_alone_is_found() -> None:
    level = 2000.0 * (1.0 + np.sin(np.arange(50_000) / 300.0))
    none, joined = np.zeros(50_000), np.arange(50_000) > 0
    assert shot_variance_per_count(level, none, joined) == pytest.approx(0.0, abs=1e-9)
    assert shot_variance_per_count(np.full(50_000, 7.0), none, joined) == 0.0
    noisy = level + np.sqrt(0.01 * level) * np.random.default_rng(9).standard_normal(50_000)
    assert shot_variance_per_count(noisy, none, joined) == pytest.approx(0.01, rel=0.05)


def test_events_give_paths_shutter_and_counters() -> None:
    def at(ms: int, **body: Any) -> pb.Event:
        return pb.Event(time_ns=ORIGIN_NS + ms * 1_000_000, **body)

    shutter = [at(ms, output=pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=on)) for ms, on in ((0, False), (1000, True))]
    events = [
        *shutter,
        at(1100, path=pb.PathState(path_id=3, end=pb.PATH_RUNNING)),
        at(1500, path=pb.PathState(path_id=3, end=pb.PATH_STOPPED)),
        at(1600, path=pb.PathState(path_id=4, end=pb.PATH_RUNNING)),
        at(1700, counters=pb.Counters(strobes_lost=2)),
        at(1800, counters=pb.Counters(strobes_lost=5, tpdo_late=1)),
        at(1900, status=pb.Status(shutter_open=False)),
    ]
    last_ns = ORIGIN_NS + 3_000_000_000
    paths = path_intervals(events, last_ns)
    assert [(p.path_id, p.finished) for p in paths] == [(3, False), (4, False)]
    assert (paths[0].end_ns - ORIGIN_NS, paths[1].end_ns) == (1_500_000_000, last_ns)
    closed = shutter_closed_ns(events, last_ns)
    assert ((closed - ORIGIN_NS) / 1e6).tolist() == [[100.0, 900.0], [2000.0, 3000.0]]
    times = ORIGIN_NS + np.array([0, 100, 500, 900, 950, 2500, 4000]) * 1_000_000
    assert inside(times, closed).tolist() == [False, True, True, True, False, True, False]
    assert counted(events, 0)["strobes_lost"] == 5
    assert counted([], 0)["tpdo_late"] == 0


def test_what_earlier_scans_lost_is_not_counted_again() -> None:
    """SYNC's counters run from the firmware's start, the samples' from the acquisition's."""
    reports = [
        pb.Event(time_ns=second * 10**9, counters=pb.Counters(tpdo_missing=missing, samples_lost=lost, cycles_missed=2))
        for second, missing, lost in ((1, 7, 90), (2, 8, 90), (4, 8, 1), (5, 11, 3))
    ]
    found = counted(reports, 3 * 10**9)
    assert (found["tpdo_missing"], found["samples_lost"], found["cycles_missed"]) == (3, 3, 0)
    # A homed instrument: the first report comes when samples are already there.
    assert counted(reports, 10**8)["tpdo_missing"] == 4
    assert counted(reports[-1:], 10**8)["tpdo_missing"] == 11
