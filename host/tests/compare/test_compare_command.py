"""test_compare_command.py: gonio compare end to end: datasets, scenarios, matrices, wrong inputs in one line."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compared_data import dataset, distribution, drawn, lattice

from gonio.cli import main
from gonio.dataset.bsdf import Distribution
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.geometry.directions import unit_from_angles_deg

WHITE = "[sample]\ncomponents = [{ kind = 'lambertian', reflectance = 0.5, transmittance = 0.2 }]\n"
TRACED = """
seed = 5
[sample]
kind = "lambertian"
reflectance = { visible = 0.5 }
transmittance = { visible = 0.2 }
[[band]]
name = "visible"
[photons]
count = 200000
"""
AXES = Path(__file__).parents[3] / "protocol" / "axes.toml"
UNIT = lattice(900)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """a.h5 and b.h5: two noisy measurements of white.toml; half.h5: with half the DSF; other.h5: another direction."""
    place = tmp_path_factory.mktemp("compare")
    (place / "white.toml").write_text(WHITE)
    (place / "traced.toml").write_text(TRACED)
    (place / "empty.toml").write_text("seed = 1\n")
    (place / "odd.toml").write_text("sample = 3\n")
    cosine = UNIT[:, 2]
    white = (0.5 * np.maximum(cosine, 0.0) + 0.2 * np.maximum(-cosine, 0.0)) / np.pi
    rng = np.random.default_rng(21)
    effects = {"distance": 0.05 * white, "lamp": 0.001 * white}
    clean = distribution(UNIT, white, u_rel=0.01, incident=(20.0, 10.0), effects=effects)
    for name in ("a", "b"):
        write_dataset(
            dataset(drawn(clean, rng, {"distance": 0.1}), instrument=AXES.read_text(encoding="utf-8")),
            place / f"{name}.h5",
        )
    with_beam = dataset(drawn(clean, rng, {"distance": 0.1}))
    with_beam.beam = beam_points()
    write_dataset(with_beam, place / "with_beam.h5")
    write_dataset(dataset(distribution(UNIT, 0.5 * white, incident=(20.0, 10.0))), place / "half.h5")
    write_dataset(dataset(distribution(UNIT, white, incident=(40.0, 10.0))), place / "other.h5")
    (place / "text.h5").write_text("no HDF5")
    (place / "text.xml").write_text("<nothing/>")
    return place


def beam_points() -> Distribution:
    """150 directions within 4 degrees of the free beam: simulating it there is quick."""
    polar = 4.0 * np.sqrt((np.arange(150) + 0.5) / 150)
    return distribution(unit_from_angles_deg(polar, 137.508 * np.arange(150)), np.ones(150), incident=(0.0, 0.0))


def compared(
    folder: Path, b: str, capsys: pytest.CaptureFixture[str], *options: str, a: str = "a.h5"
) -> dict[str, Any]:
    assert main.run(["compare", str(folder / a), str(folder / b), "--json", *options]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    return found


def test_two_datasets(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = compared(folder, "b.h5", capsys)
    (pair,) = found["distributions"]
    assert pair["route"] == "same points"
    assert pair["incident_deg"] == [20.0, 10.0]
    assert pair["shared_effects"] == ["distance"]
    whole = pair["metrics"]["whole"]
    a, b = (read_dataset(folder / f"{name}.h5").distributions[0].dsf_per_sr for name in "ab")
    f = 100.0 * (1.0 - np.sqrt(np.sum((a - b) ** 2) / np.sum((a + b) ** 2)))
    assert whole["global_accordance_percent"]["value"] == pytest.approx(f)
    assert whole["accordance_class"] == "very good"
    assert whole["chi_square_per_point"] == pytest.approx(1.0, abs=0.2)
    assert whole["chi_square_with_correlations_per_point"] == pytest.approx(1.0, abs=0.2)
    assert found["global_accordance_percent"] == {"lowest": pytest.approx(f), "mean": pytest.approx(f)}
    assert {"rho_compared", "tau_compared"} <= {integral["name"] for integral in pair["integrals"]}
    assert set(pair["scatter_plane"]) == {"reflection", "transmission"}


def test_report(folder: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    found = compared(folder, "b.h5", capsys, "-o", str(page))
    written = page.read_text(encoding="utf-8")
    assert "A, the reference" in written
    assert f"{found['global_accordance_percent']['lowest']:.3f}" in written
    assert [place.name for place in tmp_path.iterdir()] == ["page.html"]


def test_text_and_floor(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["compare", str(folder / "a.h5"), str(folder / "half.h5"), "--floor", "0.02", "--full"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"A (reference): {folder / 'a.h5'}\nB (dataset): {folder / 'half.h5'}\n")
    assert "visible, incident (20, 10): B has the same points" in out
    f_row = next(line for line in out.splitlines() if "global accordance f" in line)
    assert f_row.split("]")[1].split()[0].startswith("66.")  # 100 (1 - 0.5 / 1.5)
    assert "points with A under 0.02 1/sr" in out
    assert "nan" not in out


def test_a_closed_form_is_evaluated(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A is that scenario with 1 % noise: nothing is left but that."""
    found = compared(folder, "white.toml", capsys)
    assert found["b_kind"] == "scenario"
    (pair,) = found["distributions"]
    assert pair["route"] == "evaluated"
    away = pair["metrics"]["whole"]
    assert away["global_accordance_percent"]["value"] == pytest.approx(99.5, abs=0.1)
    assert away["local_accordance_percent"]["value"] > 98.5
    rho = next(integral for integral in pair["integrals"] if integral["name"] == "rho_compared")
    assert rho["b"] == pytest.approx(0.5, rel=2e-3)


def test_a_traced_sample_is_simulated_at_the_same_points(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = compared(folder, "traced.toml", capsys, a="with_beam.h5")
    assert found["b_kind"] == "simulation"
    (pair,) = found["distributions"]
    assert pair["route"] == "same points"
    rho = next(integral for integral in pair["integrals"] if integral["name"] == "rho_compared")
    assert abs(rho["in_u"]) < 4.0
    assert rho["u_percent"] < 8.0  # distance 5 %, photons 3 %
    assert pair["metrics"]["whole"]["global_accordance_percent"]["from_uncertainty"] < 80.0


def test_matrices_of_the_same_sample(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own export: white again, but for patches that the points' cells cross."""
    xml = folder / "white.xml"
    export = ["export", str(folder / "a.h5"), "--format", "klems-full", "--front", "exterior", "--fill", "none"]
    assert main.run([*export, "-o", str(xml)]) == 0
    capsys.readouterr()
    found = compared(folder, "white.xml", capsys, "--front", "exterior")
    (pair,) = found["distributions"]
    assert pair["metrics"]["whole"]["global_accordance_percent"]["value"] > 97.0
    for integral in pair["integrals"]:
        if integral["name"].endswith("compared"):
            assert integral["delta_percent"] < 2.0
    assert main.run(["compare", str(folder / "a.h5"), str(xml)]) == 2
    assert "--front" in capsys.readouterr().err


def test_least_accordance_is_a_check(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b, half = (str(folder / f"{name}.h5") for name in ("a", "b", "half"))
    assert main.run(["compare", a, b, "--min-accordance", "98"]) == 0
    capsys.readouterr()
    assert main.run(["compare", a, half, "--json", "--min-accordance", "98"]) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["distributions"]
    assert err.count("\n") == 1
    assert "visible (20, 10)" in err
    assert "66.4" in err  # 100 (1 - 0.5 / 1.5), A moved by the distance


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.h5", "b.h5"], "no such file"),
        (["a.h5", "none.toml"], "no such file"),
        (["a.h5", "text.h5"], "text.h5"),
        (["text.h5", "a.h5"], "text.h5"),
        (["a.h5", "text.xml"], "WindowElement"),
        (["a.h5", "empty.toml"], "no sample"),
        (["a.h5", "odd.toml"], "no sample"),
        (["a.h5", "other.h5"], "visible (40, 10) belongs to none of"),
        (["a.h5", "b.h5", "--tolerance", "-1"], "--tolerance"),
        (["a.h5", "b.h5", "--floor", "nan"], "--floor"),
        (["a.h5", "b.h5", "-o", "a.h5"], "named twice"),
        (["a.h5", "b.h5", "-o", "nowhere/x.html"], "no folder"),
    ],
)
def test_wrong_use_is_one_line(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(folder)
    assert main.run(["compare", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("gonio: ")
    assert err.count("\n") == 1
    assert words in err
