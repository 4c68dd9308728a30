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
from gonio.dataset.scattering import Origin
from gonio.formats import klems_model
from gonio.formats.klems import BASES
from gonio.formats.klems_scattering import KlemsScattering
from gonio.formats.tensor.write import write_tensor
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


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_klems_matrices_hold_the_exact_averages(faces: Side) -> None:
    """Model to WINDOW XML and back: the double averages in closed form, side by side."""
    path = Path("a.xml")
    channels = {"Visible": "visible", "Solar": "solar"}
    klems_model.write(lopsided_bsdf(faces), path, klems_model.ModelFile(channels), basis="klems-quarter")  # type: ignore[arg-type]
    assert kind_of(path) == "matrices"
    bsdf = open_bsdf(path)
    assert (bsdf.front_faces, bsdf.symmetry, list(bsdf.channels)) == (faces, "none", ["visible", "solar"])
    own = bsdf.channels["visible"]
    assert isinstance(own, KlemsScattering)
    for key, exact in exact_matrices(QUARTER, faces).items():
        assert own.window.matrices["Visible", *key] == pytest.approx(exact, rel=2e-3)
    for incident_deg, outgoing_deg in KNOWN:
        incident, outgoing = (unit_from_angles_deg([t], [p]) for t, p in (incident_deg, outgoing_deg))
        visible, solar, truth = (s.dsf_per_sr(incident, outgoing)[0] for s in (own, bsdf.channels["solar"], Lopsided()))
        assert visible == pytest.approx(truth, rel=0.2)  # patches are some 25 degrees wide
        assert solar == pytest.approx(0.8 * visible, rel=1e-4)
        assert own.origin(incident, outgoing)[0] == Origin.INTERPOLATED


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_tensor_tree_answers_at_known_directions(faces: Side, capsys: pytest.CaptureFixture[str]) -> None:
    write_tensor(lopsided_bsdf(faces), Path("t.xml"), dimensions=4, resolution=5, leaves=60000)
    for incident_deg, outgoing_deg in KNOWN:
        arguments = [
            "--incident",
            f"{incident_deg[0]},{incident_deg[1]}",
            "--outgoing",
            f"{outgoing_deg[0]},{outgoing_deg[1]}",
        ]
        assert run(["query", "t.xml", "--json", *arguments]) == 0
        found = json.loads(capsys.readouterr().out)
        incident, outgoing = (unit_from_angles_deg([t], [p]) for t, p in (incident_deg, outgoing_deg))
        assert found["dsf_per_sr"] == pytest.approx(Lopsided().dsf_per_sr(incident, outgoing)[0], rel=0.1)
        assert found["front_faces"] == faces
        assert found["origin"] == "interpolated"


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


def test_a_model_and_its_files_are_compared_with_the_measurement(capsys: pytest.CaptureFixture[str]) -> None:
    write_dataset(lopsided_dataset(((20.0, 100.0), (160.0, 200.0)), "exterior", rings=12), Path("a.h5"))
    write_tensor(lopsided_bsdf("exterior"), Path("tree.xml"), dimensions=4, resolution=5, leaves=60000)
    what = klems_model.ModelFile({"Visible": "visible"})
    klems_model.write(lopsided_bsdf("exterior"), Path("klems.xml"), what, basis="klems-quarter")
    assert run(["fit", "a.h5", "-o", "model.h5", "--symmetry", "none"]) == 0
    capsys.readouterr()
    for name, kind, least in (("tree.xml", "tree", 97.0), ("klems.xml", "matrices", 90.0), ("model.h5", "model", 99.0)):
        assert run(["compare", "a.h5", name, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["b_kind"] == kind
        assert len(found["distributions"]) == 2
        assert found["global_accordance_percent"]["lowest"] > least
    assert run(["compare", "a.h5", "tree.xml", "--front", "interior", "--json"]) == 0  # seen from the wrong side
    assert json.loads(capsys.readouterr().out)["global_accordance_percent"]["lowest"] < 90.0
