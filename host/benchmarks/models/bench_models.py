"""bench_models.py: models and simulation files beside Radiance's chain in one run: a table and bench_models.json.

python -m benchmarks.models.bench_models FOLDER [--quick] [--only NAME]: --quick takes few points and coarse trees.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.rows import machine

from . import others, retro, speed
from .points import Noise
from .samples import RetroCoating
from .size import FULL, QUICK, Size
from .table import printed

Part = tuple[list[dict[str, Any]], list[str]]


def coating(folder: Path, size: Size) -> Part:
    """Noise-free, the issue's targets."""
    sample = RetroCoating()
    dataset = retro.dataset(sample, size.points)
    rows, notes = retro.judge("retro", sample, dataset, folder, size, targets=True)
    return rows + retro.left_out("retro", sample, dataset, folder, size, targets=True), notes


def noisy(folder: Path, size: Size) -> Part:
    """With 1 % and 0.002 /sr of noise."""
    sample = RetroCoating()
    dataset = retro.dataset(sample, size.points, noise=Noise())
    rows, notes = retro.judge("retro, noise", sample, dataset, folder, size, targets=False)
    return rows + retro.left_out("retro, noise", sample, dataset, folder, size, targets=False), notes


def even(folder: Path, size: Size) -> Part:
    """Points evenly over the hemisphere: hardly one per standard deviation of the peak."""
    sample = RetroCoating()
    dataset = retro.dataset(sample, size.points, "even")
    return retro.judge("retro, even points", sample, dataset, folder, size, targets=False)


def tailed(folder: Path, size: Size) -> Part:
    """A peak that no Gaussian fits."""
    sample = RetroCoating(tail_power=3.0)
    dataset = retro.dataset(sample, size.points, noise=Noise())
    rows, notes = retro.judge("retro, tails, noise", sample, dataset, folder, size, targets=False)
    return rows + retro.left_out("retro, tails, noise", sample, dataset, folder, size, targets=False), notes


def run(out: Path, size: Size, only: str | None) -> Part:
    """All parts, or the one named; each is printed when it is done, for the whole takes long."""
    parts: dict[str, Callable[[Path, Size], Part]] = {
        "retro": coating,
        "noise": noisy,
        "even": even,
        "tails": tailed,
        "two-peaked": others.two_peaked,
        "louver": lambda folder, size: others.louver(folder, size, out),
        "ptfe": others.ptfe,
        "speed": speed.judge,
    }
    rows: list[dict[str, Any]] = []
    notes: list[str] = []
    for name, part in parts.items():
        if only in (None, name):
            with tempfile.TemporaryDirectory() as folder:
                more_rows, more_notes = part(Path(folder), size)
            sys.stdout.write("\n".join([*printed(more_rows), *more_notes, ""]))
            sys.stdout.flush()
            rows += more_rows
            notes += more_notes
    return rows, notes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", nargs="?", default="../build/bench", type=Path)
    parser.add_argument("--quick", action="store_true")
    names = ("retro", "noise", "even", "tails", "two-peaked", "louver", "ptfe", "speed")
    parser.add_argument("--only", choices=names)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows, notes = run(options.out.resolve(), QUICK if options.quick else FULL, options.only)
    text = {"bench": "bench_models", "machine": machine(), "quick": options.quick, "rows": rows, "notes": notes}
    suffix = "" if options.only is None else f"_{options.only}"
    (options.out / f"bench_models{suffix}.json").write_text(json.dumps(text, indent=1) + "\n")
    asked = [r for r in rows if r["target"] is not None]
    reached = sum(r["reached"] for r in asked)
    sys.stdout.write(f"{reached} of {len(asked)} targets reached\n")


if __name__ == "__main__":
    main()
