"""test_wild_trees.py: tensor trees, Radiance's own and damaged ones: validated, imported, asked."""

from pathlib import Path

import numpy as np
import pytest
from lopsided_sample import Lopsided, lopsided_bsdf
from test_wild_klems import radiance, run

from gonio.cli.main import run as gonio
from gonio.dataset.bsdf import Dataset, Side
from gonio.dataset.nexus import read_dataset
from gonio.formats.tensor.dataset import read_dataset as tree_dataset
from gonio.formats.tensor.read import read_tensor
from gonio.formats.tensor.write import write_tensor
from gonio.formats.validate import validate
from gonio.geometry.directions import unit_from_angles_deg

BOTH = {"Visible": "visible", "Solar": "solar"}
FUNCTION = "f(ix,iy,iz,ox,oy,oz) = .05 + .02*ox + .012*iy + .01*oy*ix + .006*iz - .004*oz;\n"


@pytest.fixture(scope="module")
def from_radiance(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """bsdf2ttree's tree of an affine function, four dimensions."""
    folder = tmp_path_factory.mktemp("radiance")
    (folder / "f.cal").write_text(FUNCTION)
    run(["bsdf2ttree", "-g", "4", "-t", "50", "+f", "+b", "-f", "f.cal", "f"], folder / "t4.xml", folder)
    return folder / "t4.xml"


def sums(dataset: Dataset, row: int) -> tuple[float, float]:
    """rho and tau."""
    d = dataset.distributions[row]
    energy = d.dsf_per_sr * d.solid_angle_sr
    same = (d.theta_deg < 90.0) == (d.incident_theta_deg < 90.0)
    return float(energy[same].sum()), float(energy[~same].sum())


@pytest.mark.judge
def test_bsdf2ttrees_output_is_good_for_radiance_and_none_for_window(from_radiance: Path) -> None:
    findings = validate(from_radiance, "radiance")
    assert findings.exit_status == 0
    assert {"basis-used", "sides", "column-sums", "reciprocity"} <= findings.codes
    assert [f.code for f in validate(from_radiance, "window").of("error")] == ["tree"]


@pytest.mark.judge
def test_what_is_asked_is_what_radiance_answers(from_radiance: Path) -> None:
    generator = np.random.default_rng(2)
    theta = np.degrees(np.arccos(generator.uniform(-0.95, 0.95, (40, 2))))
    phi = generator.uniform(0.0, 360.0, (40, 2))
    queries = np.column_stack((theta[:, 0], phi[:, 0], theta[:, 1], phi[:, 1]))
    bsdf, _ = read_tensor(from_radiance, "interior")
    incident, outgoing = (unit_from_angles_deg(queries[:, c], queries[:, c + 1]) for c in (0, 2))
    ours = bsdf.channels["visible"].bsdf_per_sr(incident, outgoing, np.arange(40))  # type: ignore[attr-defined]
    theirs = np.array(radiance(from_radiance, queries.tolist()))
    # Radiance shakes directions: a pair near a cell's edge may be in the next one.
    assert np.mean(np.abs(ours / theirs - 1.0) < 5e-4) > 0.9
    assert ours == pytest.approx(theirs, rel=0.2)


@pytest.mark.judge
def test_import_keeps_the_sums_and_the_values(from_radiance: Path, tmp_path: Path) -> None:
    dataset, remarks = tree_dataset(from_radiance, "interior", [(35.0, 20.0), (150.0, 310.0)])
    assert remarks == []
    bsdf, _ = read_tensor(from_radiance, "interior")
    for row, d in enumerate(dataset.distributions):
        incident = unit_from_angles_deg([d.incident_theta_deg], [d.incident_phi_deg])
        outgoing = unit_from_angles_deg(d.theta_deg, d.phi_deg)
        assert d.dsf_per_sr == pytest.approx(bsdf.channels["visible"].dsf_per_sr(incident, outgoing), rel=1e-9)
        for front in (True, False):
            side = (d.theta_deg < 90.0) == front
            assert d.solid_angle_sr[side].sum() == pytest.approx(2.0 * np.pi, rel=1e-6)
        # Evenly spread by projected solid angle: a plain mean is the integral over pi.
        generator = np.random.default_rng(3)
        across, azimuth = np.sqrt(generator.uniform(size=200000)), generator.uniform(0.0, 2.0 * np.pi, 200000)
        for front, found in zip(
            (d.incident_theta_deg < 90.0, d.incident_theta_deg > 90.0), sums(dataset, row), strict=True
        ):
            z = np.sqrt(1.0 - across**2) * (1.0 if front else -1.0)
            unit = np.stack((across * np.cos(azimuth), across * np.sin(azimuth), z), axis=-1)
            mean = np.mean(bsdf.channels["visible"].bsdf_per_sr(incident, unit))  # type: ignore[attr-defined]
            assert found == pytest.approx(np.pi * mean, rel=5e-3)
    assert (
        gonio(["import", str(from_radiance), "-o", str(tmp_path / "t.h5"), "--incident", "0,0", "--incident", "120,0"])
        == 0
    )
    read = read_dataset(tmp_path / "t.h5")
    assert [(d.incident_theta_deg, d.incident_phi_deg) for d in read.distributions] == [(0.0, 0.0), (120.0, 0.0)]
    assert read.distributions[0].integrals["rho_measured"] == pytest.approx(sums(read, 0)[0])
    assert len(tree_dataset(from_radiance)[0].distributions) == 2 * (1 + 8 * 8)


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_sample_without_symmetry_comes_back(tmp_path: Path, faces: Side, capsys: pytest.CaptureFixture[str]) -> None:
    """Model to tree to dataset: every side, left and right, up and down, within its coarse cells."""
    path = tmp_path / "a.xml"
    write_tensor(lopsided_bsdf(faces), path, dimensions=4, resolution=5, leaves=40000, channels=BOTH)
    incident = [(20.0, 100.0), (50.0, 340.0), (125.0, 30.0), (160.0, 200.0)]
    dataset, _ = tree_dataset(path, None, incident)
    assert dataset.front_faces == faces
    assert {d.channel for d in dataset.distributions} == {"visible", "solar"}
    for row, d in enumerate(dataset.distributions):
        truth = Lopsided(1.0 if d.channel == "visible" else 0.8)
        own = unit_from_angles_deg([d.incident_theta_deg], [d.incident_phi_deg])
        unit = unit_from_angles_deg(d.theta_deg, d.phi_deg)
        assert sums(dataset, row) == pytest.approx(
            [truth.integral(own[0], reflection=r) for r in (True, False)], rel=0.05
        )
        expected = truth.dsf_per_sr(own, unit)
        assert d.dsf_per_sr == pytest.approx(expected, rel=0.15)
        for turn in ([-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]):
            moved = truth.dsf_per_sr(own, unit * np.array(turn))
            assert np.abs(d.dsf_per_sr - expected).sum() < 0.5 * np.abs(d.dsf_per_sr - moved).sum()
    assert validate(path, "radiance").exit_status == 0
    assert gonio(["query", str(path), "--incident", "20,100", "--outgoing", "40,200"]) == 0
    value = float(capsys.readouterr().out.split()[1])
    own, unit = unit_from_angles_deg([20.0], [100.0]), unit_from_angles_deg([40.0], [200.0])
    assert value * np.cos(np.radians(40.0)) == pytest.approx(Lopsided().dsf_per_sr(own, unit)[0], rel=0.06)


def hand_written(path: Path, blocks: dict[tuple[str, str], str]) -> Path:
    """A tree of four dimensions; keys: wavelength, direction."""
    text = "".join(
        f"<WavelengthData><Wavelength>{band}</Wavelength><WavelengthDataBlock><WavelengthDataDirection>{direction}"
        "</WavelengthDataDirection><AngleBasis>LBNL/Shirley-Chiu</AngleBasis><ScatteringData>"
        f"{tree}</ScatteringData></WavelengthDataBlock></WavelengthData>"
        for (band, direction), tree in blocks.items()
    )
    path.write_text(
        "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>TensorTree4</IncidentDataStructure>"
        f"</DataDefinition>{text}</Layer></Optical></WindowElement>"
    )
    return path


def test_figures_of_trees_of_one_value(tmp_path: Path) -> None:
    """Lambertian: the sum is pi B, everything is reciprocal."""
    path = tmp_path / "t.xml"
    good = {
        (band, direction): "{.2}"
        for band in ("Visible", "Solar")
        for direction in ("Reflection Front", "Transmission Front", "Transmission Back")
    }
    good["Visible", "Transmission Front"] = good["Solar", "Transmission Front"] = "{.1}"
    findings = validate(hand_written(path, good), "radiance")
    messages = {f"{f.code} {f.where}": f.message for f in findings.items}
    assert findings.exit_status == 0
    assert "copied Solar" in messages
    assert "missing Visible Reflection Back" in messages
    rho, tau = f"reflection {0.2 * np.pi:.4f} to {0.2 * np.pi:.4f}", f"transmission {0.1 * np.pi:.4f}"
    assert rho in messages["column-sums Visible Front"]
    assert tau in messages["column-sums Visible Front"]
    assert messages["reciprocity Visible Reflection Front"].startswith("residual 0.00 %")
    assert messages["reciprocity Visible Transmission"].startswith(f"residual {100 * 0.1 / 0.15:.2f} %")
    bright = good | {("Visible", "Transmission Front"): "{.13}"}
    errors = validate(hand_written(path, bright), "radiance").of("error")
    assert [(e.code, e.where) for e in errors] == [("energy", "Visible Front")]
    assert f"{0.33 * np.pi:.4f}" in errors[0].message
    zeros = good | {("Visible", "Transmission Front"): "{0}"}
    assert "zeros" in validate(hand_written(path, zeros), "radiance").codes
    blind = {("Solar", "Reflection Front"): "{.2}"}
    assert [e.code for e in validate(hand_written(path, blind), "radiance").of("error")] == ["missing"]
    negative = {("Visible", "Reflection Front"): "{ .2 -.01 " + ".2 " * 14 + "}"}
    assert "negative" in validate(hand_written(path, negative), "radiance").codes
    dataset, _ = tree_dataset(hand_written(path, good), "interior", [(140.0, 30.0)])
    assert sums(dataset, 0) == pytest.approx((0.2 * np.pi, 0.1 * np.pi))


def test_a_direction_that_the_tree_has_not_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = hand_written(tmp_path / "t.xml", {("Visible", "Reflection Front"): "{.2}"})
    assert len(tree_dataset(path, "interior")[0].distributions) == 65
    out = str(tmp_path / "x.h5")
    assert gonio(["import", str(path), "-o", out, "--front", "interior", "--incident", "30,0"]) == 2
    assert "has nothing for light from (30, 0)" in capsys.readouterr().err
    assert gonio(["import", str(path), "-o", out, "--incident", "300,0"]) == 2
    assert "no direction" in capsys.readouterr().err
    assert not Path(out).exists()


def test_trees_of_three_dimensions_turn_with_the_light(tmp_path: Path) -> None:
    """A peak towards +x for light from -x comes out where the light goes, whatever the azimuth."""
    bsdf = lopsided_bsdf("interior")
    bsdf.channels = {"visible": Following()}
    bsdf.symmetry = "isotropic"
    path = tmp_path / "t3.xml"
    write_tensor(bsdf, path, dimensions=3, resolution=6, leaves=20000)
    incident = [(40.0, 0.0), (40.0, 75.0), (140.0, 200.0)]
    dataset, _ = tree_dataset(path, None, incident)
    for d in dataset.distributions:
        top = int(np.argmax(d.dsf_per_sr))
        towards = unit_from_angles_deg([d.theta_deg[top]], [d.phi_deg[top]])[0]
        own = unit_from_angles_deg([d.incident_theta_deg], [d.incident_phi_deg])[0]
        assert towards @ (own * np.array([-1.0, -1.0, 1.0])) > np.cos(np.radians(4.0))
    assert sums(dataset, 0) == pytest.approx(sums(dataset, 1), rel=1e-9)
    assert len(tree_dataset(path)[0].distributions) == 2 * 9


class Following(Lopsided):
    """A lobe of 8 degrees about the mirror direction, in reflection on both sides."""

    def dsf_per_sr(self, incident, outgoing, which=None):  # type: ignore[no-untyped-def]
        own = np.broadcast_to(incident[0], outgoing.shape) if which is None else incident[which]
        cosine = np.sum(own * np.array([-1.0, -1.0, 1.0]) * outgoing, axis=1)
        return 2.0 * np.exp((cosine - 1.0) / np.radians(8.0) ** 2) * (own[:, 2] * outgoing[:, 2] > 0.0)

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        return incident_front == outgoing_front
