"""test_there_and_back.py: a sample without any symmetry goes through every format and comes back the same."""

import json
from pathlib import Path

import numpy as np
import pytest
from lopsided_sample import INCIDENT_DEG, Lopsided, exact_matrices, lopsided_bsdf, lopsided_dataset

from gonio.cli.main import run
from gonio.cli.sources import kind_of, open_bsdf
from gonio.dataset.bsdf import Dataset, Distribution, Side
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.formats.tensor.write import write_tensor
from gonio.formats.window import from_model as klems_model
from gonio.formats.window.klems import BASES
from gonio.formats.window.scattering import KlemsScattering
from gonio.geometry.directions import unit_from_angles_deg

QUARTER = BASES["klems-quarter"]
KNOWN = [
    ((20.0, 100.0), (40.0, 200.0)),
    ((50.0, 340.0), (130.0, 70.0)),
    ((125.0, 30.0), (30.0, 310.0)),
    ((160.0, 200.0), (115.0, 20.0)),
]


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module", params=["interior", "exterior"])
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Side, Path, Path]:
    """Which way the front faces; the sample as WINDOW XML and as a tensor tree."""
    folder = tmp_path_factory.mktemp(request.param)
    klems, tree = folder / "klems.xml", folder / "tree.xml"
    bsdf = lopsided_bsdf(request.param)
    klems_model.write(bsdf, klems, klems_model.ModelFile({"Visible": "visible"}), basis="klems-quarter")
    write_tensor(bsdf, tree, dimensions=4, resolution=4, leaves=40000)
    return request.param, klems, tree


def asked(path: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    capsys.readouterr()
    assert run(["query", str(path), "--json", *arguments]) == 0
    return dict(json.loads(capsys.readouterr().out))


def test_klems_matrices_hold_the_exact_averages(files: tuple[Side, Path, Path]) -> None:
    """Model to WINDOW XML and back: the double averages in closed form."""
    faces, path, _ = files
    assert kind_of(path) == "matrices"
    bsdf = open_bsdf(path)
    assert (bsdf.front_faces, bsdf.symmetry) == (faces, "none")
    own = bsdf.channels["visible"]
    assert isinstance(own, KlemsScattering)
    for key, exact in exact_matrices(QUARTER, faces).items():
        assert own.window.matrices["Visible", *key] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("kind", ["klems", "tree"])
def test_files_answer_at_known_directions(
    files: tuple[Side, Path, Path], kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    faces, klems, tree = files
    path, tolerance = (klems, 0.2) if kind == "klems" else (tree, 0.1)  # patches are some 25 degrees wide
    for incident_deg, outgoing_deg in KNOWN:
        incident, outgoing = (unit_from_angles_deg([t], [p]) for t, p in (incident_deg, outgoing_deg))
        pair = [f"{t},{p}" for t, p in (incident_deg, outgoing_deg)]
        found = asked(path, ["--incident", pair[0], "--outgoing", pair[1]], capsys)
        assert found["dsf_per_sr"] == pytest.approx(Lopsided().dsf_per_sr(incident, outgoing)[0], rel=tolerance)
        assert (found["front_faces"], found["origin"]) == (faces, "interpolated")


def sorted_points(d: Distribution) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
    order = np.lexsort(np.round(unit, 6).T)
    return np.column_stack((unit, d.dsf_per_sr))[order]


def assert_same_points(one: Dataset, other: Dataset, tolerance: float) -> None:
    found = {
        tuple(np.round(unit_from_angles_deg(d.incident_theta_deg, d.incident_phi_deg), 6) + 0.0): d
        for d in other.distributions
    }
    for d in one.distributions:
        key = tuple(np.round(unit_from_angles_deg(d.incident_theta_deg, d.incident_phi_deg), 6) + 0.0)
        assert sorted_points(found.pop(key)) == pytest.approx(sorted_points(d), rel=tolerance, abs=1e-9)
    assert not found


@pytest.mark.parametrize("faces", ["interior", "exterior"])
@pytest.mark.parametrize("kind", ["csv", "pab"])
def test_points_come_back_as_they_were(faces: Side, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Measured points, five incident directions on both sides, every direction and value the same."""
    write_dataset(lopsided_dataset(INCIDENT_DEG, faces, rings=6), Path("a.h5"))
    assert run(["export", "a.h5", "--format", kind, "-o", "points.csv" if kind == "csv" else "."]) == 0
    written = capsys.readouterr().out.split()
    assert run(["import", *written, "-o", "b.h5"]) == 0
    again = read_dataset(Path("b.h5"))
    assert again.front_faces == faces
    assert_same_points(read_dataset(Path("a.h5")), again, 1e-6)


def test_a_model_and_its_files_are_compared_with_the_measurement(
    files: tuple[Side, Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    faces, klems, tree = files
    write_dataset(lopsided_dataset(((20.0, 100.0), (160.0, 200.0)), faces, rings=8), Path("a.h5"))
    assert run(["fit", "a.h5", "-o", "model.h5", "--symmetry", "none"]) == 0
    for path, kind, least in ((tree, "tree", 95.0), (klems, "matrices", 90.0), (Path("model.h5"), "model", 99.0)):
        capsys.readouterr()
        assert run(["compare", "a.h5", str(path), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["b_kind"] == kind
        assert len(found["distributions"]) == 2
        assert found["global_accordance_percent"]["lowest"] > least
    other = "exterior" if faces == "interior" else "interior"
    assert run(["compare", "a.h5", str(tree), "--front", other, "--json"]) == 0  # seen from the wrong side
    assert json.loads(capsys.readouterr().out)["global_accordance_percent"]["lowest"] < 90.0
