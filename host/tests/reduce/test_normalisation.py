"""test_normalisation.py: P_i declared or of another scan, corrections left out, reductions that can be repeated."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from synthetic_scan import POWER_COUNTS, Scan

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.nexus import read_dataset, read_provenance, write_dataset
from gonio.dataset.nexus_entry import three_digits
from gonio.geometry.directions import unit_from_angles_deg
from gonio.protocol.generated.records import SAMPLE_BLOCK_DTYPE, SAMPLE_BLOCK_STROBE_REJECTED
from gonio.rawlog.reader import RawLog
from gonio.reduce.options import OtherBeam, ReduceOptions
from gonio.reduce.pipeline import reduce_rawlog
from gonio.simulate.closed_form import Truth
from gonio.units.errors import UsageError

SCENARIO = """
[sample]
components = [{kind="gaussian", about="mirror", sigma_deg=1.2, integral=0.2}, {kind="lambertian", reflectance=0.3}]
[beam]
kind = "focused"
divergence_deg = 1.0
edge_deg = 0.1
"""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> RawLog:
    """Reference and a spiral about the mirror direction at 75 degrees, which runs over the horizon: grazing light, and
    nothing but noise behind."""
    scenario = tmp_path_factory.mktemp("truth") / "s.toml"
    scenario.write_text(SCENARIO)
    scan = Scan(Truth.from_scenario(scenario))
    scan.dark()
    scan.reference()
    scan.fly_spiral("peak", "grazing", (88.0, 180.0), (75.0, 0.0), 4.0, 0.4)
    scan.dark()
    return scan.log()


@pytest.fixture(scope="module")
def reduced(log: RawLog) -> Dataset:
    return reduce_rawlog(log)


def without_reference(log: RawLog) -> RawLog:
    paths = [path for path in log.metadata["paths"] if path["kind"] != "reference"]
    return replace(log, metadata={**log.metadata, "paths": paths})


def assert_identical(a: Distribution, b: Distribution) -> None:
    for field in fields(Distribution):
        left, right = getattr(a, field.name), getattr(b, field.name)
        if isinstance(left, dict):
            assert left.keys() == right.keys()
            for key in left:
                np.testing.assert_equal(left[key], right[key], err_msg=f"{field.name} {key}")
        else:
            np.testing.assert_array_equal(left, right, err_msg=field.name)


def test_the_same_raw_log_gives_the_same_dataset_and_says_how(log: RawLog, reduced: Dataset, tmp_path: Path) -> None:
    again = reduce_rawlog(log)
    assert again.provenance == reduced.provenance
    assert_identical(again.distributions[0], reduced.distributions[0])
    assert again.beam is not None
    assert reduced.beam is not None
    assert_identical(again.beam, reduced.beam)
    options = ReduceOptions(without=("lamp",), reach_factor=2.0, calibration_text="[calibration]\ntilt_u_deg = 0.5\n")
    other = reduce_rawlog(log, options)
    write_dataset(other, tmp_path / "a.h5")
    found = read_provenance(tmp_path / "a.h5")
    assert found["raw_sha256"] == log.sha256s
    assert ReduceOptions(**{**found["options"], "without": tuple(found["options"]["without"])}) == options
    assert found["versions"]["gonio"]
    assert found["instrument_text"] == log.metadata["instrument"]
    assert_identical(read_dataset(tmp_path / "a.h5").distributions[0], _stored(other))


def _stored(dataset: Dataset) -> Distribution:
    """Effects in the precision of the file."""
    first = dataset.distributions[0]
    return replace(first, effects={key: three_digits(column).astype("f8") for key, column in first.effects.items()})


def test_noise_keeps_its_sign_and_grazing_light_its_value(reduced: Dataset) -> None:
    d = reduced.distributions[0]
    behind = d.measured & (d.theta_deg > 90.5)
    # White noise about nothing: half of it negative, with the spread that is stated.
    assert np.count_nonzero(behind) > 1000
    assert np.mean(d.dsf_per_sr[behind] < 0.0) == pytest.approx(0.5, abs=0.06)
    assert np.mean(d.dsf_per_sr[behind]) == pytest.approx(0.0, abs=5e-6)
    pull = d.dsf_per_sr[behind] / np.sqrt(d.variance_per_sr2[behind])
    assert np.std(pull) == pytest.approx(1.0, abs=0.1)
    assert (d.flags[behind] & PointFlag.LOW_SIGNAL != 0).mean() > 0.95
    grazing = d.measured & (d.theta_deg > 88.0) & (d.theta_deg < 89.0)
    assert (d.dsf_per_sr[grazing] > 0.0).all()
    assert not (d.flags[grazing] & PointFlag.LOW_SIGNAL).any()


def test_a_declared_p_i_normalises_a_scan_without_reference(log: RawLog, reduced: Dataset) -> None:
    options = ReduceOptions(p_i=POWER_COUNTS, p_i_u=15.0)
    found = reduce_rawlog(without_reference(log), options)
    d, whole = found.distributions[0], reduced.distributions[0]
    assert (d.p_i, d.p_i_u_rel) == (POWER_COUNTS, pytest.approx(0.01))
    assert found.beam is None
    ratio = (d.dsf_per_sr / whole.dsf_per_sr)[whole.dsf_per_sr > 0.1]
    assert ratio == pytest.approx(1.0, rel=0.01)  # the lamp's drift between the scans
    np.testing.assert_allclose(d.effects["p_i"][d.measured], -0.01 * d.dsf_per_sr[d.measured])
    assert any(step["what"] == "P_i as declared" for step in found.provenance["corrections"])


def test_the_beam_of_another_scan_gives_the_same_result(log: RawLog, reduced: Dataset) -> None:
    other = OtherBeam("morning.h5", reduced.provenance["beam"])
    found = reduce_rawlog(without_reference(log), None, other)
    d, whole = found.distributions[0], reduced.distributions[0]
    # Shot noise is estimated from all paths of a scan: variances differ a little, values do not at all.
    np.testing.assert_allclose(d.dsf_per_sr, whole.dsf_per_sr, rtol=1e-12)
    assert d.p_i_u_rel == whole.p_i_u_rel
    assert "morning.h5" in found.provenance["beam"]["what"]
    assert not any("not used" in note for note in found.provenance["notes"])


def test_p_i_is_refused_where_it_means_nothing(log: RawLog) -> None:
    bare = without_reference(log)
    with pytest.raises(UsageError, match="give one of them"):
        reduce_rawlog(bare, ReduceOptions(p_i=1.0), OtherBeam("a.h5", {}))
    with pytest.raises(UsageError, match=r"a\.h5: holds no free beam"):
        reduce_rawlog(bare, None, OtherBeam("a.h5", {"p_i": 3.0}))
    for options in ({"p_i": -1.0}, {"p_i": float("nan")}, {"p_i_u": 1.0}, {"reach_factor": 0.0}):
        with pytest.raises(UsageError, match="--"):
            ReduceOptions(**options)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match=r"--without drak: no such correction; there are dark, gain"):
        reduce_rawlog(log, ReduceOptions(without=("drak",)))


def test_each_correction_can_be_left_out_and_does_what_it_says(log: RawLog, reduced: Dataset) -> None:
    whole = reduced.distributions[0]
    calibration = """
[calibration]
nonlinearity = 0.01
sample_offset_mm = 5.0
stray_light_per_sr = 1e-3
"""
    everything = reduce_rawlog(log, ReduceOptions(calibration_text=calibration)).distributions[0]

    def changed(name: str) -> tuple[Distribution, Distribution]:
        options = ReduceOptions(calibration_text=calibration, without=(name,))
        dataset = reduce_rawlog(log, options)
        states = {step["name"]: step["applied"] for step in dataset.provenance["corrections"]}
        assert [key for key, applied in states.items() if not applied] == [name]
        return everything, dataset.distributions[0]

    with_dark, no_dark = changed("dark")
    # 350 counts of the high gain and some of drift: 0.35 of the low one and 2 % for the distance.
    off = np.median((no_dark.signal - with_dark.signal)[with_dark.theta_deg > 90.5])
    assert off == pytest.approx(0.36, rel=0.02)
    with_lamp, no_lamp = changed("lamp")
    assert (no_lamp.normalisation == 1.0).all()
    assert with_lamp.normalisation.std() > 0.0
    with_stray, no_stray = changed("stray_light")
    np.testing.assert_allclose((no_stray.dsf_per_sr - with_stray.dsf_per_sr)[with_stray.measured], 1e-3, rtol=1e-6)
    with_offset, no_offset = changed("distance")
    moved = unit_from_angles_deg(with_offset.theta_deg, with_offset.phi_deg)
    arm = unit_from_angles_deg(no_offset.theta_deg, no_offset.phi_deg)
    assert np.abs(moved - arm).max() > 1e-3
    np.testing.assert_array_equal(no_offset.theta_deg, whole.theta_deg)
    with_bend, no_bend = changed("linearity")
    bright = no_bend.signal > 100.0
    assert (with_bend.signal[bright] != no_bend.signal[bright]).all()
    _, low_only = changed("gain")
    faint = low_only.theta_deg > 90.5
    assert np.nanmedian(low_only.variance_per_sr2[faint]) > 100.0 * np.nanmedian(everything.variance_per_sr2[faint])


def test_samples_beside_a_lost_strobe_are_flagged(log: RawLog, reduced: Dataset) -> None:
    n = len(log.samples)
    blocks = np.zeros(-(-n // 100), dtype=SAMPLE_BLOCK_DTYPE)
    blocks["count"] = np.minimum(100, n - 100 * np.arange(len(blocks)))
    middle = len(blocks) * 3 // 4
    blocks["strobes_lost"][middle:] = 1  # counted from here on
    blocks["flags"][middle + 5] = SAMPLE_BLOCK_STROBE_REJECTED
    found = reduce_rawlog(replace(log, sample_blocks=blocks)).distributions[0]
    flagged = np.flatnonzero(found.flags & PointFlag.STROBE_LOST)
    assert len(flagged) == 200
    assert found.measured[flagged].all()
    whole = reduced.distributions[0]
    np.testing.assert_array_equal(found.dsf_per_sr, whole.dsf_per_sr)
    assert not (whole.flags & PointFlag.STROBE_LOST).any()
