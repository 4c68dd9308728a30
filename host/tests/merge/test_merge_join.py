"""test_merge_join.py: a scan split and merged is the whole scan; effects stay apart or together; what is joined counts
once."""

import numpy as np
import pytest
from closed_form_sets import (
    RETRO_30,
    dataset,
    distribution,
    lambertian,
    lobe,
    masked,
    part,
    rings,
    sources,
    spiral,
)

from gonio.dataset.bsdf import Distribution
from gonio.dataset.uncertainty import linear_result
from gonio.geometry.directions import angle_between_deg
from gonio.merge.merging import MergeOptions, merge
from gonio.merge.points import units
from gonio.reduce.integrals.hemispheres import integrals

EFFECTS = {"p_i": 0.004, "distance": 0.001, "tilt_x": 0.002}
# The files of a split scan: every fourth sample; contiguous quarters.
SPLITS = [
    lambda n: [np.arange(n) % 4 == k for k in range(4)],
    lambda n: [np.arange(n) * 4 // n == k for k in range(4)],
]


def whole_scan(seed: int = 1) -> Distribution:
    """Coarse circles and a spiral about the retro direction, as one scan with noise and effects."""
    unit = np.concatenate((rings(3.0), spiral(RETRO_30, 6.0, 0.4)))
    return distribution(unit, lobe(4.0, 1.5, RETRO_30), noise=0.02, rng=np.random.default_rng(seed), effects=EFFECTS)


@pytest.mark.parametrize("split", SPLITS, ids=["every-fourth", "quarters"])
def test_a_scan_split_in_four_merges_to_the_whole(split):
    scan = whole_scan()
    n = len(scan.theta_deg)
    parts = [dataset(part(scan, chosen), raw="one log") for chosen in split(n)]
    found = merge(sources(*parts), [], MergeOptions()).dataset.distributions[0]
    assert np.array_equal(found.time_ns, scan.time_ns), "the order flown is restored"
    for name in ("theta_deg", "phi_deg", "dsf_per_sr", "variance_per_sr2", "signal", "normalisation"):
        assert np.array_equal(getattr(found, name), getattr(scan, name)), name
    assert np.array_equal(found.solid_angle_sr, scan.solid_angle_sr)
    assert np.array_equal(found.linear_solid_angle_sr, scan.linear_solid_angle_sr)
    assert found.paths == scan.paths
    assert set(found.effects) == set(EFFECTS), "one session, one mount: no scope"
    expected = integrals(scan)
    assert expected["rho_u"] > 0.004 * expected["rho_measured"], "P_i alone is that much"
    for name, value in expected.items():
        assert found.integrals[name] == pytest.approx(value, rel=1e-12), name
    for key, change in linear_result(scan, scan.solid_angle_sr).effects.items():
        assert linear_result(found, found.solid_angle_sr).effects[key] == pytest.approx(change, rel=1e-12)


def test_four_sessions_of_interleaved_samples_give_the_whole_within_their_noise():
    """The same samples, but said to be of four sessions: they share cells by weight, with nothing to choose between
    them; the noise of the integral is that of the whole, and a session's P_i averages out."""
    scan = whole_scan()
    n = len(scan.theta_deg)
    parts = [dataset(part(scan, chosen), raw=f"log {k}") for k, chosen in enumerate(SPLITS[0](n))]
    found = merge(sources(*parts), [], MergeOptions()).dataset.distributions[0]
    ours, whole = (linear_result(d, d.solid_angle_sr) for d in (found, scan))
    assert ours.value == pytest.approx(whole.value, abs=1.0 * whole.independent)
    assert ours.independent == pytest.approx(whole.independent, rel=0.05)
    of_p_i = [change for key, change in ours.effects.items() if key.startswith("p_i #")]
    assert len(of_p_i) == 4
    assert np.linalg.norm(of_p_i) == pytest.approx(0.5 * abs(whole.effects["p_i"]), rel=0.02)
    assert ours.effects["distance"] == pytest.approx(whole.effects["distance"], rel=1e-3), "one instrument"
    assert sum(key.startswith("tilt_x #") for key in ours.effects) == 4


def test_mountings_are_one_if_the_user_says_so():
    scan = whole_scan()
    parts = [dataset(part(scan, chosen), raw=f"log {k}") for k, chosen in enumerate(SPLITS[0](len(scan.theta_deg)))]
    found = merge(sources(*parts, same_mount=True), [], MergeOptions()).dataset.distributions[0]
    assert "tilt_x" in found.effects
    assert not any(key.startswith("tilt_x #") for key in found.effects)


def test_two_sessions_over_one_track_are_weighted_by_inverse_variance():
    """Both flew the same circles; one is three times as noisy: the merged noise is that of the weighted mean, and below
    that of the better one."""
    unit = rings(3.0)
    rng = np.random.default_rng(5)
    good = distribution(unit, lambertian(), noise=0.02, floor=0.0, rng=rng)
    poor = distribution(unit, lambertian(), noise=0.06, floor=0.0, rng=rng)
    found = merge(sources(dataset(good, raw="g"), dataset(poor, raw="p")), [], MergeOptions())
    assert found.statistics["distributions"][0]["sets"][0]["counts"]["weighted"] == 2 * len(unit)
    d = found.dataset.distributions[0]
    merged, better = linear_result(d, d.solid_angle_sr), linear_result(good, good.solid_angle_sr)
    assert merged.independent / better.independent == pytest.approx(1.0 / np.sqrt(1.0 + 1.0 / 9.0), rel=0.01)
    assert merged.value == pytest.approx(0.6, rel=5 * 0.02 / np.sqrt(len(unit)) + 1e-3)
    share = d.solid_angle_sr[d.variance_per_sr2 < (0.03 * d.dsf_per_sr) ** 2].sum() / d.solid_angle_sr.sum()
    assert share == pytest.approx(0.9, abs=0.02)


def test_weights_do_not_follow_the_noise_of_single_points():
    """Shot noise: variance proportional to the reading. Weighting each point by its own variance would be 2.5 % low
    here; many repeats of two passes show no bias."""
    unit = rings(3.0)
    rng = np.random.default_rng(8)
    sums = []
    for _ in range(8):
        sets = []
        for raw in "gp":
            d = distribution(unit, lambertian(), noise=0.2, floor=0.0, rng=rng)
            d.variance_per_sr2 = np.maximum(d.dsf_per_sr, 1e-3) * 0.04 * lambertian()(unit)
            sets.append(dataset(d, raw=raw))
        found = merge(sources(*sets), [], MergeOptions()).dataset.distributions[0]
        sums.append(linear_result(found, found.solid_angle_sr).value)
    error = 0.2 / np.sqrt(2 * len(unit) * len(sums))
    assert np.mean(sums) / 0.6 == pytest.approx(1.0, abs=4 * error)
    assert error < 0.002


def test_a_direction_that_one_session_masked_belongs_to_the_other():
    unit = rings(2.0)
    a, b = (distribution(unit, lambertian()) for _ in range(2))
    a = masked(a, angle_between_deg(unit, RETRO_30) < 7.0)
    lost = int((~a.measured).sum())
    found = merge(sources(dataset(a, raw="a"), dataset(b, raw="b")), [], MergeOptions())
    d = found.dataset.distributions[0]
    assert found.statistics["distributions"][0]["sets"][0]["counts"]["masked_but_measured"] == lost > 50
    assert d.measured.all()
    assert d.integrals["rho_measured"] == pytest.approx(0.6, rel=1e-3)


def test_a_direction_that_both_sessions_masked_stays_masked():
    """The detector's head shades the same cap in both; samples fall at other places of the same tracks. What was
    measured beside the cap, within a pitch, does not make it measured."""
    unit = rings(2.0)
    turned = unit @ np.array([[np.cos(0.01), np.sin(0.01), 0.0], [-np.sin(0.01), np.cos(0.01), 0.0], [0.0, 0.0, 1.0]])
    a, b = (
        masked(d, angle_between_deg(units(d), RETRO_30) < 5.0)
        for d in (distribution(u, lambertian()) for u in (unit, turned))
    )
    d = merge(sources(dataset(a, raw="a"), dataset(b, raw="b")), [], MergeOptions()).dataset.distributions[0]
    masked_sr = a.solid_angle_sr[~a.measured].sum()
    assert masked_sr == pytest.approx(2.0 * np.pi * (1.0 - np.cos(np.radians(5.0))), rel=0.2)
    assert d.solid_angle_sr[~d.measured].sum() == pytest.approx(masked_sr, rel=0.1)
    assert d.integrals["rho_measured"] == pytest.approx(
        a.dsf_per_sr[a.measured] @ a.solid_angle_sr[a.measured], rel=1e-3
    )


def test_samples_that_are_there_twice_count_once():
    scan = whole_scan()
    n = len(scan.theta_deg)
    first, last = part(scan, np.arange(n) < 0.7 * n), part(scan, np.arange(n) > 0.4 * n)
    found = merge(sources(dataset(first, raw="x"), dataset(last, raw="x")), [], MergeOptions()).dataset
    assert np.array_equal(found.distributions[0].time_ns, scan.time_ns)


def test_channels_incident_directions_and_detectors_stay_apart():
    unit = rings(4.0)
    effects = {"gain_ratio": 0.001, "distance": 0.002, "p_i": 0.003}
    visible = distribution(unit, lambertian(0.6), effects=effects)
    infrared = distribution(unit, lambertian(0.3), effects=effects, channel="near infrared")
    other = distribution(unit, lambertian(0.5), incident=(30.3, 0.0), effects=effects)
    back = distribution(unit * [1.0, 1.0, -1.0], lambertian(0.5), incident=(150.0, 0.0), effects=effects)
    parts = sources(dataset(visible, other, raw="v"), dataset(infrared, raw="n"), dataset(back, raw="b"))
    found = merge(parts, [], MergeOptions()).dataset.distributions
    assert [(d.channel, d.incident_theta_deg) for d in found] == [
        ("visible", 30.0),
        ("visible", 30.3),
        ("near infrared", 30.0),
        ("visible", 150.0),
    ]
    assert "gain_ratio #visible" in found[0].effects
    assert "gain_ratio #near-infrared" in found[2].effects
    assert "distance" in found[0].effects
    assert "distance" in found[2].effects
    p_i = [next(key for key in d.effects if key.startswith("p_i")) for d in found]
    assert p_i[0] == p_i[1] != p_i[2]


def test_incident_directions_are_compared_as_the_axes_read_them():
    """Planned alike but flown 0.3 degrees apart: not one direction; planned a hair apart and flown alike: one."""
    unit = rings(4.0)
    a, b, c = (distribution(unit, lambertian(), incident=(t, 0.0)) for t in (30.0, 30.0, 30.2))
    for d, read in ((a, 30.01), (b, 30.31), (c, 30.02)):
        d.integrals = {"incident_measured_theta_deg": read, "incident_measured_phi_deg": 0.0}
    found = merge(sources(*(dataset(d, raw=r) for d, r in zip((a, b, c), "abc", strict=True))), [], MergeOptions())
    assert [len(entry["sets"][0]["passes"]) for entry in found.statistics["distributions"]] == [2, 1]
    read = found.dataset.distributions[0].integrals["incident_measured_theta_deg"]
    assert read == pytest.approx(30.015, abs=1e-6)


def test_a_p_i_without_column_gets_one_and_counts_once():
    unit = rings(4.0)
    a, b = (distribution(unit, lambertian()) for _ in range(2))
    a.p_i_u_rel = b.p_i_u_rel = 0.01
    d = merge(sources(dataset(a, raw="a"), dataset(b, raw="b")), [], MergeOptions()).dataset.distributions[0]
    u = d.integrals["rho_u"] / d.integrals["rho_measured"]
    assert u == pytest.approx(0.01 / np.sqrt(2.0), rel=0.02), "two sessions, two causes"
    assert np.allclose(d.signal / (d.normalisation * d.p_i), d.dsf_per_sr, rtol=1e-14)
    assert len(units(d)) == 2 * len(unit)


def test_weights_know_what_a_session_has_in_common():
    """Noise is small; one session's P_i is known three times worse: it gets a tenth of what they share."""
    unit = rings(3.0)
    rng = np.random.default_rng(6)
    sets = [
        dataset(
            distribution(unit, lambertian(), noise=1e-4, floor=0.0, rng=rng, effects={"p_i": u}, drawn={"p_i": t}),
            raw=raw,
        )
        for raw, u, t in (("good", 0.01, 0.0), ("poor", 0.03, 1.0))
    ]
    d = merge(sources(*sets), [], MergeOptions()).dataset.distributions[0]
    ours = linear_result(d, d.solid_angle_sr)
    assert ours.value / 0.6 == pytest.approx(1.0 + 0.03 * 0.1, abs=0.002)
    assert ours.u / ours.value == pytest.approx(0.01 / np.sqrt(1.0 + 1.0 / 9.0), rel=0.02)
