"""test_cli.py: errors in one line with the right status, what --help imports, commands without an instrument."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gonio.cli import main

COMMANDS = [
    "twin",
    "info",
    "home",
    "stop",
    "plan",
    "scan",
    "simulate",
    "reduce",
    "export",
    "import",
    "query",
    "validate",
    "report",
    "merge",
    "repeatability",
    "compare",
]


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)


def test_all_commands_are_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["--help"]) == 0
    text = capsys.readouterr().out
    for command in COMMANDS:
        assert f"\n  {command} " in text
        assert main.run([command, "--help"]) == 0


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["--version"]) == 0
    assert capsys.readouterr().out.startswith("gonio 0.")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_imports_no_heavy_library(command: str) -> None:
    code = (
        "import sys; from gonio.cli import main; status = main.run([sys.argv[1], '--help']); names = set(sys.modules);"
        "heavy = {'numpy', 'scipy', 'h5py', 'matplotlib', 'plotly', 'mcap', 'google.protobuf', 'dask'} & names;"
        "assert status == 0 and not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code, command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nonsense"], "nonsense"),
        (["scan"], "PLAN.toml"),
        (["scan", "p.toml", "--device", "tcp://h:1"], "--output"),
        (["info", "--device", "serial:0"], "serial:0"),
        (["info", "--device", "twin:none.toml"], "none.toml"),
        (["home", "--device", "tcp://127.0.0.1:1"], "cannot connect"),
        (["home", "--device", "tcp://127.0.0.1:1", "--instrument", "none.toml"], "none.toml"),
        (["stop"], "drives an instrument"),
        (["stop", "--device", "tcp://127.0.0.1:1"], "cannot connect"),
        (["export", "x.h5", "--format", "nonsense", "-o", "y"], "nonsense"),
        (["export", "none.h5", "--format", "csv", "-o", "y.csv"], "none.h5"),
        (["import", "none.csv", "-o", "y.h5"], "none.csv"),
        (["validate", "none.xml"], "none.xml"),
        (["reduce", "none.mcap", "-o", "y.h5"], "none.mcap"),
        (["reduce", ".", "-o", "y.h5"], "is a directory"),
        (["report", "none.h5", "-o", "y.html"], "none.h5"),
        (["plan", "none.toml"], "none.toml"),
        (["scan", "none.toml", "-o", "r.mcap", "--device", "tcp://127.0.0.1:1"], "none.toml"),
    ],
)
def test_wrong_use_is_one_line_and_status_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("gonio: ")
    assert captured.err.count("\n") == 1
    assert words in captured.err


def test_raw_log_and_dataset_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a.mcap", "b.h5"):
        (tmp_path / name).touch()
    assert main.run(["reduce", "a.mcap", "b.h5", "-o", "y.h5"]) == 2
    assert "one scan" in capsys.readouterr().err


def test_foreign_raw_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "foreign.mcap").write_bytes(b"PK\x03\x04 something else")
    assert main.run(["reduce", "foreign.mcap", "-o", "y.h5"]) == 2
    assert "not a raw log" in capsys.readouterr().err
    assert not (tmp_path / "y.h5").exists()


def test_internal_error_is_said_and_can_be_traced(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(_path: Path | None) -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr("gonio.units.instrument.load_instrument", broken)
    arguments = ["home", "--device", "tcp://127.0.0.1:1"]
    assert main.run(arguments) == main.INTERNAL_ERROR
    text = capsys.readouterr().err
    assert "ZeroDivisionError: a bug" in text
    assert "--debug" in text
    assert text.count("\n") == 1
    assert main.run(["--debug", *arguments]) == main.INTERNAL_ERROR
    assert "Traceback" in capsys.readouterr().err


def test_twin_that_is_not_built(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text("seed = 1")
    done = subprocess.run(
        [sys.executable, "-m", "gonio.cli.main", "twin", "run", "s.toml"],
        env=os.environ | {"GONIO_TWIN": "/nonexistent/gonio-twin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "run make build" in done.stderr


def test_validate_finds_and_says_in_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A WindowElement without anything in it is readable or not: the status is 1 or 2, never 0."""
    (tmp_path / "empty.xml").write_text("<?xml version='1.0'?><WindowElement/>")
    status = main.run(["validate", "empty.xml", "--json"])
    captured = capsys.readouterr()
    assert status in (1, 2)
    if status == 1:
        assert json.loads(captured.out)["exit_status"] == 1
    else:
        assert captured.err.count("\n") == 1
