"""test_merge_polarisation.py: s and p become unpolarised: values, noise, and what both share."""

import numpy as np
import pytest
from closed_form_sets import RETRO_30, dataset, distribution, lambertian, lobe, masked, rings, sources, spiral

from gonio.dataset.uncertainty import linear_result
from gonio.geometry.directions import angle_between_deg
from gonio.merge.merging import MergeOptions, merge
from gonio.units.errors import UsageError

EFFECTS = {"p_i": 0.004, "distance": 0.003}


def s_and_p(rng, noise=0.02, shift=0.4):
    """s reads 0.4, p 0.2 Lambertian and a lobe each; p was flown a little beside s, and denser."""
    truths = [lambda u: lobe(2.0, 3.0, RETRO_30)(u) + lambertian(0.4)(u), lobe(1.0, 3.0, RETRO_30)]
    units = [
        np.concatenate((rings(4.0), spiral(RETRO_30, 7.0, 0.6))),
        np.concatenate((rings(4.0, start_deg=shift), spiral(RETRO_30, 7.0, 0.45))),
    ]
    sets = [
        distribution(u, t, noise=noise, floor=1e-4, rng=rng, effects=EFFECTS)
        for u, t in zip(units, truths, strict=True)
    ]
    return sets, lambda u: 0.5 * (truths[0](u) + truths[1](u))


def merged(sets, **options):
    named = [dataset(d, raw=f"log {k}", polarisation=k) for d, k in zip(sets, "sp", strict=True)]
    return merge(sources(*named), [], MergeOptions(**options))


def test_the_mean_of_s_and_p_is_unpolarised():
    sets, truth = s_and_p(np.random.default_rng(1))
    found = merged(sets)
    assert found.dataset.polarisation == "unpolarised"
    d = found.dataset.distributions[0]
    unit = np.stack(
        (
            np.sin(np.radians(d.theta_deg)) * np.cos(np.radians(d.phi_deg)),
            np.sin(np.radians(d.theta_deg)) * np.sin(np.radians(d.phi_deg)),
            np.cos(np.radians(d.theta_deg)),
        ),
        axis=1,
    )
    pull = (d.dsf_per_sr - truth(unit)) / np.sqrt(d.variance_per_sr2)
    assert pull.std() == pytest.approx(1.0, abs=0.1)
    assert pull.mean() == pytest.approx(0.0, abs=0.1)
    counts = found.statistics["distributions"][0]["mean_of_s_and_p"]
    assert counts["paired"] == len(unit) > 0.85 * len(sets[0].theta_deg)


def test_noise_of_the_integral_is_the_scatter_of_repeats_and_shared_effects_add():
    rng = np.random.default_rng(2)
    sums = []
    for _ in range(16):
        d = merged(s_and_p(rng, noise=0.2)[0]).dataset.distributions[0]
        sums.append(linear_result(d, d.solid_angle_sr))
    values = np.array([s.value for s in sums])
    assert values.std(ddof=1) == pytest.approx(np.mean([s.independent for s in sums]), rel=0.45)
    share = [change / sums[0].value for key, change in sorted(sums[0].effects.items())]
    assert sorted(key.partition(" ")[0] for key in sums[0].effects) == ["distance", "p_i", "p_i"]
    assert share[0] == pytest.approx(0.003, rel=0.02), "one instrument: s and p move together"
    assert share[1] + share[2] == pytest.approx(0.004, rel=0.02), "each P_i moves its own part alone"
    assert min(share[1:]) > 0.0008


def test_masked_directions_stay_masked():
    sets, _ = s_and_p(np.random.default_rng(3))
    sets[0] = masked(sets[0], angle_between_deg(np.stack(_unit(sets[0]), axis=1), RETRO_30) < 1.5)
    d = merged(sets).dataset.distributions[0]
    assert (~d.measured).sum() == (~sets[0].measured).sum() > 10
    assert np.isnan(d.dsf_per_sr[~d.measured]).all()
    assert all(np.isnan(column[~d.measured]).all() for column in d.effects.values())


def _unit(d):
    theta, phi = np.radians(d.theta_deg), np.radians(d.phi_deg)
    return np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)


def test_a_direction_with_s_alone_is_left_out_and_named():
    sets, _ = s_and_p(np.random.default_rng(4))
    alone = distribution(rings(5.0), lambertian(), incident=(50.0, 0.0))
    named = [dataset(sets[0], alone, raw="s", polarisation="s"), dataset(sets[1], raw="p", polarisation="p")]
    found = merge(sources(*named), [], MergeOptions())
    assert len(found.dataset.distributions) == 1
    assert any("incident (50, 0): only s polarised light: left out" in remark for remark in found.remarks)


def test_other_polarisations_do_not_mix():
    unit = rings(5.0)
    sets = [dataset(distribution(unit, lambertian()), raw=k, polarisation=k) for k in ("s", "unpolarised")]
    with pytest.raises(UsageError, match="only s and p make a mean"):
        merge(sources(*sets), [], MergeOptions())
    assert merge(sources(*sets), [], MergeOptions(force=True)).dataset.polarisation == "unknown"


def test_the_mean_of_several_partners_has_its_own_variance():
    """s nearly without noise, p four times as dense: most of the directions have several p points."""
    rng = np.random.default_rng(5)
    s = distribution(rings(6.0), lambertian(0.4), noise=1e-4, rng=rng)
    p = distribution(rings(3.0), lambertian(0.2), noise=0.05, rng=rng, floor=1e-6)
    d = merged([s, p]).dataset.distributions[0]
    pull = (d.dsf_per_sr - lambertian(0.3)(np.stack(_unit(d), axis=1))) / np.sqrt(d.variance_per_sr2)
    assert pull.std() == pytest.approx(1.0, abs=0.12)
    assert np.median(0.5 * 0.05 * lambertian(0.2)(np.stack(_unit(d), axis=1)) / np.sqrt(d.variance_per_sr2)) > 1.5
