"""test_pipeline.py: raw logs of known truth through the whole reduction: the figures that the instrument must reach."""

import logging
import re
from pathlib import Path

import numpy as np
import pytest
from synthetic_scan import BOOT_NS, POWER_COUNTS, Scan

from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import RawLog
from gonio.reduce.imported import reduce_dataset
from gonio.reduce.integrals.peaks import measure_peak
from gonio.reduce.options import ReduceOptions
from gonio.reduce.pipeline import reduce_rawlog
from gonio.simulate.closed_form import Truth
from gonio.units.errors import UsageError

FIGURES = logging.getLogger("gonio.figures")  # pytest --log-cli-level=INFO prints them
BEAM = '[beam]\nkind = "focused"\ndivergence_deg = 1.0\nedge_deg = 0.1\n'
LAMBERTIAN = '{kind="lambertian", reflectance=0.5}'
LOBE = '{kind="gaussian", about="mirror", sigma_deg=1.2, integral=0.2}, {kind="lambertian", reflectance=0.3}'


def make_truth(folder: Path, components: str) -> Truth:
    (folder / "s.toml").write_text(f"[sample]\ncomponents = [{components}]\n{BEAM}")
    return Truth.from_scenario(folder / "s.toml")


@pytest.fixture(scope="module")
def lobe_truth(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    return make_truth(tmp_path_factory.mktemp("lobe"), LOBE)


@pytest.fixture(scope="module")
def lobe_log(lobe_truth: Truth) -> RawLog:
    scan = Scan(lobe_truth)
    scan.dark()
    scan.reference()
    scan.coarse((30.0, 0.0), 14.0)
    scan.peak((30.0, 0.0), 6.0, 0.3)
    scan.dark()
    return scan.log()


@pytest.fixture(scope="module")
def lobe(lobe_log: RawLog) -> Dataset:
    return reduce_rawlog(lobe_log)


def test_lambertian_reflectance_within_0_2_percent(tmp_path: Path) -> None:
    scan = Scan(make_truth(tmp_path, LAMBERTIAN))
    scan.dark()
    scan.reference()
    scan.coarse((0.0, 0.0), 6.0)
    scan.dark()
    dataset = reduce_rawlog(scan.log())
    found = dataset.distributions[0].integrals
    FIGURES.info(
        "rho %.6f (filled %.6f), u %.6f, tau %.2e",
        *(found[k] for k in ("rho_estimate", "rho_filled", "rho_u", "tau_estimate")),
    )
    assert found["rho_estimate"] == pytest.approx(0.5, rel=2e-3)
    assert found["tau_estimate"] == pytest.approx(0.0, abs=1e-4)
    # The head's shade about the source is masked, and nothing is lost between it and the rest.
    assert found["masked_sr_front"] > 0.0
    assert found["measured_share_front"] + found["masked_sr_front"] / (2 * np.pi) == pytest.approx(1.0, abs=0.005)


def test_beam_power_within_0_1_percent(lobe: Dataset) -> None:
    assert lobe.beam is not None
    p_i = lobe.distributions[0].p_i
    # The monitor's mean over the reference scan is unity: the lamp had drifted by its middle.
    lamp = 1.0 + 2e-4 * float(np.mean(lobe.beam.time_ns - BOOT_NS)) * 1e-9
    FIGURES.info(
        "P_i / truth - 1 = %.2e, u_rel %.1e", p_i / (POWER_COUNTS * lamp) - 1.0, lobe.distributions[0].p_i_u_rel
    )
    assert p_i == pytest.approx(POWER_COUNTS * lamp, rel=1e-3)
    assert lobe.distributions[0].p_i_u_rel < 1e-3
    assert abs(lobe.beam.integrals["centroid_x_deg"]) < 0.002
    assert abs(lobe.beam.integrals["centroid_y_deg"]) < 0.002


def test_peak_against_the_convolved_truth(lobe: Dataset, lobe_truth: Truth) -> None:
    found = lobe.distributions[0].integrals
    direction = unit_from_angles_deg(found["peak mirror theta_deg"], found["peak mirror phi_deg"])
    off_deg = float(angle_between_deg(direction, unit_from_angles_deg(30.0, 180.0)))
    sigma = lobe_truth.peak_sigma_deg(1.2)
    FIGURES.info(
        "direction off %.5f deg, integral %+.2e, sigma %+.2e of %.4f deg",
        off_deg,
        found["peak mirror integral"] / 0.2 - 1.0,
        found["peak mirror sigma_deg"] / sigma - 1.0,
        sigma,
    )
    assert off_deg < 0.01
    assert found["peak mirror integral"] == pytest.approx(0.2, rel=5e-3)
    assert found["peak mirror sigma_deg"] == pytest.approx(sigma, rel=1e-2)


def test_every_point_is_the_truth_within_its_uncertainty(lobe: Dataset, lobe_truth: Truth) -> None:
    """Chi-square of the residuals, over both gains and the blend between them."""
    d = lobe.distributions[0]
    truth = lobe_truth.dsf_per_sr(30.0, 0.0, unit_from_angles_deg(d.theta_deg, d.phi_deg))
    used = d.measured
    # P_i and the positions are common to many points: their share is added here, not in the points' own variance.
    gradient = np.abs(truth) * 3.0 * 0.0005  # per degree, at most 3 / sigma^2 of an error of half a count
    variance = d.variance_per_sr2[used] + (2e-4 * truth[used]) ** 2 + gradient[used] ** 2
    chi2 = (d.dsf_per_sr[used] - truth[used]) ** 2 / variance
    FIGURES.info("mean chi2 %.3f, largest %.1f of %d", chi2.mean(), chi2.max(), used.sum())
    assert 0.7 < chi2.mean() < 1.2
    assert chi2.max() < 40.0
    noise = lobe.provenance["noise"]
    assert noise["dark_counts_rms"] == pytest.approx([8.0, np.sqrt(0.25 + 1 / 12)], rel=0.06)
    assert noise["shot_variance_per_count"] == pytest.approx(0.001, rel=0.2)
    assert noise["monitor_variance_rel"] == pytest.approx((200.0 / 4e6) ** 2, rel=0.1)


def test_dataset_survives_hdf5_with_its_provenance(lobe: Dataset, tmp_path: Path) -> None:
    write_dataset(lobe, tmp_path / "a.h5")
    back = read_dataset(tmp_path / "a.h5")
    assert back.provenance == lobe.provenance
    assert back.distributions[0].integrals == lobe.distributions[0].integrals
    assert back.sample_name == "synthetic"
    names = [step["name"] for step in back.provenance["corrections"]]
    assert names[2:9] == ["dark", "gain", "linearity", "lamp", "distance", "stray_light", "masks"]
    assert back.distributions[0].budgets == lobe.distributions[0].budgets
    assert back.distributions[0].effects.keys() == lobe.distributions[0].effects.keys()
    np.testing.assert_array_equal(back.distributions[0].flags, lobe.distributions[0].flags)


def test_shadowed_points_are_masked_and_nothing_else_is_dark(lobe: Dataset) -> None:
    d = lobe.distributions[0]
    from_source_deg = angle_between_deg(unit_from_angles_deg(d.theta_deg, d.phi_deg), unit_from_angles_deg(30.0, 0.0))
    shadowed = d.flags & PointFlag.SHADOWED != 0
    np.testing.assert_array_equal(shadowed, from_source_deg < lobe.provenance["shade_angle_deg"])
    np.testing.assert_array_equal(np.isnan(d.dsf_per_sr), shadowed)


def test_losses_leave_flags_and_no_wrong_value(lobe_log: RawLog, lobe: Dataset) -> None:
    """A lost SYNC, a drive that misses one, a hole in both streams: fewer or flagged points, all others unchanged."""
    log = RawLog(**{**vars(lobe_log)})
    log.poses = lobe_log.poses.copy()
    middle = len(log.poses) // 2
    log.poses["valid"][middle] = 0b1110
    keep = np.ones(len(log.poses), dtype=bool)
    keep[middle + 500] = False
    keep[middle + 1000 : middle + 1010] = False
    log.poses, log.pose_segment = log.poses[keep], log.pose_segment[keep]
    kept = np.ones(len(log.samples), dtype=bool)
    kept[len(kept) // 2 : len(kept) // 2 + 50] = False
    for name in ("samples", "sample_number", "sample_time_ns", "sample_settled", "sample_segment"):
        setattr(log, name, getattr(lobe_log, name)[kept])
    found, whole = reduce_rawlog(log).distributions[0], lobe.distributions[0]
    assert np.count_nonzero(found.flags & PointFlag.INTERPOLATED_POSE) > 8
    assert reduce_rawlog(log).provenance["counters"]["points_pose_lost"] >= 20
    _, mine, theirs = np.intersect1d(found.time_ns, whole.time_ns, return_indices=True)
    assert len(mine) > 0.9 * len(whole.time_ns)
    off_deg = angle_between_deg(
        unit_from_angles_deg(found.theta_deg, found.phi_deg)[mine],
        unit_from_angles_deg(whole.theta_deg, whole.phi_deg)[theirs],
    )
    assert off_deg.max() < 0.002
    unflagged = found.flags[mine] & PointFlag.INTERPOLATED_POSE == 0
    assert off_deg[unflagged].max() < 1e-9


def test_a_scan_in_two_segments_joins_seamlessly(lobe_log: RawLog, lobe: Dataset) -> None:
    """Cut in the middle of the peak's spiral; the second segment has another clock and begins with the same path."""
    cut_ns = int(np.median(lobe.distributions[0].time_ns[-4000:]))
    shift_ns = 5_000_000_000_000
    log = RawLog(**vars(lobe_log))
    log.segments = [lobe_log.segments[0], lobe_log.segments[0]]
    log.sample_segment = (lobe_log.sample_time_ns > cut_ns).astype(np.int32)
    log.sample_time_ns = lobe_log.sample_time_ns + shift_ns * log.sample_segment.astype(np.int64)
    around = np.abs(lobe_log.poses["sync_time_ns"] - cut_ns) < 20_000_000
    first = lobe_log.poses[(lobe_log.poses["sync_time_ns"] <= cut_ns) | around].copy()
    second = lobe_log.poses[(lobe_log.poses["sync_time_ns"] > cut_ns) | around].copy()
    second["sync_time_ns"] += shift_ns
    log.poses = np.concatenate((first, second))
    log.pose_segment = np.repeat(np.arange(2, dtype=np.int32), [len(first), len(second)])
    peak_id = lobe_log.metadata["paths"][-1]["path_id"]
    before = [e for e in lobe_log.events if e.time_ns <= cut_ns]
    resumed = pb.Event(time_ns=cut_ns + shift_ns, path=pb.PathState(path_id=peak_id, end=pb.PATH_RUNNING))
    opened = pb.SetOutput(output=pb.OUTPUT_SHUTTER, on=True)
    after = [pb.Event(time_ns=cut_ns + shift_ns, output=opened), resumed]
    for event in lobe_log.events[len(before) :]:
        later = pb.Event()
        later.CopyFrom(event)
        later.time_ns += shift_ns
        after.append(later)
    log.events, log.event_segment = before + after, [0] * len(before) + [1] * len(after)
    joined = reduce_rawlog(log).distributions[0]
    whole = lobe.distributions[0]
    np.testing.assert_array_equal(joined.theta_deg, whole.theta_deg)
    np.testing.assert_array_equal(joined.phi_deg, whole.phi_deg)
    difference = np.abs(joined.dsf_per_sr - whole.dsf_per_sr)[whole.measured]
    assert (
        difference <= 3.0 * np.sqrt(whole.variance_per_sr2[whole.measured]) + 1e-3 * whole.dsf_per_sr[whole.measured]
    ).all()
    for key in ("rho_measured", "peak mirror integral", "peak mirror sigma_deg"):
        assert joined.integrals[key] == pytest.approx(whole.integrals[key], rel=1e-3)


def test_binning_keeps_integral_and_lowers_noise(lobe_log: RawLog, lobe: Dataset) -> None:
    found = reduce_rawlog(lobe_log, ReduceOptions(bin_deg=0.3)).distributions[0]
    whole = lobe.distributions[0]
    assert len(found.theta_deg) < 0.6 * len(whole.theta_deg)
    assert found.count.sum() == whole.count.sum()
    assert found.integrals["rho_estimate"] == pytest.approx(whole.integrals["rho_estimate"], rel=1e-3)
    uncovered = found.integrals["uncovered_sr_front"] + found.integrals["uncovered_sr_back"]
    np.testing.assert_allclose(found.solid_angle_sr.sum() + uncovered, 4.0 * np.pi, rtol=1e-9)
    assert np.nanmedian(found.variance_per_sr2[found.count > 5]) < 0.3 * np.median(
        whole.variance_per_sr2[whole.measured]
    )


def test_unreachable_directions_are_masked_points(lobe_log: RawLog) -> None:
    log = RawLog(**vars(lobe_log))
    entry = {"incident_theta_deg": 30.0, "incident_phi_deg": 0.0, "theta_deg": 170.0, "phi_deg": 12.0, "reason": "zone"}
    log.metadata = {**lobe_log.metadata, "unreachable": [entry, {**entry, "incident_theta_deg": 60.0}]}
    d = reduce_rawlog(log).distributions[0]
    index = np.flatnonzero(d.flags & PointFlag.UNREACHABLE)
    assert len(index) == 1
    assert np.isnan(d.dsf_per_sr[index[0]])
    assert (d.theta_deg[index[0]], d.phi_deg[index[0]]) == pytest.approx((170.0, 12.0))
    assert d.solid_angle_sr[index[0]] > 0.0
    assert d.integrals["masked_sr_back"] == pytest.approx(d.solid_angle_sr[index[0]])


def test_a_beam_with_few_turns_across_it_is_noted(lobe: Dataset, lobe_truth: Truth) -> None:
    """Half maximum of a top hat of 1 degree behind an aperture as wide: 0.95 degrees, two turns of 0.5 degrees."""
    scan = Scan(lobe_truth)
    scan.dark()
    scan.reference(1.6, 0.5)
    scan.peak((30.0, 0.0), 6.0, 0.3)
    notes = reduce_rawlog(scan.log()).provenance["notes"]
    assert any(re.search(r"(1\.9|2\.0) turns", note) and "[reference] pitch_deg" in note for note in notes), notes
    assert not any("reference spiral" in note for note in lobe.provenance["notes"])


def test_logs_that_cannot_be_reduced_say_why(lobe_log: RawLog) -> None:
    def without(*kinds: str, **changes: object) -> RawLog:
        log = RawLog(**{**vars(lobe_log), **changes})
        paths = [path for path in lobe_log.metadata["paths"] if path["kind"] not in kinds]
        log.metadata = {**log.metadata, "paths": paths}
        return log

    with pytest.raises(UsageError, match=r"no reference scan.*--p-i VALUE.*--beam OTHER"):
        reduce_rawlog(without("reference"))
    with pytest.raises(UsageError, match="no sample of a coarse or peak path"):
        reduce_rawlog(without("coarse", "peak"))
    light = [e for e in lobe_log.events if e.WhichOneof("body") != "output"]
    with pytest.raises(UsageError, match="shutter closed"):
        reduce_rawlog(without(events=light, event_segment=[0] * len(light)))
    blind = lobe_log.samples.copy()
    blind["monitor_counts"] = 0
    with pytest.raises(UsageError, match="lamp monitor reads 0"):
        reduce_rawlog(without(samples=blind))


def test_imported_points_get_cells_and_integrals(lobe: Dataset, lobe_truth: Truth) -> None:
    """A Fibonacci lattice of the front hemisphere with the truth on it, as if read from a file."""
    n = 20_000
    z = (np.arange(n) + 0.5) / n
    phi = np.arange(n) * 180.0 * (3.0 - np.sqrt(5.0))
    theta_deg = np.degrees(np.arccos(z))
    unit = unit_from_angles_deg(theta_deg, phi)
    d = lobe.distributions[0]
    source = type(d)(
        incident_theta_deg=30.0,
        incident_phi_deg=0.0,
        theta_deg=theta_deg,
        phi_deg=phi % 360.0,
        dsf_per_sr=lobe_truth.dsf_per_sr(30.0, 0.0, unit),
        variance_per_sr2=np.zeros(n),
        signal=np.zeros(n),
        normalisation=np.ones(n),
        count=np.ones(n, dtype=np.int32),
        flags=np.zeros(n, dtype=np.uint16),
        solid_angle_sr=np.zeros(n),
        time_ns=np.zeros(n, dtype=np.int64),
    )
    found = reduce_dataset(Dataset([source])).distributions[0]
    assert found.solid_angle_sr.sum() == pytest.approx(2.0 * np.pi, rel=2e-3)  # the outermost lie inside the horizon
    # Points 1 degree apart across a lobe of 2.9 degrees: what that costs is stated.
    assert found.integrals["rho_estimate"] == pytest.approx(0.5, abs=2.0 * found.integrals["rho_u"])
    assert found.integrals["rho_voronoi"] == pytest.approx(0.5, rel=2e-3)
    assert "tau_estimate" not in found.integrals  # no value where nothing was measured
    assert found.integrals["measured_share_front"] == pytest.approx(1.0, rel=2e-3)
    assert found.integrals["measured_cosine_share_front"] == pytest.approx(1.0, rel=1e-3)
    assert found.integrals["rho_u"] == pytest.approx(found.integrals["rho_quadrature"])  # nothing else is known


def test_a_peak_that_is_masked_or_absent_is_not_measured(lobe: Dataset) -> None:
    d = lobe.distributions[0]
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)[-3000:]
    dsf = d.dsf_per_sr[-3000:]
    assert measure_peak(unit, dsf, np.zeros(3000, dtype=bool)) is None
    assert measure_peak(unit, -np.abs(dsf), np.ones(3000, dtype=bool)) is None
    assert measure_peak(unit[:10], dsf[:10], np.ones(10, dtype=bool)) is None
    single = np.zeros(3000)
    single[100] = 5.0
    assert measure_peak(unit, single, np.ones(3000, dtype=bool)) is None
