"""test_instrument.py: the reference instrument's values, and an instrument file with something wrong in it."""

from fractions import Fraction
from pathlib import Path

import pytest

from gonio.units.errors import CheckFailed, InstrumentFault, UsageError
from gonio.units.instrument import load_instrument, parse_instrument


def test_reference_instrument() -> None:
    """Against the figures of the design: 400,000 counts per turn, r = 1020 mm, 500 Hz, 1 kHz."""
    instrument = load_instrument(None)
    assert instrument.arm_radius_mm == 1020.0
    assert instrument.cycle.sync_period_us == 2000
    assert instrument.cycle.sample_period_us == 1000
    assert [axis.node for axis in instrument.axes] == [1, 2, 3, 4]
    for axis in instrument.axes:
        assert axis.counts_per_deg * 360.0 == axis.counts_per_turn == 400_000
        assert axis.counts_per_deg_ratio == Fraction(10_000, 9)
    assert [axis.carries for axis in instrument.axes] == ["sample", "sample", "detector", "detector"]
    assert instrument.axes[3].homing.switch_deg == -85.0
    assert instrument.zones[0].half_spaces[1].b == -78.0
    assert [channel.gain for channel in instrument.channels] == [1000.0, 1.0]


REFERENCE = load_instrument(None).text


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("[cycle]", "[cycle]\nspeed = 3", r"cycle\.speed is unknown"),
        ("[instrument]", "[machine]\n[instrument]", "machine is unknown"),
        ("node = 3", "node = 3\ncolour = 1", r"axis\[2\]\.colour is unknown"),
        ("expiry_ms = 3000", "expiry_ms = 1.5", r"cycle\.expiry_ms is 1\.5: int expected"),
        ("driven = true", "driven = 1", r"axis\[0\]\.driven is 1: bool expected"),
        ("node = 2\n", "", r"axis\[1\]\.node is missing"),
        ("counts_per_deg = [10000, 9]", "counts_per_deg = [0, 9]", r"axis\[0\]\.counts_per_deg"),
        ("vector = [0.0, -1.0, 0.0]", "vector = [0.0, -1.0]", r"axis\[0\]\.vector"),
        ('carries = "sample"', 'carries = "table"', r'axis\[0\]\.carries is "table"'),
        ("min_deg = -5.0\nmax_deg = 185.0", "min_deg = 185.0\nmax_deg = -5.0", r"axis\[0\]\.min_deg"),
        ("order = 2 }", "order = 2, fast = 1 }", r"axis\[0\]\.homing\.fast is unknown"),
        ("b = -150.0 }", "b = true }", r"zone\[0\]\.half_spaces\[0\]\.b is True"),
        ("a = [0.0, 0.0, -1.0, 0.0]", "a = [0.0, 0.0, -1.0]", r"zone\[0\]\.half_spaces\[0\]\.a"),
        ("[[channel]]", "[channel]", "channel must be an array of tables"),
        ("[instrument]", "[instrument", "not TOML"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, named: str) -> None:
    """One line with the file and the key."""
    assert old in REFERENCE
    text = REFERENCE.replace(old, new, 1)
    if old == "[[channel]]":
        text = text[: text.rindex("[[channel]]")]
    with pytest.raises(UsageError, match=rf"^my\.toml: .*{named}") as caught:
        parse_instrument(text, "my.toml")
    assert "\n" not in str(caught.value)


def test_limits_must_not_wind_up_the_cable() -> None:
    text = (Path(__file__).resolve().parents[3] / "protocol" / "axes.toml").read_text()
    with pytest.raises(UsageError, match=r"cable_wrap_deg is 180.0: the limits let it turn 190.0"):
        parse_instrument(text.replace("cable_wrap_deg = 190.0", "cable_wrap_deg = 180.0"), "axes.toml")


def test_negative_counts_per_degree() -> None:
    text = REFERENCE.replace("counts_per_deg = [10000, 9]", "counts_per_deg = [-10000, 9]", 1)
    assert parse_instrument(text, "my.toml").axes[0].counts_per_deg == -400_000 / 360


def test_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"none\.toml: cannot read"):
        load_instrument(tmp_path / "none.toml")


def test_exit_statuses() -> None:
    """The statuses that scripts rely on (docs: command line)."""
    assert [CheckFailed.exit_status, UsageError.exit_status, InstrumentFault.exit_status] == [1, 2, 3]
