"""conftest.py: the virtual bench with four drives, and the command line on it."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from virtual_drives import VirtualBench, VirtualDrive, instrument_text

from gonio.cli import main


@pytest.fixture
def bench() -> Iterator[VirtualBench]:
    made = VirtualBench()
    yield made
    made.close()


@pytest.fixture
def drives(bench: VirtualBench) -> list[VirtualDrive]:
    """Four full drives; a test changes them before it runs a command."""
    made = [VirtualDrive(node, "full") for node in (1, 2, 3, 4)]
    bench.add(*made)
    return made


@pytest.fixture
def instrument(tmp_path: Path) -> Path:
    path = tmp_path / "axes.toml"
    path.write_text(instrument_text(), encoding="utf-8")
    return path


Run = Callable[..., tuple[int, Any]]


@pytest.fixture
def run(bench: VirtualBench, instrument: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """`gonio drives ...` on the bench with --json: exit status and the object (None if there is none)."""

    def go(command: str, *more: str) -> tuple[int, Any]:
        capsys.readouterr()
        words = ["drives", command, *bench.arguments, "--instrument", str(instrument), "--json", *more]
        status = main.run(words)
        out = capsys.readouterr()
        run_error[:] = [out.err]
        return status, json.loads(out.out) if out.out.strip() else None

    run_error: list[str] = [""]
    go.error = lambda: run_error[0]  # type: ignore[attr-defined]
    return go
