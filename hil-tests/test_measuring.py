"""test_measuring.py: home, step scan and fly scan against the virtual-time run of the same seed."""

import json

import pytest

from harness.results import Result


@pytest.mark.scenario("home")
def test_home_finds_every_position(result: Result) -> None:
    before, after = (json.loads(result.command(name).stdout) for name in ("info-before", "info-after"))
    assert before["state"] == "unconfigured"
    assert after["state"] == "ready"
    home = result.command("home")
    assert (home.status, home.stderr) == (0, "")
    told = [float(line.rpartition(": ")[2].removesuffix(" deg")) for line in home.stdout.splitlines()]
    assert told == pytest.approx(result.state("homed")["position_deg"], abs=0.01)
