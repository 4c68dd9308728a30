"""test_arm64_twin.py: level 1 on another processor: firmware core and twin, built for arm64, run under qemu-user and
measure what they measure here; and the arm64 goniod checks itself."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from twin_runs import PLAN, QUIET, SCENARIOS, run

from gonio.dataset.bsdf import Distribution
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import RawLog, read_rawlog
from gonio.reduce.pipeline import reduce_rawlog

ROOT = Path(__file__).resolve().parents[3]
CROSS = ROOT / "build" / "cross" / "arm64"
TWIN = CROSS / "build" / "sim" / "gonio-l1"
GONIOD = CROSS / "build" / "firmware" / "app" / "goniod"
QEMU = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")
SELF_TEST_S = 60.0
# A smaller plan than elsewhere: an emulated processor is ten times slower.
SMALL_PLAN = PLAN.replace("pitch_deg = 12.0", "pitch_deg = 20.0")
NOISY = """
seed = 4
[sample]
components = [{ kind = "lambertian", reflectance = 0.5 }]
[detector]
noise_counts_rms = [8.0, 0.5]
dark_counts = [350.0, 12.0]
[timing]
sync_jitter_us = 50.0
strobe_latency_us = 20.0
"""

pytestmark = [
    pytest.mark.twin,
    pytest.mark.skipif(QEMU is None, reason="qemu-aarch64-static is not installed (make cross brings it)"),
    pytest.mark.skipif(not TWIN.exists(), reason="gonio-l1 is not built for arm64 (make cross builds it)"),
]


@pytest.fixture(scope="module")
def arm64_twin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program that runs the arm64 twin here."""
    wrapper = tmp_path_factory.mktemp("arm64") / "gonio-twin"
    wrapper.write_text(f'#!/bin/sh\nexec "{QEMU}" -L "{CROSS / "sysroot"}" "{TWIN}" "$@"\n')
    wrapper.chmod(0o755)
    return wrapper


def scan_with(
    folder: Path, twin: Path | None, scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[int, str, RawLog]:
    """Scan with a twin (None: this machine's): exit status, standard error, the log."""
    folder.mkdir()
    (folder / "plan.toml").write_text(SMALL_PLAN)
    with monkeypatch.context() as patch:
        if twin is not None:
            patch.setenv("GONIO_TWIN", str(twin))
        status, _, err = run(
            folder, "scan", folder / "plan.toml", "-o", folder / "raw.mcap", "--device", f"twin:{scenario}"
        )
    return status, err, read_rawlog([folder / "raw.mcap"])


def scan_on_both(
    folder: Path, twin: Path, scenario: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[tuple[int, str, RawLog], tuple[int, str, RawLog]]:
    """The same scan here and on arm64."""
    return (
        scan_with(folder / "here", None, scenario, monkeypatch),
        scan_with(folder / "arm64", twin, scenario, monkeypatch),
    )


def assert_same_distribution(here: Distribution, there: Distribution) -> None:
    """The same directions with the same values: the seeds are the same, so that noise is no excuse; functions of the
    C library may round a count otherwise."""
    assert here.measured.sum() > 50
    np.testing.assert_array_equal(here.flags, there.flags)
    np.testing.assert_allclose(there.theta_deg, here.theta_deg, atol=1e-3)
    good = here.measured
    deviation = np.abs(there.dsf_per_sr[good] - here.dsf_per_sr[good])
    assert np.all(deviation <= 5.0 * np.sqrt(here.variance_per_sr2[good]) + 1e-4 * here.dsf_per_sr[good])
    assert there.p_i == pytest.approx(here.p_i, rel=1e-4)


@pytest.mark.parametrize("text", [QUIET, NOISY], ids=["quiet", "noisy"])
def test_a_scan_reduces_to_the_same_dsf(
    tmp_path: Path, arm64_twin: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(text)
    here, there = scan_on_both(tmp_path, arm64_twin, scenario, monkeypatch)
    assert (here[0], there[0]) == (0, 0), there[1]
    assert len(there[2].sample_number) == len(here[2].sample_number)
    assert np.all(np.diff(there[2].sample_number.astype(np.int64)) == 1), "nothing is lost"
    (one,), (other,) = reduce_rawlog(here[2]).distributions, reduce_rawlog(there[2]).distributions
    assert_same_distribution(one, other)


def test_a_fault_ends_in_the_same_sentence(tmp_path: Path, arm64_twin: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there = scan_on_both(tmp_path, arm64_twin, SCENARIOS / "fault_door.toml", monkeypatch)
    assert (here[0], there[0]) == (3, 3), there[1]
    faults = [[e.fault.sentence for e in log.events if e.HasField("fault")] for _, _, log in (here, there)]
    assert faults[0] == faults[1] != []
    states = [e.status.state for e in there[2].events if e.HasField("status")]
    assert states[-1] == pb.STATE_FAULT


def test_losses_are_counted_alike(tmp_path: Path, arm64_twin: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there = scan_on_both(tmp_path, arm64_twin, SCENARIOS / "fault_losses.toml", monkeypatch)
    assert (here[0], there[0]) == (0, 0), there[1]
    counters = [[e.counters for e in log.events if e.HasField("counters")][-1] for _, _, log in (here, there)]
    assert counters[0] == counters[1]
    assert counters[1].samples_lost > 0
    assert counters[1].strobes_lost > 0


def test_goniod_checks_itself() -> None:
    if not GONIOD.exists():
        pytest.skip("goniod is not built for arm64 (make cross builds it)")
    done = subprocess.run(
        [str(QEMU), "-L", str(CROSS / "sysroot"), str(GONIOD), "--self-test"],
        capture_output=True,
        text=True,
        timeout=SELF_TEST_S,
        check=False,
        env=os.environ,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 7
    assert all(line.startswith("good ") for line in lines[1:])
