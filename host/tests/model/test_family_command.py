"""test_family_command.py: gonio fit FAMILY on the command line: model file, text, JSON, sphere, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest
from analytic_cases import dataset, light, measured

from gonio.cli import main
from gonio.dataset.nexus import write_dataset
from gonio.model.analytic import AnalyticScattering, Component
from gonio.model.model_file import read_model


@pytest.fixture(autouse=True)
def _points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    parts = {
        True: Component.of("lambertian", "reflection", share=0.45),
        False: Component.of("abg", "transmission", A=0.004, B=0.002, g=1.9),
    }
    write_dataset(dataset(*[measured(parts, t, noise=0.03, n=800) for t in (0.0, 30.0, 60.0)]), Path("bsdf.h5"))
    Path("sphere.csv").write_text("wavelength_nm,tau_total,tau_diffuse\n380,0.125,0.07\n780,0.125,0.07\n")


def test_model_text_and_query(capsys: pytest.CaptureFixture[str]) -> None:
    """What the file answers is what the points were made of; both ABg fits stand in the text."""
    assert main.run(["fit", "abg", "bsdf.h5", "-o", "m.h5"]) == 0
    text = capsys.readouterr().out
    for words in ("front transmission", "family abg", "weighted fit", "as published (simplex", "integral tied to"):
        assert words in text
    found = read_model(Path("m.h5"))
    scattering = found.channels["visible"]
    assert isinstance(scattering, AnalyticScattering)
    through = np.array([[-0.5, 0.0, -np.sqrt(0.75)]])
    assert scattering.dsf_per_sr(light(30.0), through)[0] == pytest.approx(2.0 * np.sqrt(0.75), rel=0.05)
    assert main.run(["query", "m.h5", "--incident", "30,0", "--outgoing", "150,180", "--json"]) == 0
    assert '"interpolated"' in capsys.readouterr().out


def test_auto_with_a_sphere_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    run = ["fit", "auto", "bsdf.h5", "-o", "m.h5", "--sphere", "sphere.csv", "--sphere-tie", "diffuse", "--json"]
    assert main.run(run) == 0
    record = json.loads(capsys.readouterr().out)["model"]["channels"]["visible"]
    assert record["components"]["front reflection"]["family"] == "lambertian"
    assert record["components"]["front transmission"]["family"] == "abg"
    assert record["sphere"]["openness"] == pytest.approx(0.055)
    scattering = read_model(Path("m.h5")).channels["visible"]
    assert isinstance(scattering, AnalyticScattering)
    assert scattering.components[True, False].integral(np.zeros(1))[0] == pytest.approx(0.07, rel=1e-9)


@pytest.mark.parametrize(
    ("extra", "words"),
    [
        (["ward-duer", "bsdf.h5"], "has no transmission"),
        (["abg", "bsdf.h5", "--symmetry", "bilateral"], "are isotropic"),
        (["bsdf.h5", "--sphere", "sphere.csv"], "for a family"),
        (["abg", "bsdf.h5", "--sphere", "none.csv"], "none.csv"),
    ],
)
def test_one_line_refusals(extra: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["fit", *extra, "-o", "m.h5"]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert not Path("m.h5").exists()
