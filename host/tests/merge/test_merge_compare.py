"""test_merge_compare.py: overlap statistics against what was put in, outliers named, steps at seams found."""

import numpy as np
import pytest
from closed_form_sets import RETRO_30, dataset, distribution, lambertian, lobe, rings, sources, spiral

from gonio.geometry.directions import angle_between_deg
from gonio.merge.merging import MergeOptions, merge
from gonio.merge.overlap import disagreeing, outliers, overlap
from gonio.merge.seam import seam

P_I = {"p_i": 0.01}


def two_passes(rng, times, effects=("p_i #a", "p_i #b"), noise=0.03, steps=(3.0, 4.0)):
    """A coarse and a coarser pass of the same sample; `times`: how many sigma each session's P_i is off."""
    return [
        distribution(rings(step), lambertian(), noise=noise, floor=0.0, rng=rng, effects={key: 0.01}, drawn={key: t})
        for step, key, t in zip(steps, effects, times, strict=True)
    ]


def test_the_mean_ratio_is_what_was_put_in():
    a, b = two_passes(np.random.default_rng(1), (2.0, -1.0))
    found = overlap(("a", a), ("b", b), 1.5)
    assert found is not None
    assert found.ratio == pytest.approx(1.02 / 0.99, rel=0.004)
    assert found.ratio_u == pytest.approx(0.01 * np.sqrt(2.0) * found.ratio, rel=0.02), "P_i of both; noise is small"
    mean = 0.6 / (2.0 * np.pi)
    assert found.difference_per_sr == pytest.approx(0.03 * mean, rel=0.2)
    assert found.offset_in_u == pytest.approx(3.0 / np.sqrt(2.0), rel=0.15)
    assert found.points == pytest.approx(len(b.theta_deg), rel=0.1), "at the points of the sparse one"
    swapped = overlap(("b", b), ("a", a), 1.5)
    assert swapped is not None
    assert swapped.ratio == pytest.approx(1.0 / found.ratio, rel=1e-12)
    assert swapped.offset_in_u == pytest.approx(-found.offset_in_u, rel=1e-12)


def test_chi_squares_tell_noise_from_offset():
    """Right noise: chi2 of noise 1 to its own scatter. Stated three times too small: 9. An offset of one cause that
    both share does not count as doubt."""
    rng = np.random.default_rng(2)
    a, b = two_passes(rng, (0.0, 0.0))
    right = overlap(("a", a), ("b", b), 1.5)
    assert right is not None
    assert right.noise_chi2_per_dof == pytest.approx(1.0, abs=0.15)
    for d in (a, b):
        d.variance_per_sr2 /= 9.0
    small = overlap(("a", a), ("b", b), 1.5)
    assert small is not None
    assert small.noise_chi2_per_dof == pytest.approx(9.0 * right.noise_chi2_per_dof, rel=0.01)
    a, b = two_passes(rng, (3.0, 0.0), effects=("p_i", "p_i"))
    common = overlap(("a", a), ("b", b), 1.5)
    assert common is not None
    assert common.ratio == pytest.approx(1.03, rel=0.004)
    assert common.ratio_u < 0.003, "a shared P_i cancels in the ratio"
    assert abs(common.offset_in_u) > 10.0


def test_the_uncertainty_of_the_ratio_is_the_scatter_of_repeats():
    """The same two directions sets, noise drawn anew 40 times: the ratio scatters as ratio_u says. Interpolated values
    have noise in common, which taking them as independent would miss."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(40):
        a, b = two_passes(rng, (0.0, 0.0), noise=0.1, steps=(8.0, 7.0))
        pair = overlap(("a", a), ("b", b), 1.5)
        assert pair is not None
        found.append((pair.ratio, pair.ratio_u, pair.offset_in_u))
    ratio, u, _ = np.array(found).T
    noise_u = np.sqrt(np.mean(u**2) - 2.0 * 0.01**2)
    assert ratio.std(ddof=1) == pytest.approx(noise_u, rel=0.3)
    assert ratio.mean() == pytest.approx(1.0, abs=4 * noise_u / np.sqrt(40))


def test_passes_without_a_common_region_have_no_overlap():
    unit = rings(3.0)
    a = distribution(unit[unit[:, 0] > 0.2], lambertian())
    b = distribution(unit[unit[:, 0] < -0.2], lambertian())
    assert overlap(("a", a), ("b", b), 1.5) is None
    assert seam(("a", a), ("b", b)) is None, "they do not meet either"


def passes_with_one_off(count, off=1.05):
    rng = np.random.default_rng(4)
    unit = rings(4.0)
    sets = []
    for k in range(count):
        factor = off if k == 1 else 1.0
        d = distribution(unit, lambertian(0.6 * factor), noise=0.01, floor=0.0, rng=rng, effects={"p_i": 0.005})
        sets.append(dataset(d, raw=f"log {k}"))
    return sources(*sets)


def test_an_outlier_among_four_is_named_and_stays_until_told():
    parts = passes_with_one_off(4)
    kept = merge(parts, [], MergeOptions())
    assert any("b.h5 is an outlier" in remark and "kept" in remark for remark in kept.remarks)
    assert not any("a.h5 is an outlier" in remark for remark in kept.remarks)
    found = kept.statistics["distributions"][0]["sets"][0]
    assert found["outliers"] == {"b.h5": ["a.h5", "c.h5", "d.h5"]}
    assert found["dropped"] == []
    dropped = merge(parts, [], MergeOptions(drop_outliers=True))
    assert dropped.statistics["distributions"][0]["sets"][0]["dropped"] == ["b.h5"]
    assert dropped.dataset.provenance["merge"]["distributions"][0]["sets"][0]["dropped"] == ["b.h5"]
    rho = [found.dataset.distributions[0].integrals["rho_measured"] for found in (kept, dropped)]
    weight = 1.05**-2  # what reads 5 % more is by so much less sure of it
    assert rho[0] / rho[1] == pytest.approx(1.0 + 0.05 * weight / (3.0 + weight), abs=0.0003)


def test_of_two_passes_none_is_the_outlier():
    found = merge(passes_with_one_off(2), [], MergeOptions(drop_outliers=True))
    assert any("disagree" in remark and "which one is off they do not tell" in remark for remark in found.remarks)
    assert found.statistics["distributions"][0]["sets"][0]["dropped"] == []


def test_outliers_need_a_majority_against_them():
    pairs = merge(passes_with_one_off(3), [], MergeOptions()).statistics["distributions"][0]["sets"][0]
    assert pairs["outliers"] == {"b.h5": ["a.h5", "c.h5"]}
    assert outliers([], 3.0) == {}
    assert disagreeing([], 3.0) == []


def disc_and_rest(step, noise, rng, truth=None):
    """A spiral to 7.5 degrees from retro that reads `step` too high, and a hemispherical scan without that region."""
    truth = truth or lobe(3.0, 6.0, RETRO_30)
    rest = rings(1.0)
    rest = rest[(angle_between_deg(rest, RETRO_30) > 7.5) & (rest @ RETRO_30 > 0.8)]
    inner = spiral(RETRO_30, 7.5, 0.5)
    disc = distribution(inner, lambda u: (1.0 + step) * truth(u), noise=noise, rng=rng, floor=1e-5)
    return disc, distribution(rest, truth, noise=noise, rng=rng, floor=1e-5)


@pytest.mark.parametrize("step", [0.18, -0.05])
def test_a_step_at_the_seam_is_measured(step):
    """On the flank of a lobe, where the DSF changes by a fifth per degree."""
    disc, rest = disc_and_rest(step, 0.01, np.random.default_rng(6))
    found = seam(("rig", disc), ("hemisphere", rest))
    assert found is not None
    assert found.places >= 20
    assert found.mean_log_ratio == pytest.approx(np.log1p(step), abs=max(5 * found.mean_log_ratio_u, 0.003))
    assert found.mean_log_ratio_u < 0.004
    assert found.rms_log_ratio >= abs(found.mean_log_ratio)
    assert found.is_step(3.0)
    assert np.sign(found.step_in_u) == np.sign(step)


def test_no_step_where_there_is_none():
    """Noise drawn anew 16 times: mean log ratios within their uncertainty, no systematic step left by continuing the
    flank to the border."""
    rng = np.random.default_rng(7)
    found = [seam(("rig", a), ("rest", b)) for a, b in (disc_and_rest(0.0, 0.02, rng) for _ in range(16))]
    logs = np.array([border.mean_log_ratio for border in found if border is not None])
    u = np.array([border.mean_log_ratio_u for border in found if border is not None])
    assert len(logs) == 16
    assert abs(logs.mean()) < 4.0 * u.mean() / np.sqrt(16) + 0.002
    assert logs.std(ddof=1) == pytest.approx(u.mean(), rel=0.5)
    assert np.mean([border.rms_in_u for border in found if border is not None]) == pytest.approx(1.0, abs=0.2)


def test_a_shared_effect_makes_no_step_but_explains_none():
    """Both sides off by their common P_i: no step. The disc's own P_i off: within its uncertainty."""
    rng = np.random.default_rng(9)
    disc, rest = disc_and_rest(0.02, 0.01, rng)
    for d, key in ((disc, "p_i #rig"), (rest, "p_i #rest")):
        d.effects = {key: 0.02 * d.dsf_per_sr}
    own = seam(("rig", disc), ("rest", rest))
    assert own is not None
    assert not own.is_step(3.0)
    for d in (disc, rest):
        d.effects = {"p_i": 0.02 * d.dsf_per_sr}
    common = seam(("rig", disc), ("rest", rest))
    assert common is not None
    assert common.is_step(3.0)


def test_the_merge_reports_the_step_as_an_artefact():
    disc, rest = disc_and_rest(0.18, 0.01, np.random.default_rng(6))
    found = merge(sources(dataset(disc, raw="rig"), dataset(rest, raw="rest")), [], MergeOptions())
    assert any("a step of" in remark and "artefact" in remark for remark in found.remarks)
    assert found.statistics["distributions"][0]["sets"][0]["seams"][0]["step"] is True


def test_steep_places_are_left_out_of_the_ratio():
    """A lobe of sigma 1.5 degrees between points 3 degrees apart: the interpolation says nothing there."""
    truth = lobe(5.0, 1.5, RETRO_30, ground=0.1)
    a, b = (distribution(rings(step), truth) for step in (3.0, 3.5))
    found = overlap(("a", a), ("b", b), 1.5)
    assert found is not None
    assert found.steep > 3
    assert found.ratio == pytest.approx(1.0, abs=0.01)


def test_a_steep_flank_is_continued_to_the_border():
    """A lobe that falls by half per degree, free of noise: nothing left of it in the ratio."""
    disc, rest = disc_and_rest(0.0, 0.0, None, lobe(3.0, 4.0, RETRO_30))
    found = seam(("rig", disc), ("rest", rest))
    assert found is not None
    assert abs(found.mean_log_ratio) < 0.008
