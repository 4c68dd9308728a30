"""test_files.py: commands on files: the chain on a thinned NIST table, places that are wrong, what Ctrl-C leaves."""

import csv
import json
import os
from pathlib import Path
from typing import NoReturn

import pytest

from gonio.cli import main
from gonio.formats.window.read import read

ROOT = Path(__file__).parents[3]
NIST = ROOT / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"
LAMBERTIAN = "[sample]\ncomponents = [{ kind = 'lambertian', reflectance = 0.99, transmittance = 0.0 }]\n"


@pytest.fixture(scope="module")
def thinned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """NIST's table at two wavelengths and three incident directions."""
    path = tmp_path_factory.mktemp("nist") / "thin.csv"
    with NIST.open(newline="") as source, path.open("w", newline="") as target:
        rows = csv.DictReader(source)
        assert rows.fieldnames is not None
        writer = csv.DictWriter(target, rows.fieldnames)
        writer.writeheader()
        kept = [row for row in rows if row["lambda"].strip() in ("0.532", "0.633") and float(row["thetai"]) > -40]
        writer.writerows(kept)
    assert len(kept) > 1000
    return path


@pytest.fixture(scope="module")
def reduced(thinned: Path) -> Path:
    points, dataset = thinned.with_name("points.h5"), thinned.with_name("bsdf.h5")
    assert main.run(["import", str(thinned), "-o", str(points)]) == 0
    assert main.run(["reduce", str(points), "-o", str(dataset)]) == 0
    return dataset


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_csv_holds_all_channels_or_the_one_named(reduced: Path) -> None:
    for arguments, channels in (([], {"532 nm", "633 nm"}), (["--channel", "633 nm"], {"633 nm"})):
        assert main.run(["export", str(reduced), "--format", "csv", *arguments, "-o", "points.csv"]) == 0
        lines = [line for line in Path("points.csv").read_text().splitlines() if not line.startswith("#")]
        assert {row["channel"] for row in csv.DictReader(lines)} == channels


def test_klems_from_one_channel_says_what_it_did_and_is_valid(
    reduced: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    export = ["export", str(reduced), "--format", "klems-full", "--front", "exterior", "-o", "bsdf.xml"]
    assert main.run([*export, "--fill", "nearest"]) == 2
    assert "--channel" in capsys.readouterr().err
    assert main.run([*export, "--channel", "633 nm", "--fill", "nearest", "--assume-flat"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "bsdf.xml\n"
    remarks = captured.err.splitlines()
    assert "gonio: Solar: copied from Visible (declared spectrally flat)." in remarks
    assert any("not measured, zeros: Transmission Front" in line for line in remarks)
    written = read(Path("bsdf.xml"))
    for line in remarks:  # what is said is in the file too
        assert line.removeprefix("gonio: ") in written.text["Comments"]
    assert (
        written.matrices["Solar", "Reflection", "Front"] == written.matrices["Visible", "Reflection", "Front"]
    ).all()
    assert not written.matrices["Visible", "Transmission", "Front"].any()
    rho = written.hemispherical("Visible", "Reflection", "Front")
    assert 0.95 < rho[0] < 1.0  # sintered PTFE
    assert main.run(["validate", "bsdf.xml"]) == 0
    assert "0 errors, 0 warnings" in capsys.readouterr().out
    assert main.run(["validate", "bsdf.xml", "--profile", "radiance", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["exit_status"] == 0


def test_report_and_summary_with_a_truth_beside(reduced: Path) -> None:
    Path("sample.toml").write_text(LAMBERTIAN)
    arguments = ["--scenario", "sample.toml", "--summary", "summary.json", "-o", "report.html"]
    assert main.run(["report", str(reduced), *arguments]) == 0
    page = Path("report.html").read_text()
    assert "532 nm" in page
    assert "0.998" in page  # 0:45 at 532 nm, from the data's own note
    summary = json.loads(Path("summary.json").read_text())
    assert len(summary["distributions"]) == 6
    for entry in summary["distributions"]:
        assert entry["truth"]["integrals"]["rho_estimate"] == pytest.approx(0.99)
        assert abs(entry["differences"]["integrals"]["rho_measured"]["relative"]) < 0.05  # PTFE is nearly Lambertian


def test_second_run_replaces_the_first_files(reduced: Path) -> None:
    for _ in range(2):
        assert main.run(["reduce", str(reduced), "-o", "again.h5"]) == 0
        assert main.run(["export", "again.h5", "--format", "csv", "-o", "again.csv"]) == 0
    assert sorted(path.name for path in Path().iterdir()) == ["again.csv", "again.h5"]


@pytest.mark.parametrize("command", ["reduce", "export", "import", "report"])
@pytest.mark.parametrize(
    ("output", "words"),
    [("folder", "is a directory"), ("none/out", "there is no folder none"), ("INPUT", "named twice")],
)
def test_outputs_that_cannot_be(
    command: str, output: str, words: str, thinned: Path, reduced: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("folder").mkdir()
    file = thinned if command == "import" else reduced
    before = file.read_bytes()
    arguments = [command, str(file), "-o", str(file) if output == "INPUT" else output]
    assert main.run([*arguments, "--format", "csv"] if command == "export" else arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert words in captured.err
    assert file.read_bytes() == before
    assert [path.name for path in Path().iterdir()] == ["folder"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_folder_that_is_not_writable(thinned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("closed").mkdir(mode=0o555)
    assert main.run(["import", str(thinned), "-o", "closed/points.h5"]) == 2
    assert "not writable" in capsys.readouterr().err


def test_plan_preview_into_a_directory_leaves_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    Path("folder").mkdir()
    plan = str(ROOT / "docs" / "examples" / "demo.toml")
    assert main.run(["plan", plan, "--preview", "folder"]) == 2
    assert "is a directory" in capsys.readouterr().err
    assert [path.name for path in Path().iterdir()] == ["folder"]


def test_interrupted_in_the_middle_of_writing(
    reduced: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C between writing beside and moving there: the old file stays, nothing lies about."""

    def interrupted(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    Path("out.h5").write_text("old")
    Path("out.csv").write_text("old")
    monkeypatch.setattr(os, "replace", interrupted)
    for arguments in (
        ["reduce", str(reduced), "-o", "out.h5"],
        ["export", str(reduced), "--format", "csv", "-o", "out.csv"],
    ):
        assert main.run(arguments) == main.INTERRUPTED
        assert capsys.readouterr().err == "gonio: interrupted: no file was left half written\n"
    assert {path.name: path.read_text() for path in Path().iterdir()} == {"out.h5": "old", "out.csv": "old"}
