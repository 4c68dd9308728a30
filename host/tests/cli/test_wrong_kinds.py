"""test_wrong_kinds.py: what commands say to a file of another kind: what it is, and what to do."""

from pathlib import Path

import pytest
from sampled_points import two_lobes

from gonio.cli.main import run
from gonio.dataset.nexus import write_dataset

_XML = '<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"/>'
_FILES = {
    "raw.mcap": b"\x89MCAP0\r\n" + bytes(40),
    "k.xml": _XML.encode(),
    "p.csv": b"theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,dsf_per_sr\n0,0,10,0,0.3\n",
    "notes.txt": b"nothing of that\n",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("kinds")
    for name, content in _FILES.items():
        (place / name).write_bytes(content)
    write_dataset(two_lobes((10.0, 40.0)), place / "points.h5")
    assert (
        run(["fit", "lambertian", str(place / "points.h5"), "--symmetry", "isotropic", "-o", str(place / "m.h5")]) == 0
    )
    return place


@pytest.mark.parametrize(
    ("command", "file", "words"),
    [
        ("fit", "raw.mcap", "is a raw log: gonio reduce"),
        ("fit", "k.xml", "is BSDF XML: gonio import"),
        ("fit", "p.csv", "is a table of points: gonio import"),
        ("fit", "m.h5", "is a fitted model"),
        ("fit", "notes.txt", "is no dataset"),
        ("fit", "abg", "fit abg: name the dataset"),
        ("report", "m.h5", "is a fitted model"),
        ("report", "k.xml", "is BSDF XML"),
        ("validate", "points.h5", "not readable as XML"),
    ],
)
def test_one_line_says_what_it_is(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    file: str,
    words: str,
) -> None:
    monkeypatch.chdir(folder)
    assert run([command, file, *([] if command == "validate" else ["-o", "out.h5"])]) == 2
    err = capsys.readouterr().err
    assert err.startswith("gonio: ")
    assert words in err
    assert err.count("\n") == 1
    assert not (folder / "out.h5").exists()


def test_a_model_keeps_the_symmetry_of_its_fit(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["query", str(folder / "m.h5"), "--incident", "30,0", "--outgoing", "20,0"]
    assert run([*asked, "--symmetry", "isotropic"]) == 0
    capsys.readouterr()
    assert run([*asked, "--symmetry", "none"]) == 2
    assert "was fitted as isotropic" in capsys.readouterr().err
