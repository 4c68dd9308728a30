"""test_plan_schema.py: plan files: what is read, and the sentence for everything that is wrong."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gonio.plan.schema import load_plan, parse_plan
from gonio.units.errors import UsageError

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"
SCAN = "[scan]\nincident = [[0, 0], [30, 0]]\n"
COARSE = "[coarse]\n"


def test_demo_plan() -> None:
    plan = load_plan(EXAMPLES / "demo.toml")
    assert plan.scan.incident == ((0.0, 0.0), (30.0, 0.0), (60.0, 0.0))
    assert plan.coarse is not None
    assert plan.coarse.pitch_deg == 6.0
    assert [peak.about for peak in plan.peaks] == ["mirror", "through"]
    assert plan.text == (EXAMPLES / "demo.toml").read_text()


def test_defaults() -> None:
    plan = parse_plan(SCAN + COARSE, "p.toml")
    assert plan.sample.front_faces == "undeclared"
    assert plan.sample.thickness_mm is None
    assert plan.beam.kind == "collimated"
    assert plan.beam.diameter_mm == 65.0
    assert plan.reference is None
    assert plan.dark_s == 1.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (SCAN + "[coarse]\npitch = 6\n", "p.toml: coarse.pitch is unknown; known are pitch_deg, sphere"),
        ("colour = 1\n" + SCAN + COARSE, "p.toml: colour is unknown; known are sample, beam"),
        (SCAN, "p.toml: coarse and [[peak]] are both missing: there is nothing to measure"),
        (COARSE, "p.toml: scan is missing"),
        (COARSE + "[scan]\n", "p.toml: scan.incident is None: a list of [theta, phi] expected"),
        (COARSE + "[scan]\nincident = [[200, 0]]\n", "p.toml: scan.incident has [200, 0]: [theta 0 to 180"),
        (COARSE + "[scan]\nincident = [[0, 0], [0, 360]]\n", "p.toml: scan.incident names a direction twice"),
        (COARSE + SCAN + "speed_deg_per_s = true\n", "p.toml: scan.speed_deg_per_s is True: a number from 0.1"),
        (SCAN + "[coarse]\npitch_deg = nan\n", "p.toml: coarse.pitch_deg is nan: a number from 0.1 to 30 degrees"),
        (SCAN + "[coarse]\nsphere = 'left'\n", "p.toml: coarse.sphere is 'left': one of whole, front, back expected"),
        (SCAN + "[[peak]]\nabout = 'up'\n", "p.toml: peak[0].about is 'up': one of mirror, retro, through expected"),
        (SCAN + "[[peak]]\nabout = 'mirror'\nradius_deg = 1\n", "p.toml: peak[0].pitch_deg is missing"),
        (SCAN + "[reference]\nradius_deg = 1\npitch_deg = 2\n" + COARSE, "p.toml: reference.radius_deg is 1: at least"),
        (
            SCAN + "[[peak]]\nabout = 'mirror'\nradius_deg = 1\npitch_deg = 0.1\nfor_incident = [[45, 0]]\n",
            "p.toml: peak[0].for_incident has [45, 0], which scan.incident has not",
        ),
        (SCAN + "[sinusoid]\n", "p.toml: scan does not go with [sinusoid]"),
        ("[scan\n", "p.toml: not TOML (Expected"),
        (SCAN + COARSE + "[sample]\nname = 3\n", "p.toml: sample.name must be one line of text"),
        (
            SCAN + COARSE + "[dark]\nduration_s = 0\n",
            "p.toml: dark.duration_s is 0: a number from 0.05 to 600 s expected",
        ),
    ],
)
def test_every_mistake_is_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_plan(text, "p.toml")
    assert str(caught.value).startswith(sentence)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"nowhere.toml: cannot read the plan"):
        load_plan(tmp_path / "nowhere.toml")


@given(st.text(alphabet="[]={}\"'\n.,0123456789abcdeinfsranpkop_", max_size=80))
def test_any_text_is_a_plan_or_one_sentence(text: str) -> None:
    try:
        parse_plan(text, "p.toml")
    except UsageError as error:
        assert "\n" not in str(error)  # noqa: PT017 - a plan is a good outcome too
