"""test_signature.py: the measured beam applied to a model, and taken out of a measurement again."""

import numpy as np
import pytest
from numpy.typing import NDArray
from signature_scene import beam_scan, distribution, spiral, truth_of

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import angle_between_deg, mirror, retro, through, unit_from_angles_deg
from gonio.reduce.signature import deconvolve as deconvolution
from gonio.reduce.signature.deconvolve import deconvolve
from gonio.reduce.signature.forward import apply
from gonio.reduce.signature.profile import BeamProfile, beam_places
from gonio.simulate.closed_form import Truth

SAMPLE = """
{ kind = "lambertian", reflectance = 0.3, transmittance = 0.1 },
{ kind = "gaussian", about = "mirror", sigma_deg = 1.2, integral = 0.2 },
{ kind = "gaussian", about = "through", sigma_deg = 0.6, integral = 0.1 },
"""
INCIDENT = (30.0, 40.0)
Scene = tuple[Truth, Distribution]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    truth = truth_of(tmp_path_factory.mktemp("signature"), SAMPLE.replace("\n", " "))
    return truth, beam_scan(truth)[1]


def near(about: tuple[object, object], radius_deg: float = 4.0) -> NDArray[np.float64]:
    theta_deg, phi_deg = (float(angle) for angle in about)  # type: ignore[arg-type]
    return spiral((theta_deg, phi_deg), radius_deg, 0.3, 0.3)


@pytest.mark.parametrize(("about", "lowered"), [(mirror, 0.04), (through, 0.15), (retro, 0.0)])
def test_a_model_seen_through_the_measured_beam_is_the_convolved_truth(
    scene: Scene, about: object, lowered: float
) -> None:
    """Closed form: quadrature over beam and aperture discs, written apart from the reduction."""
    truth, beam = scene
    unit = near(about(*INCIDENT))  # type: ignore[operator]
    bare = truth.dsf_per_sr(*INCIDENT, unit, convolved=False)
    seen = apply(beam, lambda v: truth.dsf_per_sr(*INCIDENT, v, convolved=False), unit, INCIDENT)
    expected = truth.dsf_per_sr(*INCIDENT, unit)
    assert np.abs(seen - expected).max() < 2e-3 * expected.max()
    assert np.abs(bare - expected).max() >= lowered * expected.max()


def test_a_beam_that_is_not_round_keeps_its_orientation(scene: Scene) -> None:
    """An elliptic beam: a narrow lobe seen through it is the beam itself, about through as scanned, about mirror turned
    over in the sample's plane."""
    _, round_beam = scene
    unit = spiral((180.0, 0.0), 3.0, 0.1, 0.1)
    x, y = np.degrees(unit[:, 0]), np.degrees(unit[:, 1])
    elliptic = distribution((0.0, 0.0), unit, np.exp(-0.5 * ((x / 0.8) ** 2 + (y / 0.3) ** 2)))
    elliptic.theta_deg = np.degrees(np.arctan2(np.hypot(x, y), -np.degrees(unit[:, 2])))
    elliptic.phi_deg = np.mod(np.degrees(np.arctan2(y, x)), 360.0)
    profile = BeamProfile.of(elliptic)
    for about, direction in (("through", through(*INCIDENT)), ("mirror", mirror(*INCIDENT))):
        axis = unit_from_angles_deg(*direction)

        def narrow(v: NDArray[np.float64], axis: NDArray[np.float64] = axis) -> NDArray[np.float64]:
            return np.asarray(np.exp(-0.5 * (angle_between_deg(v, axis) / 0.12) ** 2))

        places = near(direction, 2.0)
        seen = apply(elliptic, narrow, places, INCIDENT, nodes=2000)
        expected = profile.at(*beam_places(places, INCIDENT, about)) * 2.0 * np.pi * np.radians(0.12) ** 2  # type: ignore[arg-type]
        assert np.abs(seen - expected).max() < 0.1 * expected.max()  # the lobe is 0.12 degrees wide itself
    assert BeamProfile.of(round_beam).centroid_rad == pytest.approx((0.0, 0.0), abs=1e-5)


def test_the_profile_of_the_beam(scene: Scene) -> None:
    truth, beam = scene
    profile = BeamProfile.of(beam)
    angle_deg, mean = profile.radial()
    assert mean == pytest.approx(truth.beam_per_sr(angle_deg), abs=0.02 * mean.max())
    assert np.degrees(profile.fwhm_rad) == pytest.approx(0.95, abs=0.03)
    x = np.radians(np.linspace(-1.0, 1.0, 81))
    assert profile.at(x, np.zeros(81)) == pytest.approx(truth.beam_per_sr(np.abs(np.degrees(x))), abs=0.01 * mean.max())


def test_a_beam_without_light_has_no_profile(scene: Scene) -> None:
    _, beam = scene
    dark = Distribution(**{**vars(beam), "dsf_per_sr": np.zeros(len(beam.dsf_per_sr))})
    with pytest.raises(ValueError, match="holds no light"):
        BeamProfile.of(dark)


def test_deconvolution_gives_a_lobe_its_height_back_and_says_what_it_costs(scene: Scene) -> None:
    truth, beam = scene
    about = tuple(float(angle) for angle in mirror(*INCIDENT))
    unit = spiral((about[0], about[1]), 5.0, 0.3, 0.1)
    seen = truth.dsf_per_sr(*INCIDENT, unit)
    found = deconvolve(distribution(INCIDENT, unit, seen, noise_per_sr=1.0), beam, "mirror", 4.5)
    places = unit_from_angles_deg(found.theta_deg, found.phi_deg)
    bare = truth.dsf_per_sr(*INCIDENT, places, convolved=False)
    raw = truth.dsf_per_sr(*INCIDENT, places)
    inner = angle_between_deg(places, unit_from_angles_deg(*about)) < 3.5
    missed, missed_raw = (np.sqrt(np.mean((v - bare)[inner] ** 2)) for v in (found.dsf_per_sr, raw))
    assert missed < 0.6 * missed_raw
    assert abs(found.dsf_per_sr.max() - bare.max()) < 0.5 * abs(raw.max() - bare.max())
    covered = np.abs(found.dsf_per_sr - bare)[inner] < 2.0 * found.u_per_sr[inner]
    assert covered.mean() > 0.9
    assert found.misfit == pytest.approx(1.0, abs=0.05)
    record = found.record()
    assert record["height_noise_per_sr"] > 0.0
    assert record["points"] > 1000


def test_noise_of_a_deconvolved_peak_is_that_of_repeats(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deconvolution, "_MOST_CELLS", 250)
    truth, beam = scene
    about = tuple(float(angle) for angle in mirror(*INCIDENT))
    unit = spiral((about[0], about[1]), 3.4, 0.4, 0.2)
    seen = truth.dsf_per_sr(*INCIDENT, unit)
    runs = [
        deconvolve(distribution(INCIDENT, unit, seen, noise_per_sr=2.0, seed=seed), beam, "mirror", 3.0)
        for seed in range(8)
    ]
    scatter = np.std([run.dsf_per_sr for run in runs], axis=0, ddof=1)
    stated = np.mean([run.noise_per_sr for run in runs], axis=0)
    # The strength is found anew each time, which the stated noise leaves out.
    assert 0.6 < np.sqrt(np.mean(scatter**2)) / np.sqrt(np.mean(stated**2)) < 1.6


def test_a_patch_must_be_larger_than_the_beam(scene: Scene) -> None:
    truth, beam = scene
    unit = near(mirror(*INCIDENT))
    d = distribution(INCIDENT, unit, truth.dsf_per_sr(*INCIDENT, unit))
    with pytest.raises(ValueError, match="no larger than the beam"):
        deconvolve(d, beam, "mirror", 0.3)
    with pytest.raises(ValueError, match="too few"):
        deconvolve(d, beam, "through", 3.0)
