"""test_judges_retro.py: on the same points our model and our tree come nearer the truth than Radiance's chain; the
judges themselves are judged by what is known without them.

A small version of benchmarks/models: few points, coarse trees.
"""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.models import metrics, ours, radiance_chain, retro, through_radiance
from benchmarks.models.ceilings import DenseTree, disc_from_square, square_from_disc
from benchmarks.models.points import ARRANGEMENTS, Noise, sampled
from benchmarks.models.samples import RetroCoating, TwoPeaked
from gonio.dataset.scattering import Bsdf, FloatArray
from gonio.formats.tensor.write import write_tensor
from gonio.geometry.directions import unit_from_angles_deg

POINTS = 3000
JUDGED_DEG = 45.0
RESOLUTION = 6
SAMPLE = RetroCoating()


@pytest.mark.judge
def test_the_coating_is_nearer_the_truth_than_with_radiances_chain(tmp_path: Path) -> None:
    measured = retro.dataset(SAMPLE, POINTS)
    chain = radiance_chain.fit(measured, tmp_path / "radiance")
    peer_tree = chain.tree(RESOLUTION)
    made = ours.fit(measured, tmp_path / "ours")
    tree = made.tree(3, RESOLUTION + 1, peer_tree.stat().st_size / 1e6)
    assert tree.stat().st_size <= peer_tree.stat().st_size
    peer = retro.of_file(SAMPLE, peer_tree, JUDGED_DEG, tmp_path)
    model = retro.of_model(SAMPLE, made, JUDGED_DEG)
    file = retro.of_file(SAMPLE, tree, JUDGED_DEG, tmp_path)
    assert model.cv < 0.3
    assert model.cv < 0.2 * peer.cv
    assert abs(model.peak_kept - 100.0) < 5.0 < 100.0 - peer.peak_kept
    assert model.integral_error is not None
    assert abs(model.integral_error) < 0.2
    assert file.cv < 0.8 * peer.cv
    assert file.peak_kept > peer.peak_kept
    assert file.integral_error is not None
    assert abs(file.integral_error) < 0.2


@pytest.mark.judge
def test_a_dense_tree_is_what_radiance_reads_in_a_full_file(tmp_path: Path) -> None:
    """The ceiling, worked out without a file, is what Radiance's own reader says of a tree that kept all its leaves."""
    tree, k = tmp_path / "tree.xml", 5
    known = Bsdf({"visible": SAMPLE}, symmetry="isotropic", front_faces="interior")
    write_tensor(known, tree, dimensions=3, resolution=k, size_mb=20.0)
    for theta in (20.0, 55.0):
        outgoing = metrics.plane(0.0)[::7]
        expected = DenseTree(SAMPLE, k, order=16).dsf_per_sr(unit_from_angles_deg([theta], [0.0])[0], outgoing)
        found, _ = through_radiance.read(tree, (theta, 0.0), outgoing, tmp_path)
        # Radiance moves a direction a little: at a cell's border it may read the next one.
        assert np.mean(np.abs(found / expected - 1.0) < 5e-3) > 0.99


def test_the_square_of_the_disc_keeps_areas_and_comes_back() -> None:
    rng = np.random.default_rng(1)
    square = rng.random((2000, 2))
    assert np.allclose(square_from_disc(disc_from_square(square)), square, atol=1e-12)
    radius = np.hypot(*disc_from_square(square).T)
    assert np.allclose(np.mean(radius < 0.5), 0.25, atol=0.03)


@pytest.mark.parametrize("name", sorted(ARRANGEMENTS))
def test_the_points_of_every_arrangement_integrate_diffuse_light(name: str) -> None:
    """0.25/pi cos has the integral 0.25; cells cover the hemisphere."""
    flat = RetroCoating(retro_per_sr=0.0, mirror_per_sr=0.0)
    d = sampled(flat, [(40.0, 0.0)], POINTS, ARRANGEMENTS[name]).distributions[0]
    assert np.sum(d.solid_angle_sr) == pytest.approx(2 * np.pi, rel=1e-6)
    assert np.sum(d.solid_angle_sr * d.dsf_per_sr) == pytest.approx(0.25, rel=3e-3)


def test_noise_is_of_the_stated_variance() -> None:
    noise = Noise()
    clean, noisy = (sampled(SAMPLE, [(40.0, 0.0)], POINTS, noise=n).distributions[0] for n in (None, noise))
    pull = (noisy.dsf_per_sr - clean.dsf_per_sr) / np.sqrt(noisy.variance_per_sr2)
    assert np.std(pull) == pytest.approx(1.0, abs=0.05)
    assert np.allclose(noisy.variance_per_sr2, (0.01 * clean.dsf_per_sr) ** 2 + 0.002**2)


def gaussian(height: float, sigma_deg: float) -> FloatArray:
    return np.asarray(1.0 + height * np.exp(-(((metrics.PLANE_DEG - 30.0) / sigma_deg) ** 2) / 2))


def test_metrics_say_what_was_done_to_a_peak() -> None:
    truth = gaussian(100.0, 1.2)
    same = metrics.judged(truth, truth)
    assert (same.cv, same.within, same.peak_kept, same.width_kept) == (0.0, (100.0, 100.0, 100.0), 100.0, 100.0)
    wider = metrics.judged(truth, gaussian(50.0, 2.4))
    assert wider.peak_kept == pytest.approx(100 * 51 / 101)
    assert wider.width_kept == pytest.approx(200.0, abs=2.0)
    offset = metrics.judged(truth, truth * 1.07)
    assert offset.within == (0.0, 100.0, 100.0)
    assert offset.cv == pytest.approx(0.07 * np.sqrt(np.mean(truth**2)) / np.mean(truth))
    gap = np.where(metrics.PLANE_DEG > 60.0, np.nan, truth)
    assert metrics.judged(truth, gap).absent == 250


def test_the_two_peaked_sample_is_left_right_symmetric_and_lopsided_up_down() -> None:
    sample = TwoPeaked()
    incident, outgoing = unit_from_angles_deg([35.0], [20.0]), metrics.hemisphere()[0][::97]

    def turned(signs: tuple[float, float, float]) -> FloatArray:
        return sample.dsf_per_sr(incident * np.array(signs), outgoing * np.array(signs))

    straight = sample.dsf_per_sr(incident, outgoing)
    assert np.allclose(turned((-1.0, 1.0, 1.0)), straight)
    assert not np.allclose(turned((1.0, -1.0, 1.0)), straight, rtol=0.1)
    peaks = [float(sample.dsf_per_sr(incident, facet.centre(incident))[0]) for facet in sample.facets]
    assert peaks[0] > 40.0
    assert 2.0 < peaks[1] < 3.0
