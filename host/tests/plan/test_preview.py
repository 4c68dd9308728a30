"""test_preview.py: the preview page: complete, self-contained, written at once."""

from pathlib import Path

import pytest

from gonio.plan.compile import compile_loaded
from gonio.plan.preview import write_preview
from gonio.plan.schema import parse_plan
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

REFERENCE = load_instrument(None)
PLAN = "[scan]\nincident = [[20, 0]]\n[coarse]\npitch_deg = 20\n[[peak]]\nabout='mirror'\nradius_deg=2\npitch_deg=1\n"


def test_the_page_shows_every_path_and_needs_no_network(tmp_path: Path) -> None:
    target = tmp_path / "preview.html"
    write_preview(compile_loaded(parse_plan(PLAN, "p.toml"), REFERENCE), REFERENCE, target)
    text = target.read_text()
    for name in ("coarse 20\\u002f0", "mirror 20\\u002f0", "incident direction", "out of reach"):
        assert name in text or name.replace("\\u002f", "/") in text
    assert '<script src="http' not in text
    assert list(tmp_path.iterdir()) == [target]


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    target = tmp_path / "nowhere" / "preview.html"
    with pytest.raises(UsageError, match=r"preview\.html: cannot write the preview"):
        write_preview(compile_loaded(parse_plan(PLAN, "p.toml"), REFERENCE), REFERENCE, target)
