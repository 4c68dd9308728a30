"""test_photon_module.py: the compiled photon map from Python: whole sums, threads, cancellation, errors, maps."""

import threading
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gonio.simulate import _photons
from gonio.simulate.directions import rings
from gonio.units.errors import UsageError
from gonio.units.instrument import reference_instrument_path

SOURCE = str(reference_instrument_path().parents[1])
WHITE = '[sample]\nkind = "lambertian"\nreflectance = 0.5\n'
PHOTONS = 60_000


@pytest.fixture
def scenario(tmp_path: Path) -> _photons.Scenario:
    (tmp_path / "white.toml").write_text(
        WHITE + '[readings]\nincident = [[30, 0]]\nbandwidth = 9\nestimator = "nearest"'
    )
    return _photons.Scenario(str(tmp_path / "white.toml"), SOURCE, {}, 7)


def traced(scenario: _photons.Scenario, first: int, count: int, threads: int = 1) -> list[NDArray[np.uint64]]:
    goniophotometer = _photons.Goniophotometer(scenario, "visible", 30.0, 0.0)
    *sums, balance = goniophotometer.read(rings(10.0), 0.05, first, count, threads, _photons.Watch())
    assert balance["emitted"] + balance["roulette"] == balance["stored"] + balance["absorbed"] + balance["lost"]
    return [np.asarray(part) for part in sums]


def test_what_the_scenario_says(scenario: _photons.Scenario) -> None:
    assert scenario.bands == [("visible", 550.0)]
    assert scenario.incidents == [(30.0, 0.0)]
    assert (scenario.seed, scenario.photons, scenario.relative_error) == (7, 1_000_000, 0.0)
    assert (scenario.radius_mm, scenario.aperture_mm) == (1020.0, 10.0)
    assert (scenario.estimator, scenario.bandwidth) == ("nearest", 9)
    assert scenario.walk("visible") == "embree"


def test_parts_add_up_to_the_bits_of_the_whole(scenario: _photons.Scenario) -> None:
    whole = traced(scenario, 0, PHOTONS, threads=2)
    one, other = traced(scenario, 0, 12_345), traced(scenario, 12_345, PHOTONS - 12_345, threads=3)
    assert whole[2].sum() > 1000
    for sum_of_whole, a, b in zip(whole, one, other, strict=True):
        np.testing.assert_array_equal(sum_of_whole, a + b)


def test_values_are_lamberts_within_their_errors(scenario: _photons.Scenario) -> None:
    weight, square, hits = traced(scenario, 0, 4 * PHOTONS)
    dsf, error, half_angle, seen = _photons.estimate(weight, square, hits, 4 * PHOTONS, 0.05)
    expected = 0.5 / np.pi * np.maximum(rings(10.0)[:, 2], 0.0)
    inside = expected > 0.05
    deviation = (dsf[inside] - expected[inside]) / error[inside]
    assert np.mean(deviation**2) == pytest.approx(1.0, abs=6.0 * np.sqrt(2.0 / inside.sum()))
    assert (half_angle == 0.05).all()
    assert (seen == hits).all()


def test_a_stored_map_reads_what_streaming_reads(scenario: _photons.Scenario) -> None:
    weight, square, hits = traced(scenario, 0, PHOTONS)
    goniophotometer = _photons.Goniophotometer(scenario, "visible", 30.0, 0.0)
    stored, balance = goniophotometer.store(0, PHOTONS, 2, _photons.Watch())
    assert balance["photons"] == PHOTONS
    assert stored.bytes >= 12 * 29_000
    for one, other in zip(
        stored.fixed(rings(10.0), 0.05, 2), _photons.estimate(weight, square, hits, PHOTONS, 0.05), strict=True
    ):
        np.testing.assert_array_equal(one, other)


def test_a_watch_counts_and_cancels_while_another_thread_traces(scenario: _photons.Scenario) -> None:
    goniophotometer = _photons.Goniophotometer(scenario, "visible", 30.0, 0.0)
    watch = _photons.Watch()
    found: list[dict[str, int]] = []

    def trace() -> None:
        found.append(goniophotometer.read(rings(10.0), 0.05, 0, 10**12, 1, watch)[3])

    tracing = threading.Thread(target=trace)
    tracing.start()
    while watch.photons == 0:  # Python runs on: the lock is released
        tracing.join(0.001)
    watch.cancel()
    tracing.join()
    assert watch.cancelled
    assert 0 < found[0]["photons"] < 10**12
    assert found[0]["emitted"] + found[0]["roulette"] == found[0]["stored"] + found[0]["absorbed"] + found[0]["lost"]


def test_wrong_input_is_one_line_that_names_the_file(tmp_path: Path, scenario: _photons.Scenario) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text('[sample]\nkind = "lambertian"\nreflectance = 1.5\n')
    with pytest.raises(UsageError, match=r"wrong\.toml.*reflectance") as caught:
        _photons.Scenario(str(path), SOURCE, {})
    assert "\n" not in str(caught.value)
    with pytest.raises(UsageError, match="infrared"):
        _photons.Goniophotometer(scenario, "infrared", 30.0, 0.0)
    with pytest.raises(ValueError, match="shape"):
        _photons.ScatterTable(8, "none", True).add(False, 0.0, 0.0, np.zeros((4, 8)), None)
    with pytest.raises(UsageError, match="follow"):
        _photons.ScatterTable(8, "sideways", True)
    with pytest.raises(ValueError, match="shape"):
        _photons.estimate(np.zeros(2, np.uint64), np.zeros(3, np.uint64), np.zeros(2, np.uint64), 1, 0.1)


def test_precision_asks_for_the_photons_that_are_missing(scenario: _photons.Scenario) -> None:
    sums = traced(scenario, 0, PHOTONS)
    median, lit, further = _photons.precision(*sums, PHOTONS, 0.02)
    weight, square, hits = traced(scenario, 0, PHOTONS + further)
    reached, _, _ = _photons.precision(weight, square, hits, PHOTONS + further, 0.02)
    assert lit > 100
    assert median > 0.05
    assert reached == pytest.approx(0.02, rel=0.05)
