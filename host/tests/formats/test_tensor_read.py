"""test_tensor_read.py: tensor trees as found in the wild, odd ones and hostile ones."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pyradiance
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lopsided import ask_radiance

from benchmarks.models.samples import RetroCoating
from gonio.dataset.scattering import Bsdf
from gonio.formats.tensor.flat import parse
from gonio.formats.tensor.read import is_tensor, read_tensor
from gonio.formats.tensor.write import write_tensor
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

ROOT = Path(pyradiance.__file__).parent
DOCUMENT = (
    '<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><Material><Name>a</Name>'
    '<Thickness unit="Meter">.002</Thickness></Material><DataDefinition><IncidentDataStructure>TensorTree{d}'
    "</IncidentDataStructure></DataDefinition><WavelengthData><Wavelength>{w}</Wavelength><WavelengthDataBlock>"
    "<WavelengthDataDirection>{c}</WavelengthDataDirection><AngleBasis>{b}</AngleBasis><ScatteringData>{t}"
    "</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
)


def document(path: Path, text: str, d: int = 3, **words: str) -> Path:
    given = {"w": "Visible", "c": "Reflection Back", "b": "LBNL/Shirley-Chiu", **words}
    path.write_text(DOCUMENT.format(d=d, t=text, **given))
    return path


@pytest.mark.judge
@pytest.mark.parametrize("kind", ["-t3", "-t4"])
def test_what_bsdf2ttree_writes(tmp_path: Path, kind: str) -> None:
    """Radiance's own program on a lopsided function; values equal Radiance's reading of the file."""
    path = tmp_path / "theirs.xml"
    function = "f(ix,iy,iz,ox,oy,oz) = .1 + .05*ox + exp(-20*((ox+ix)^2 + (oy+iy)^2))"
    if kind == "-t4":
        function = "f(ix,iy,iz,ox,oy,oz) = .1 + .05*ox*oy + .03*iy + exp(-20*((ox-iy)^2 + (oy+.5*ix)^2))"
    command = [
        str(ROOT / "bin" / "bsdf2ttree"),
        kind,
        "-g",
        "4",
        "-t",
        "70",
        "+forward",
        "+backward",
        "-e",
        function,
        "f",
    ]
    environment = {**os.environ, "PATH": f"{ROOT / 'bin'}:{os.environ['PATH']}", "RAYPATH": str(ROOT / "lib")}
    done = subprocess.run(command, capture_output=True, check=True, env=environment, cwd=tmp_path)
    path.write_bytes(done.stdout)
    assert is_tensor(path)
    bsdf, findings = read_tensor(path, "interior")
    assert not [item for item in findings.items if item.severity == "error"]
    rng = np.random.default_rng(3)
    angles = np.column_stack(
        [rng.uniform(0, 180, 60), rng.uniform(0, 360, 60), rng.uniform(0, 180, 60), rng.uniform(0, 360, 60)]
    )
    own = bsdf.channels["visible"]
    incident, outgoing = (unit_from_angles_deg(angles[:, c], angles[:, c + 1]) for c in (0, 2))
    values = own.dsf_per_sr(incident, outgoing, np.arange(60)) / np.abs(outgoing[:, 2])
    there = ~np.isnan(values)
    assert there.any()
    found = np.array(ask_radiance(path, angles[there].tolist())["values"])
    # Radiance takes a constant part off and puts it back, in single precision.
    np.testing.assert_allclose(values[there], found, rtol=5e-4, atol=2e-6)


def test_branches_grids_and_single_leaves_by_hand(tmp_path: Path) -> None:
    """A branch's parts count with bit 0 for the first coordinate, a grid's values with the last coordinate fastest."""
    text = "{ {1} {9} {2 3 4 5\n6 7 8 10} {9} {11}, {9} {12,} {9} }"
    bsdf, findings = read_tensor(document(tmp_path / "hand.xml", text), "interior")
    own = bsdf.channels["visible"]
    assert bsdf.symmetry == "isotropic"
    assert bsdf.thickness_mm == pytest.approx(2.0)
    assert not findings.items
    place = np.array(
        [[0.1, 0.2, 0.2], [0.1, 0.6, 0.1], [0.3, 0.6, 0.3], [0.3, 0.9, 0.1], [0.1, 0.3, 0.7], [0.4, 0.9, 0.9]]
    )
    tree = next(iter(own.trees.values()))
    np.testing.assert_array_equal(tree.at(place), [1, 2, 7, 8, 11, 12])
    assert tree.resolution == 2


def test_features_name_the_bright_cells(tmp_path: Path) -> None:
    path = tmp_path / "t3.xml"
    sample = Bsdf({"visible": RetroCoating()}, front_faces="exterior", symmetry="isotropic")
    write_tensor(sample, path, dimensions=3, resolution=6, leaves=20000)
    bsdf, _ = read_tensor(path)
    own = bsdf.channels["visible"]
    incident = unit_from_angles_deg([30.0, 55.0], [20.0, 200.0])
    peaks = own.features(incident)
    rng = np.random.default_rng(5)
    outgoing = rng.normal(size=(40000, 3))
    outgoing /= np.linalg.norm(outgoing, axis=1, keepdims=True)
    for row in (0, 1):
        dsf = own.bsdf_per_sr(incident[row : row + 1], outgoing)
        brightest = outgoing[np.nanargmax(dsf)]
        nearest = np.max(peaks.centre[peaks.incident == row] @ brightest)
        assert np.degrees(np.arccos(nearest)) < 3.0
        at = own.bsdf_per_sr(incident[row : row + 1], peaks.centre[peaks.incident == row])
        assert at.max() >= 0.999 * np.nanmax(dsf)


def test_oddities_become_findings(tmp_path: Path) -> None:
    path = document(tmp_path / "odd.xml", "{-1}", w="visible", c="Reflectance Back", b="")
    bsdf, findings = read_tensor(path)
    assert {item.code for item in findings.items} == {"label", "basis", "negative"}
    up = unit_from_angles_deg([180.0], [0.0])
    assert bsdf.channels["visible"].dsf_per_sr(up, up)[0] == 0.0
    assert np.isnan(bsdf.channels["visible"].dsf_per_sr(-up, -up)[0])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "braces"),
        ("{1", "braces"),
        ("{1}}{", "braces"),
        ("{1}{2}", "braces"),
        ("5 {1}", "before or behind"),
        ("{1} 5", "before or behind"),
        ("{1 2}", "no power of 8"),
        ("{}", "no power of 8"),
        ("{ {1} {2} }", "has not 8 parts"),
        ("{ 1 {1} {2} {3} {4} {5} {6} {7} {8} }", "mixed"),
        ("{nan}", "not finite"),
        ("{1e999}", "not finite"),
        ("{x}", "no number"),
        ("{" * 40 + "1" + "}" * 40, "deeper"),
        ("{1é}", "characters"),
    ],
)
def test_damaged_trees_are_refused_in_one_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(UsageError, match=says) as caught:
        read_tensor(document(tmp_path / "bad.xml", text))
    assert "\n" not in str(caught.value)


def test_other_files_are_no_tensor_trees(tmp_path: Path) -> None:
    path = tmp_path / "klems.xml"
    path.write_text(DOCUMENT.replace("TensorTree{d}", "Columns"))
    assert not is_tensor(path)
    assert not is_tensor(tmp_path / "missing.xml")
    with pytest.raises(UsageError, match="no tensor tree"):
        read_tensor(path)


@given(st.text(alphabet="{}0123456789. ,e-\n", max_size=80), st.sampled_from([3, 4]))
def test_any_text_is_a_tree_or_one_line(text: str, dimensions: int) -> None:
    said = ""
    try:
        tree, _ = parse(text, dimensions, "x")
    except UsageError as error:
        said = str(error)
    else:
        assert np.isfinite(tree.at(np.full((3, dimensions), 0.4))).all()
    assert "\n" not in said
