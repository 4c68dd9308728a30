"""limits.py: cable wrap in a spiral, an axis with the wrong sign."""

import re
from pathlib import Path

from guest.bench import Bench
from scenarios.registry import scenario


@scenario()
def cable_wrap(bench: Bench) -> None:
    """A spiral that ends just inside the wrap is flown; one that would go beyond is refused, nothing moves."""
    bench.end(bench.scan("wrap-inside.toml", "inside.mcap"))
    bench.until_safe()
    bench.end(bench.scan("wrap-beyond.toml", "beyond.mcap"))
    bench.state("after")


@scenario()
def wrong_sign(bench: Bench) -> None:
    """The instrument file has the arm's azimuth turn the other way than its switch says."""
    described = bench.instrument
    head, arm = described.read_text().split('name = "arm azimuth"')
    wrong = bench.folder / "wrong-sign.toml"
    wrong.write_text(head + 'name = "arm azimuth"' + re.sub(r"\[10000, 9\]", "[-10000, 9]", arm, count=1))
    bench.end(bench.start("home", "home", instrument=Path(wrong)))
    bench.state("after")
    bench.gonio("recovery", "home")
