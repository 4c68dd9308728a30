"""test_limits.py: cable wrap in a spiral, an axis with the wrong sign."""

import pytest

from harness.checks import complaints
from harness.results import Result


@pytest.mark.scenario("cable_wrap")
def test_spiral_stays_inside_the_cable_wrap(result: Result) -> None:
    assert result.command("inside").status == 0, result.command("inside").stderr
    beyond = result.command("beyond")
    assert beyond.status == 2
    assert "its limit is -70" in complaints(beyond)[0]
    assert result.state("after")["position_deg"] == pytest.approx(result.state("safe")["position_deg"], abs=0.01)


@pytest.mark.scenario("wrong_sign")
def test_wrong_sign_is_found_before_anything_moves(result: Result) -> None:
    home = result.command("home")
    assert home.status in (2, 3)
    assert "check the sign of counts_per_deg" in complaints(home)[0]
    assert result.command("recovery").status == 0, result.command("recovery").stderr
