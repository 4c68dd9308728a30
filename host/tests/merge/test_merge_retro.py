"""test_merge_retro.py: the retro rig: rays traced through the splitters come back as the sample's own distribution."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form_sets import dataset, distribution, lambertian, lobe, masked, rings, sources, spiral
from numpy.typing import NDArray

from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.merge.merging import MergeOptions, Rig, merge
from gonio.merge.points import units
from gonio.merge.retro import Plate, RetroOptions, retro_distribution
from gonio.merge.splitter_view import (
    REFERENCE_LAB,
    SAMPLE_LAB,
    lab_from_sample,
    seen_from_sample,
    seen_in_splitter,
)
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]
ARM_MM, DISTANCE_MM = 1020.0, 105.0
T_R = 0.2401  # of both splitters together
PLATE = Plate(0.68, 0.30, 0.30, 0.68)


def traced(outgoing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rays from the sample (0, 0, -d) into `outgoing` (n, 3), lab frame, by the splitter x = z to the sphere: detector
    directions (n, 3), and irradiance r^2 there per intensity (n,). Plane and sphere are met one after the other."""
    start = np.array([0.0, 0.0, -DISTANCE_MM])
    normal = np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0)
    first = -(start @ normal) / (outgoing @ normal)
    place = start + first[:, None] * outgoing
    after = outgoing - 2.0 * (outgoing @ normal)[:, None] * normal
    along = np.einsum("ij,ij->i", place, after)
    second = -along + np.sqrt(along**2 + ARM_MM**2 - np.einsum("ij,ij->i", place, place))
    landed = (place + second[:, None] * after) / ARM_MM
    slant = np.einsum("ij,ij->i", landed, after)
    return landed, slant * (ARM_MM / (first + second)) ** 2


def rig_set(
    truth, incident=(30.0, 40.0), *, step=1.0, radius_deg=8.6, noise=0.0, rng=None, p_i_wrong=1.0, tilt_deg=0.0
):
    """A scan about the lab's (90, 0) and (90, 180), as the sample frame at `incident` has it; `truth` is the sample's
    DSF of directions in the sample frame. `tilt_deg`: the rig's own turn about Y that nobody knows."""
    turn = lab_from_sample(*incident)
    tilt = lab_from_sample(-tilt_deg, 0.0)
    outgoing = spiral(np.array([0.0, 0.0, 1.0]), radius_deg, 0.35)
    detector, per_intensity = traced(outgoing)
    reading = step * T_R * truth(outgoing @ tilt @ turn) * per_intensity
    reference = spiral(REFERENCE_LAB, 3.0, 0.1)
    sigma_deg = 0.4
    height = T_R / (2.0 * np.pi * np.radians(sigma_deg) ** 2)
    beam = height * np.exp(-0.5 * (angle_between_deg(reference, REFERENCE_LAB) / sigma_deg) ** 2)
    values = np.concatenate((reading, beam)) / p_i_wrong
    found = distribution(
        np.concatenate((detector, reference)) @ turn, lambda _: values, noise=noise, rng=rng, incident=incident
    )
    found.p_i, found.signal = 1000.0 * p_i_wrong, 1000.0 * p_i_wrong * found.dsf_per_sr
    found.path = np.repeat(np.array([0, 1], dtype=np.int32), [len(detector), len(reference)])
    found.paths = ("retro", "reference")
    return found


def test_the_papers_numbers():
    """Slip S11: eq. 2 gives 6.797 degrees for 7.5, the exact way 6.801 over 1124.2 mm; E falls by 1.216."""
    seen = seen_in_splitter(unit_from_angles_deg([82.5, 90.0], [0.0, 0.0]), ARM_MM, DISTANCE_MM)
    exact_deg = angle_between_deg(seen.outgoing[0], [0.0, 0.0, 1.0])
    assert exact_deg == pytest.approx(6.801, abs=5e-4)
    assert seen.distance_mm == pytest.approx([1124.2, 1125.0], abs=0.05)
    by_eq_2_deg = np.degrees(np.arcsin(ARM_MM / 1125.0 * np.sin(np.radians(7.5))))
    assert by_eq_2_deg == pytest.approx(6.797, abs=5e-4)
    assert exact_deg - by_eq_2_deg == pytest.approx(0.0049, abs=1e-4)
    assert seen.dsf_factor[1] == pytest.approx(1.2165, abs=5e-5)


def test_view_and_inverse_agree_with_traced_rays():
    rng = np.random.default_rng(1)
    outgoing = rng.normal([0.0, 0.0, 1.0], 0.1, (50, 3))
    outgoing /= np.linalg.norm(outgoing, axis=1)[:, None]
    landed, per_intensity = traced(outgoing)
    seen = seen_in_splitter(landed, ARM_MM, DISTANCE_MM)
    assert np.allclose(seen.outgoing, outgoing, atol=1e-13)
    assert np.allclose(seen.dsf_factor * per_intensity, 1.0, rtol=1e-12)
    assert np.allclose(seen_from_sample(outgoing, ARM_MM, DISTANCE_MM), landed, atol=1e-13)


@pytest.mark.parametrize("incident", [(0.0, 0.0), (30.0, 40.0), (60.0, 250.0), (150.0, 10.0)])
def test_the_sample_comes_back(incident):
    """A lobe beside the retro direction, within the plane of incidence and out of it: rotating (90, 0) to (0, 0) as the
    paper says would put it on the wrong side. P_i of the file is wrong by a factor and plays no part."""
    turn = lab_from_sample(*incident)
    beside = np.array([0.02, 0.05, 1.0]) @ turn
    truth = lobe(8.0, 1.5, beside / np.linalg.norm(beside), ground=0.02)
    found = retro_distribution(*2 * (rig_set(truth, incident, p_i_wrong=2.1),), "unpolarised", RetroOptions())
    d = found.distribution
    assert np.allclose(d.dsf_per_sr, truth(units(d)), rtol=5e-4)
    assert found.radius_deg == pytest.approx(7.5, abs=0.1)
    assert angle_between_deg(units(d), turn[2]).max() <= 7.5
    assert found.facts["reference_power"] == pytest.approx(1000.0 * T_R, rel=3e-4)
    assert found.facts["reference_quadrature_rel"] < 0.01
    assert np.allclose(d.signal / (d.normalisation * d.p_i), d.dsf_per_sr, rtol=1e-12)


def test_what_moves_sample_and_reference_alike_cancels():
    rig = rig_set(lambertian(0.8))
    rig.effects = {
        "linearity": 0.01 * rig.dsf_per_sr,
        "p_i": -0.02 * rig.dsf_per_sr,
        "dark": np.full(len(rig.dsf_per_sr), 1e-3),
    }
    d = retro_distribution(rig, rig, "unpolarised", RetroOptions(sample_distance_u_mm=2.0)).distribution
    assert "p_i" not in d.effects
    assert np.abs(d.effects["linearity"]).max() < 1e-6 * d.dsf_per_sr.max()
    area = np.pi * np.radians(3.0) ** 2
    expected = 1e-3 * (np.median(seen_factor()) / T_R - d.dsf_per_sr * area / T_R)
    assert np.allclose(d.effects["dark"], expected, rtol=0.02)
    assert np.allclose(d.effects["distance rig"] / d.dsf_per_sr, 2.0 * 2.0 / 1125.0, rtol=0.01)


def seen_factor() -> FloatArray:
    return seen_in_splitter(SAMPLE_LAB[None], ARM_MM, DISTANCE_MM).dsf_factor


def test_distance_effect_is_the_change_with_the_distance():
    rig = rig_set(lambertian(0.8))
    values = [
        retro_distribution(rig, rig, "unpolarised", RetroOptions(sample_distance_mm=d)).distribution
        for d in (DISTANCE_MM, DISTANCE_MM + 1.0)
    ]
    n = min(len(d.dsf_per_sr) for d in values)
    change = values[1].dsf_per_sr[: n // 2] - values[0].dsf_per_sr[: n // 2]
    assert np.allclose(2.0 * values[0].effects["distance rig"][: n // 2], change, rtol=0.01)


def test_the_polarisation_step_is_taken_out_or_carried():
    """Slip S12: a depolarising sample reads <T><R> / <T R> = 1.177 too high, one that keeps polarisation does not."""
    assert PLATE.step("unpolarised") == pytest.approx(0.2401 / 0.204, rel=1e-12)
    assert PLATE.step("s") == pytest.approx(0.49 / 0.68, rel=1e-12)
    truth = lambertian(0.8)
    rig = rig_set(truth, step=PLATE.step("unpolarised"))
    known = RetroOptions(plate=PLATE, depolarisation=1.0, depolarisation_u=0.1)
    d = retro_distribution(rig, rig, "unpolarised", known).distribution
    assert np.allclose(d.dsf_per_sr, truth(units(d)), rtol=5e-4)
    assert np.allclose(d.effects["p_i polarisation"] / d.dsf_per_sr, -0.1 * (1.0 - 0.204 / 0.2401), rtol=1e-9)
    unknown = retro_distribution(rig, rig, "unpolarised", RetroOptions(plate=PLATE)).distribution
    off_rel = unknown.dsf_per_sr / truth(units(unknown)) - 1.0
    u_rel = np.abs(unknown.effects["p_i polarisation"]) / unknown.dsf_per_sr
    assert np.allclose(off_rel / u_rel, np.sqrt(12.0) / 2.0, rtol=0.01), "the end of a rectangular distribution"


def test_alignment_turns_the_maximum_to_retro():
    incident = (30.0, 40.0)
    retro = unit_from_angles_deg(*incident)
    rig = rig_set(lobe(8.0, 1.0, retro), incident, tilt_deg=0.8)
    found = retro_distribution(rig, rig, "unpolarised", RetroOptions(align=True))
    assert found.facts["turned_deg"] == pytest.approx(0.8, abs=0.02)
    d = found.distribution
    top = units(d)[d.dsf_per_sr > 4.0].mean(axis=0)
    assert angle_between_deg(top / np.linalg.norm(top), retro) < 0.03
    far = rig_set(lobe(8.0, 1.0, retro), incident, tilt_deg=5.0)
    with pytest.raises(UsageError, match="too far for an alignment"):
        retro_distribution(far, far, "unpolarised", RetroOptions(align=True))


def test_missing_parts_are_told():
    rig = rig_set(lambertian())
    turn = lab_from_sample(30.0, 40.0)
    about = {k: angle_between_deg(units(rig) @ turn.T, v) < 20.0 for k, v in (("s", SAMPLE_LAB), ("r", REFERENCE_LAB))}
    no_reference = masked(replace(rig, dsf_per_sr=rig.dsf_per_sr.copy()), about["r"])
    with pytest.raises(UsageError, match=r"of the lab's \(90, 180\)"):
        retro_distribution(no_reference, no_reference, "unpolarised", RetroOptions())
    no_sample = masked(rig_set(lambertian()), about["s"])
    with pytest.raises(UsageError, match=r"no point was measured about the lab's \(90, 0\)"):
        retro_distribution(no_sample, no_sample, "unpolarised", RetroOptions())


def merged(step: float, options: RetroOptions):
    """A hemispherical scan whose zone about the retro direction is shaded, and the rig's scan of that zone."""
    incident = (30.0, 0.0)
    retro = unit_from_angles_deg(*incident)
    truth = lobe(6.0, 1.5, retro, ground=0.2)
    rng = np.random.default_rng(3)
    hemisphere = distribution(rings(1.5), truth, noise=0.01, rng=rng, incident=incident, floor=1e-5)
    hemisphere = masked(hemisphere, angle_between_deg(units(hemisphere), retro) < 6.5)
    rig = rig_set(truth, incident, step=step, noise=0.01, rng=rng)
    parts = sources(dataset(hemisphere, raw="hemisphere"), dataset(rig, raw="rig"))
    return merge(parts[:1], [Rig(parts[1], None, options)], MergeOptions()), truth


def test_hemisphere_and_rig_become_one_set():
    found, _ = merged(1.0, RetroOptions())
    d = found.dataset.distributions[0]
    assert len(found.dataset.distributions) == 1
    assert d.measured.all()
    assert d.integrals["rho_measured"] == pytest.approx(
        0.2 * np.pi + 6.0 * 2.0 * np.pi * np.radians(1.5) ** 2, rel=0.004
    )
    away = angle_between_deg(units(d), unit_from_angles_deg(30.0, 0.0))
    rig_points = np.array([d.paths[k].startswith("retro #") for k in d.path])
    assert away[rig_points].max() < away[~rig_points].min(), "complementary: none of the one among the other"
    seam = found.statistics["distributions"][0]["sets"][0]["seams"][0]
    assert not seam["step"]
    assert abs(seam["mean_log_ratio"]) < 0.02
    assert found.statistics["retro"][0]["distributions"][0]["points_removed_elsewhere"] > 100
    assert any(key.startswith("p_i rig #") for key in d.effects)


def test_a_depolarising_sample_shows_a_step_that_the_plate_explains():
    found, _ = merged(PLATE.step("unpolarised"), RetroOptions())
    seam = found.statistics["distributions"][0]["sets"][0]["seams"][0]
    assert (seam["one"], seam["other"]) == ("a.h5", "b.h5"), "hemisphere against rig"
    assert seam["mean_log_ratio"] == pytest.approx(-np.log(0.2401 / 0.204), abs=0.01)
    assert seam["step"]
    assert any("artefact" in remark for remark in found.remarks)
    carried, _ = merged(PLATE.step("unpolarised"), RetroOptions(plate=PLATE))
    assert not carried.statistics["distributions"][0]["sets"][0]["seams"][0]["step"], "within its stated uncertainty"
