"""test_corrections_chain.py: linearity, distance, dark's uncertainty and switches against closed forms and geometry."""

import numpy as np
import pytest

from gonio.geometry.directions import unit_from_angles_deg
from gonio.protocol.generated.records import SAMPLE_DTYPE
from gonio.reduce.corrections.chain import NAMES, Switches, recorded
from gonio.reduce.corrections.dark import Dark
from gonio.reduce.corrections.distance import seen_from_spot
from gonio.reduce.corrections.light import Gains, light_of
from gonio.reduce.corrections.linearity import linearised
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument, override_calibration

INSTRUMENT = load_instrument(None)
GAINS = Gains.of(INSTRUMENT)


def test_a_bent_receiver_is_straightened_on_either_gain() -> None:
    light = np.linspace(1.0, 8000.0, 50)
    for weight, channel in ((1.0, GAINS.high), (0.0, GAINS.low)):
        c = 0.02
        true = light * channel.gain / channel.full_scale_counts
        shown = (np.sqrt(1.0 + 4.0 * c * true) - 1.0) / (2.0 * c)  # solves true = shown (1 + c shown)
        signal = shown * channel.full_scale_counts / channel.gain
        found, rise = linearised(signal, np.full(50, weight), GAINS, c)
        np.testing.assert_allclose(found, light, rtol=1e-8)
        step = 1e-4 * signal
        up, down = (linearised(s, np.full(50, weight), GAINS, c)[0] for s in (signal + step, signal - step))
        np.testing.assert_allclose(rise, (up - down) / (2.0 * step), rtol=1e-8)


@pytest.mark.parametrize("incident", [(0.0, 0.0), (60.0, 130.0), (150.0, 20.0)])
def test_the_receivers_place_is_the_same_from_centre_and_spot(incident: tuple[float, float]) -> None:
    """Spot + r' d' = r d; the spot lies in the plane z = offset and on the beam's axis."""
    arm = unit_from_angles_deg(np.array([5.0, 80.0, 120.0]), np.array([10.0, 200.0, 310.0]))
    offset, radius = 3.0, 1020.0
    direction, factor = seen_from_spot(arm, incident, offset, radius)
    spot = radius * arm - radius * np.sqrt(factor)[:, None] * direction
    np.testing.assert_allclose(spot[:, 2], offset, atol=1e-9)
    np.testing.assert_allclose(np.cross(spot, unit_from_angles_deg(*incident)), 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-12)


def test_normal_incidence_gives_the_law_of_distance() -> None:
    """Straight above the face a spot 10 mm nearer reads (r / (r - 10))^2 more, and the correction takes that away."""
    _, factor = seen_from_spot(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), (0.0, 0.0), 10.0, 1000.0)
    np.testing.assert_allclose(factor, [(990.0 / 1000.0) ** 2, 1.0 + 1e-4], rtol=1e-12)


def test_the_darks_mean_is_as_uncertain_as_its_samples_say() -> None:
    """Repeated darks of known noise: the spread of what is subtracted is what is stated, at a dark and between two."""
    rng = np.random.default_rng(4)
    n, repeats = 1400, 400
    time_ns = np.arange(n, dtype=np.int64) * 1_000_000
    closed = (np.arange(n) < 200) | (np.arange(n) >= 1200)
    asked = np.array([100, 700, 1300]) * 1_000_000
    found, stated = [], []
    for _ in range(repeats):
        samples = np.zeros(n, dtype=SAMPLE_DTYPE)
        samples["high_counts"] = np.rint(350.0 + 8.0 * rng.standard_normal(n))
        samples["low_counts"] = np.rint(12.0 + 2.0 * rng.standard_normal(n))
        dark = Dark.measure(time_ns, samples, closed)
        assert dark is not None
        offset, u = dark.at(asked, np.zeros(3))
        found.append(offset)
        stated.append(u)
    np.testing.assert_allclose(np.std(found, axis=0), np.mean(stated, axis=0), rtol=0.12)
    assert np.mean(stated, axis=0)[0] == pytest.approx(8.0 / np.sqrt([200.0, 400.0, 200.0]), rel=0.02)


def test_dark_left_out_leaves_the_offset_and_no_uncertainty_of_it() -> None:
    samples = np.zeros(3, dtype=SAMPLE_DTYPE)
    samples["high_counts"], samples["low_counts"] = 1350, 13
    one = np.array([[350.0, 12.0]])
    dark = Dark(np.zeros(1, np.int64), np.zeros(1), one, np.array([64.0, 1.0]), np.zeros(2), np.array([[0.5, 0.1]]))
    with_dark = light_of(samples, np.zeros(3, np.int64), np.ones(3), dark, GAINS)
    without = light_of(samples, np.zeros(3, np.int64), np.ones(3), dark, GAINS, subtract=False)
    np.testing.assert_allclose(with_dark.signal, 1.0)
    np.testing.assert_allclose(without.signal, 1.35)
    np.testing.assert_allclose(with_dark.dark_u, 0.5e-3)
    assert not without.dark_u.any()
    np.testing.assert_array_equal(with_dark.dark_variance, without.dark_variance)


def test_the_record_has_every_correction_in_order_with_its_state() -> None:
    steps = recorded(Switches.of(["lamp"]), INSTRUMENT, {}, {"what": "P_i as declared", "p_i": 2.0})
    assert [step["name"] for step in steps if step["name"] in NAMES] == list(NAMES)
    assert [step["name"] for step in steps if not step["applied"]] == ["lamp"]
    assert all(step["what"] for step in steps)
    by_name = {step["name"]: step["parameters"] for step in steps}
    assert by_name["p_i"] == {"p_i": 2.0}
    assert by_name["linearity"]["nonlinearity_u"] == INSTRUMENT.calibration.nonlinearity_u
    with pytest.raises(UsageError, match="there are dark, gain, linearity"):
        Switches.of(["darks"])


def test_a_calibration_file_replaces_what_it_names_and_nothing_else() -> None:
    found = override_calibration(INSTRUMENT, "[calibration]\nsample_offset_mm = 2\n", "c.toml").calibration
    assert found.sample_offset_mm == 2.0
    assert found.tilt_u_deg == INSTRUMENT.calibration.tilt_u_deg
    for text, problem in (
        ("x", "not TOML"),
        ("[calibration]\nnonlinearity_u = -1.0\n", "calibration.nonlinearity_u is negative"),
        ("[calibration]\nspeed = 1.0\n", "calibration.speed is unknown"),
        ("[axis]\n", "must be the only table"),
    ):
        with pytest.raises(UsageError, match=rf"c\.toml: .*{problem}"):
            override_calibration(INSTRUMENT, text, "c.toml")
