"""test_fit_command.py: gonio fit: from a dataset to a model's file, what it prints and what it refuses."""

import json
from pathlib import Path

import pytest
from sampled_points import two_lobes

from gonio.cli.main import run
from gonio.dataset.nexus import write_dataset
from gonio.model.model_file import read_model


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fit") / "measured.h5"
    write_dataset(two_lobes((10.0, 30.0, 50.0)), path)
    return path


def test_fit_says_how_it_chose(measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "model.h5"
    assert run(["fit", str(measured), "-o", str(model), "--symmetry", "isotropic"]) == 0
    said = capsys.readouterr().out
    for words in (
        "symmetry isotropic (declared)",
        "leave-one-out over 1 incident direction:",
        "lobes-fixed",
        "reciprocity",
        "more than 50",
    ):
        assert words in said
    assert said.strip().endswith(str(model))
    assert read_model(model).symmetry == "isotropic"


def test_fit_as_json(measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["fit", str(measured), "-o", str(tmp_path / "model.h5"), "--symmetry", "isotropic", "--json"]
    assert run([*command, "--method", "lobes-same"]) == 0
    found = json.loads(capsys.readouterr().out)
    component = found["model"]["channels"]["visible"]["front reflection"]
    assert (component["chosen"], component["by"]) == ("lobes-same", "the user")
    assert [node["theta_deg"] for node in component["nodes"]] == pytest.approx([10.0, 30.0, 50.0])
    strongest = max(component["nodes"][1]["lobes"], key=lambda lobe: lobe["peak_per_sr"])
    assert strongest["theta_deg"] == pytest.approx(30.0, abs=0.2)
    assert strongest["peak_per_sr"] == pytest.approx(5.0, rel=0.02)
    assert strongest["sigma_deg"] == pytest.approx([6.0, 6.0], rel=0.02)


def test_a_family(measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "model.h5"
    assert run(["fit", "gaussian", str(measured), "-o", str(model), "--symmetry", "isotropic"]) == 0
    assert "family gaussian" in capsys.readouterr().out
    assert read_model(model).provenance["model"]["family"] == "gaussian"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--symmetry"),
        (["--symmetry", "isotropic", "--method", "best"], "--method best"),
        (["--symmetry", "isotropic", "--channel", "solar"], "channel solar"),
        (["--symmetry", "isotropic", "--sphere-band", "400,700"], "for a family"),
    ],
)
def test_what_fit_refuses(
    measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    model = tmp_path / "model.h5"
    assert run(["fit", str(measured), "-o", str(model), *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not model.exists()


def test_names_that_fit_refuses(measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = str(tmp_path / "model.h5")
    assert run(["fit", "phong", str(measured), "-o", model]) == 2
    assert "no family 'phong'" in capsys.readouterr().err
    assert run(["fit", "abg", str(measured), "again", "-o", model]) == 2
    assert run(["fit", "abg", str(measured), "-o", model, "--enforce-reciprocity"]) == 2
    assert run(["fit", str(tmp_path / "none.h5"), "-o", model]) == 2
