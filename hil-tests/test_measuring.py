"""test_measuring.py: home, step scan and fly scan against the virtual-time run of the same seed."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from gonio.reduce.pipeline import reduce_rawlog

from harness.checks import assert_nothing_lost, raw_log
from harness.results import Result
from harness.rig import Rig
from harness.session import ROOT

LEAST_FLOWN = 20_000


def assert_as_in_virtual_time(result: Result, rig: Rig, plan: str, folder: Path) -> None:
    """The same light within noise, incident direction by incident direction: means over the measured points. P_i, from
    so short a reference scan, agrees within what both say of it."""
    raw = folder / "virtual.mcap"
    command = [str(ROOT / ".venv/bin/gonio"), "scan", str(rig.folder / plan), "-o", str(raw)]
    command += ["--device", f"twin:{rig.folder / 'twin.toml'}", "--instrument", str(rig.file("instrument"))]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ)
    assert done.returncode == 0, done.stderr
    ours, theirs = (reduce_rawlog(raw_log(path)).distributions for path in (result.raw(), raw))
    assert len(ours) == len(theirs)
    for real, virtual in zip(ours, theirs, strict=True):
        a, b = (d.p_i * d.dsf_per_sr[d.measured] for d in (real, virtual))
        assert len(a) == pytest.approx(len(b), rel=0.05)
        noise = np.hypot(a.std() / np.sqrt(len(a)), b.std() / np.sqrt(len(b)))
        assert abs(a.mean() - b.mean()) <= 5.0 * noise
        assert abs(real.p_i - virtual.p_i) <= 2.0 * np.hypot(real.p_i * real.p_i_u_rel, virtual.p_i * virtual.p_i_u_rel)


@pytest.mark.scenario("home")
def test_home_finds_every_position(result: Result) -> None:
    assert json.loads(result.command("info-after").stdout)["state"] == "ready"
    home = result.command("home")
    assert (home.status, home.stderr) == (0, "")
    told = [float(line.rpartition(": ")[2].removesuffix(" deg")) for line in home.stdout.splitlines()]
    assert told == pytest.approx(result.state("homed")["position_deg"], abs=0.01)


@pytest.mark.scenario("home")
def test_installed_command_answers(result: Result) -> None:
    installed = result.values["installed_gonio"]
    assert installed["status"] == 0, installed["stderr"]
    assert json.loads(installed["stdout"])["state"] == "ready"


@pytest.mark.scenario("step_scan")
def test_step_scan_is_the_virtual_one(result: Result, rig: Rig, tmp_path: Path) -> None:
    assert result.command("raw").status == 0, result.command("raw").stderr
    assert_nothing_lost(result.raw())
    assert_as_in_virtual_time(result, rig, "step.toml", tmp_path)


@pytest.mark.scenario("fly_scan")
def test_fly_scan_is_the_virtual_one(result: Result, rig: Rig, tmp_path: Path) -> None:
    assert result.command("raw").status == 0, result.command("raw").stderr
    assert_nothing_lost(result.raw())
    assert len(raw_log(result.raw()).sample_number) >= LEAST_FLOWN
    assert_as_in_virtual_time(result, rig, "fly.toml", tmp_path)
