"""test_import_xml.py: gonio import of WINDOW XML: sums keep the file's energy, directions keep their places."""

import json
from pathlib import Path

import numpy as np
import pytest
from lopsided_sample import SOLAR_FACTOR, Lopsided, exact_matrices
from wild_xml import SMALL, klems_xml

from gonio.cli.main import run
from gonio.dataset.bsdf import Distribution, Side
from gonio.dataset.nexus import read_dataset
from gonio.formats import validity
from gonio.formats.window import dataset as window_dataset
from gonio.formats.window.klems import BASES
from gonio.formats.window.read import OLD_BASES, read
from gonio.geometry.directions import unit_from_angles_deg

SEATEX = Path(__file__).parents[1] / "data" / "window_xml" / "46016_SEATEX_Midnight.xml"


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def sums(distribution: Distribution) -> tuple[float, float]:
    """rho and tau: sum of DSF times solid angle on both sides."""
    energy = distribution.dsf_per_sr * distribution.solid_angle_sr
    same = (distribution.theta_deg < 90.0) == (distribution.incident_theta_deg < 90.0)
    return float(energy[same].sum()), float(energy[~same].sum())


def test_seatex_keeps_its_integrals() -> None:
    dataset, remarks = window_dataset.read_dataset(SEATEX)
    assert remarks == []
    assert (dataset.front_faces, dataset.sample_name, dataset.thickness_mm) == ("exterior", "SEATEX Midnight", 0.48)
    assert [sum(d.channel == name for d in dataset.distributions) for name in ("visible", "solar")] == [290, 290]
    content = read(SEATEX)
    for d in dataset.distributions[::17]:
        side = "Front" if d.incident_theta_deg < 90.0 else "Back"
        polar = d.incident_theta_deg if side == "Front" else 180.0 - d.incident_theta_deg
        azimuth = 180.0 - d.incident_phi_deg if side in ("Front", "Back") else 0.0  # the front faces the exterior
        column = content.basis.patch_of(polar, azimuth + 180.0)
        band = "Visible" if d.channel == "visible" else "Solar"
        expected = [content.hemispherical(band, process, side)[column] for process in ("Reflection", "Transmission")]  # type: ignore[arg-type]
        assert sums(d) == pytest.approx(expected, rel=1e-9)
    normal = next(d for d in dataset.distributions if d.incident_theta_deg == 0.0)
    assert sums(normal) == pytest.approx((0.082136, 0.059277), abs=5e-7)
    assert normal.solid_angle_sr.sum() == pytest.approx(4.0 * np.pi)
    # "0.000375" was rounded to six decimals.
    assert np.sqrt(normal.variance_per_sr2[normal.dsf_per_sr < 0.01].max()) < 1e-6
    assert "averages over pairs of patches" in dataset.provenance["imported"]["values"]


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_sample_without_symmetry_keeps_its_sides(faces: Side, capsys: pytest.CaptureFixture[str]) -> None:
    matrices = {
        (band, *key): factor * matrix
        for band, factor in (("Visible", 1.0), ("Solar", SOLAR_FACTOR))
        for key, matrix in exact_matrices(SMALL, faces).items()
    }
    comments = f"By gonio. {validity.FRONT_SENTENCE}{'front' if faces == 'exterior' else 'back'}."
    Path("a.xml").write_text(klems_xml(matrices, comments=comments))
    assert run(["import", "a.xml", "-o", "a.h5", "--sample-name", "again"]) == 0
    assert capsys.readouterr().out == "a.h5\n"
    dataset = read_dataset(Path("a.h5"))
    assert (dataset.front_faces, dataset.sample_name) == (faces, "again")
    assert len(dataset.distributions) == 2 * 2 * SMALL.size
    for d in dataset.distributions[::7]:
        truth = Lopsided(1.0 if d.channel == "visible" else SOLAR_FACTOR)
        incident = unit_from_angles_deg([d.incident_theta_deg], [d.incident_phi_deg])
        outgoing = unit_from_angles_deg(d.theta_deg, d.phi_deg)
        assert sums(d) == pytest.approx([truth.integral(incident[0], reflection=r) for r in (True, False)], rel=0.05)
        expected = truth.dsf_per_sr(incident, outgoing)
        assert np.corrcoef(d.dsf_per_sr, expected)[0, 1] > 0.99
        for turn in ([-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]):
            moved = truth.dsf_per_sr(incident, outgoing * np.array(turn))
            assert np.abs(d.dsf_per_sr - expected).sum() < 0.5 * np.abs(d.dsf_per_sr - moved).sum()
        assert d.integrals["rho_measured"] == pytest.approx(sums(d)[0])
        assert d.integrals["tau_measured"] == pytest.approx(sums(d)[1])


def test_what_is_asked_of_the_file_and_of_its_dataset_agrees(capsys: pytest.CaptureFixture[str]) -> None:
    """Known directions: patch centres, front and back."""
    Path("a.xml").write_text(klems_xml({("Visible", *k): m for k, m in exact_matrices(SMALL, "exterior").items()}))
    assert run(["import", "a.xml", "-o", "a.h5"]) == 0
    for d in read_dataset(Path("a.h5")).distributions[::25]:
        for point in (3, 40, 55):
            capsys.readouterr()
            directions = [
                f"{d.incident_theta_deg},{d.incident_phi_deg}",
                f"{d.theta_deg[point]},{d.phi_deg[point]}",
            ]
            assert run(["query", "a.xml", "--json", "--incident", directions[0], "--outgoing", directions[1]]) == 0
            found = json.loads(capsys.readouterr().out)
            patch = point % SMALL.size
            ratio = SMALL.projected_solid_angle_sr[patch] / window_dataset.solid_angle_sr(SMALL)[patch]
            assert found["bsdf_per_sr"] * ratio == pytest.approx(d.dsf_per_sr[point], rel=1e-7)


def test_old_bases_and_patches_that_were_not_measured(capsys: pytest.CaptureFixture[str]) -> None:
    old = OLD_BASES[0]
    matrices = {("Visible", *key): matrix for key, matrix in exact_matrices(old).items()}
    for matrix in matrices.values():
        matrix[:, 20:] = 0.0
    matrices["Visible", "Transmission", "Back"][:] = 0.0
    Path("old.xml").write_text(klems_xml(matrices, old))
    assert run(["import", "old.xml", "-o", "old.h5"]) == 0
    assert "106 incident patches hold zeros only" in capsys.readouterr().err
    dataset = read_dataset(Path("old.h5"))
    assert len(dataset.distributions) == 2 * 20
    assert {len(d.theta_deg) for d in dataset.distributions} == {146}
    assert dataset.provenance["imported"]["basis"] == "LBNL/Klems Half"
    assert window_dataset.solid_angle_sr(old).sum() == pytest.approx(2.0 * np.pi)
    empty = {key: 0.0 * matrix for key, matrix in matrices.items()}
    Path("empty.xml").write_text(klems_xml(empty, old))
    assert run(["import", "empty.xml", "-o", "empty.h5"]) == 2
    assert "nothing was measured" in capsys.readouterr().err
    assert not Path("empty.h5").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.xml", "a.xml"], "one file at a time"),
        (["a.xml", "--p-i", "3"], "--p-i"),
        (["a.xml", "--incident", "3,4"], "--incident"),
        (["a.csv", "--front", "exterior"], "--front"),
        (["b.xml"], "WindowElement"),
    ],
)
def test_wrong_use_is_one_line(capsys: pytest.CaptureFixture[str], arguments: list[str], words: str) -> None:
    Path("a.xml").write_text(klems_xml({("Visible", *key): m for key, m in exact_matrices(SMALL).items()}))
    Path("a.csv").write_text("theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,dsf_per_sr\n0,0,1,1,1\n")
    Path("b.xml").write_text("<nothing/>")
    assert run(["import", *arguments, "-o", "x.h5"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert words in err
    assert not Path("x.h5").exists()


def test_solid_angles_of_patches() -> None:
    for basis in (*BASES.values(), *OLD_BASES):
        omega = window_dataset.solid_angle_sr(basis)
        assert omega.sum() == pytest.approx(2.0 * np.pi)
        assert np.all(omega > basis.projected_solid_angle_sr)
