"""test_export_model.py: export of datasets through the fitted model and of models, from the command line."""

import csv
from pathlib import Path

import numpy as np
import pytest
from synthetic_bsdf import distribution, lambert_and_mirror, sphere_points

from gonio.cli import main
from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.formats.tensor.write import DEFAULT_RESOLUTION
from gonio.formats.window.read import read


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("export")
    write_dataset(lambert_and_mirror((10.0, 40.0, 60.0), coarse=1500), made / "bsdf.h5")
    assert main.run(["fit", str(made / "bsdf.h5"), "-o", str(made / "model.h5")]) == 0
    rng = np.random.default_rng(1)
    units = sphere_points(1500)
    units = units[rng.permutation(len(units))]
    parts = [
        distribution((theta, 0.0), units, lambda u, r=rho: r / np.pi * np.maximum(u[:, 2], 0.0), channel=name)
        for name, rho in (("visible", 0.2), ("nir", 0.5))
        for theta in (0.0, 60.0)
    ]
    write_dataset(Dataset(parts, front_faces="interior", symmetry="isotropic"), made / "two.h5")
    return made


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def run(*arguments: str | Path) -> int:
    return main.run([str(a) for a in arguments])


def test_the_model_is_the_default(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    export = ["export", folder / "bsdf.h5", "--format", "klems-half", "--assume-flat"]
    assert run(*export, "-o", "x.xml", "--cells", "x.csv") == 0
    captured = capsys.readouterr()
    assert captured.out == "x.xml\nx.csv\n"
    written = read(Path("x.xml"))
    remarks = [line.removeprefix("gonio: ") for line in captured.err.splitlines()]
    assert "Visible: not measured, zeros: Transmission Back, Reflection Back." in remarks
    assert any("outgoing cells measured/interpolated/extrapolated/absent" in line for line in remarks)
    for line in remarks:
        assert line in written.text["Comments"]
    assert "gonio-validity:" in written.text["Comments"]
    rho = written.hemispherical("Visible", "Reflection", "Front")
    np.testing.assert_allclose(rho[1:], 0.7, atol=0.01)  # all incident patches, not the measured ones alone
    np.testing.assert_allclose(written.hemispherical("Visible", "Transmission", "Front"), 0.1, atol=0.002)
    with Path("x.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    kinds = {r["origin"] for r in rows if (r["process"], r["light_from"]) == ("Reflection", "Front")}
    assert kinds == {"measured", "interpolated", "extrapolated"}
    assert run("validate", "x.xml", "--profile", "radiance") == 0


def test_a_model_file_gives_the_same_matrices(folder: Path) -> None:
    for name in ("bsdf", "model"):
        assert run("export", folder / f"{name}.h5", "--format", "klems-quarter", "-o", f"{name}.xml") == 0
    first, second = (read(Path(f"{name}.xml")).matrices for name in ("bsdf", "model"))
    assert first.keys() == second.keys()
    for key, values in first.items():
        np.testing.assert_allclose(second[key], values, rtol=1e-5, atol=1e-9)


def test_solar_from_the_channels(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    export = ["export", folder / "two.h5", "--format", "klems-quarter", "-o", "x.xml"]
    assert run(*export) == 0
    assert not read(Path("x.xml")).matrices["Solar", "Reflection", "Back"].any()
    assert run(*export, "--solar-spectrum", "astm-g173", "--solar-band", "nir=780-1100") == 0
    assert "780-1100 nm" in capsys.readouterr().err
    written = read(Path("x.xml"))
    assert "ASTM G173-03" in written.text["Comments"]
    visible, solar = (written.hemispherical(band, "Reflection", "Back") for band in ("Visible", "Solar"))  # type: ignore[arg-type]
    np.testing.assert_allclose(visible, 0.2, atol=2e-3)
    share = (solar - 0.2) / 0.3  # of the near infrared: 0.245 of 0.245 + 0.552
    np.testing.assert_allclose(share, 0.31, atol=0.015)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--fill", "model", "--uncertainty", "u.csv"], "--fill none or --fill nearest"),
        (["--fill", "none", "--cells", "c.csv"], "--cells goes with --fill model"),
        (["--fill", "nearest", "--rescale"], "--rescale goes with --fill model"),
        (["--material", "m.rad"], "--material goes with tensor3"),
        (["--incident", "30,0"], "csv, pab and nist"),
        (["--solar-band", "visible=380-780"], "goes with --solar-spectrum"),
        (["--solar-spectrum", "astm-g173"], "--assume-flat"),
        (["--solar-spectrum", "astm-g173", "--assume-flat"], "give one of them"),
        (["--solar-spectrum", "astm-g173", "--solar-band", "visible"], "write CHANNEL=FROM-TO"),
        (["--xyz", "X=a,Y=b"], "write X=CHANNEL,Y=CHANNEL,Z=CHANNEL"),
        (["--xyz", "X=a,Y=b,Z=c"], "no channel 'a'"),
        (["--channel", "blue"], "no channel 'blue'"),
        (["--cells", "x.xml"], "named twice"),
    ],
)
def test_wrong_options_are_one_line(
    folder: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("export", folder / "model.h5", "--format", "klems-full", "-o", "x.xml", *arguments) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert not list(Path().iterdir())


def test_what_needs_a_dataset_or_a_symmetry_says_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    klems = ["--format", "klems-quarter", "-o", "x.xml"]
    assert run("export", folder / "model.h5", *klems, "--fill", "nearest") == 2
    assert "is no dataset" in capsys.readouterr().err
    undeclared = lambert_and_mirror((30.0,), coarse=800)
    undeclared.symmetry = "undeclared"
    write_dataset(undeclared, Path("undeclared.h5"))
    assert run("export", "undeclared.h5", *klems) == 2
    assert "--symmetry" in capsys.readouterr().err
    assert run("export", "undeclared.h5", *klems, "--symmetry", "isotropic") == 0
    assert run("export", "x.xml", "--format", "klems-full", "-o", "y.xml") == 2
    assert "gonio convert" in capsys.readouterr().err


def test_points_of_a_model(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = folder / "model.h5"
    assert run("export", model, "--format", "csv", "-o", "x.csv", "--incident", "30,90", "--step", "5") == 0
    assert "flagged as simulated" in capsys.readouterr().err
    rows = list(csv.DictReader(line for line in Path("x.csv").read_text().splitlines() if not line.startswith("#")))
    assert len(rows) == 36 * 72
    assert {(r["theta_i_deg"], r["phi_i_deg"], r["flags"]) for r in rows} == {("30", "90", "simulated")}
    behind = [r for r in rows if float(r["theta_s_deg"]) > 90]
    tau = sum(float(r["dsf_per_sr"]) * float(r["solid_angle_sr"]) for r in behind)
    assert tau == pytest.approx(0.1, abs=0.002)
    brightest = max(rows, key=lambda r: float(r["dsf_per_sr"]))
    assert abs(float(brightest["theta_s_deg"]) - 30.0) <= 2.5
    assert float(brightest["phi_s_deg"]) == 270.0
    assert run("export", model, "--format", "pab", "-o", "set") == 0
    assert len(list(Path("set").glob("*.txt"))) == 6  # 10, 40, 60 degrees; reflection and transmission
    capsys.readouterr()
    assert run("export", model, "--format", "csv", "-o", "y.csv", "--step", "7") == 2
    assert "does not divide" in capsys.readouterr().err
    assert run("export", model, "--format", "csv", "-o", "y.csv", "--incident", "30") == 2
    assert "THETA,PHI" in capsys.readouterr().err


def test_trees_go_to_their_writer(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    export = ["export", folder / "model.h5", "--format", "tensor3", "--resolution", "4", "-o", "t.xml"]
    assert run(*export, "--material", "t.rad", "--cells", "t.csv", "--leaves", "2000") == 0
    assert capsys.readouterr().out == "t.xml\nt.rad\nt.csv\n"
    assert "TensorTree3" in Path("t.xml").read_text()
    assert "t.xml" in Path("t.rad").read_text()
    assert run("query", "t.xml", "--incident", "40,0", "--outgoing", "20,90") == 0


def test_points_of_a_model_are_read_again(folder: Path) -> None:
    """A model has no uncertainty: its table has no column for it, and is read as one that has none."""
    export = ["export", folder / "model.h5", "--format", "csv", "-o", "x.csv", "--incident", "40,0", "--step", "5"]
    assert run(*export) == 0
    rows = list(csv.DictReader(line for line in Path("x.csv").read_text().splitlines() if not line.startswith("#")))
    assert not {"u_dsf_per_sr", "u_combined_per_sr"} & rows[0].keys()
    assert run("import", "x.csv", "-o", "x.h5") == 0
    (back,) = read_dataset(Path("x.h5")).distributions
    assert (back.flags == PointFlag.SIMULATED).all()
    assert back.dsf_per_sr.tolist() == [float(row["dsf_per_sr"]) for row in rows]


def of_wavelengths() -> Dataset:
    """Lambertian at two wavelengths, with a little light through it."""
    units = sphere_points(1500)
    parts = [
        distribution((theta, 0.0), units, lambda u: 1e-3 + 0.9 / np.pi * np.maximum(u[:, 2], 0.0), channel=f"{nm:g} nm")
        for nm in (351.0, 633.0)
        for theta in (10.0, 50.0)
    ]
    for part in parts:
        part.wavelength_nm = float(part.channel.split()[0])
    return Dataset(parts, front_faces="interior", symmetry="isotropic")


@pytest.mark.parametrize("family", [[], ["lambertian"]])
def test_a_wavelength_goes_through_the_model(family: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    write_dataset(of_wavelengths(), Path("p.h5"))
    assert run("fit", *family, "p.h5", "-o", "pm.h5") == 0
    export = ["export", "pm.h5", "--channel", "633 nm"]
    assert run(*export, "--format", "nist", "-o", "n.csv", "--incident", "30,0", "--step", "10") == 0
    rows = [line.split(",") for line in Path("n.csv").read_text().splitlines()[1:]]
    assert len(rows) == 9 * 36
    assert {float(row[0]) for row in rows} == {0.633}
    assert np.median([float(row[5]) for row in rows]) == pytest.approx(0.9 / np.pi, rel=0.01)
    capsys.readouterr()
    solar = ["export", "pm.h5", "--format", "klems-quarter", "-o", "s.xml", "--solar-spectrum", "astm-g173"]
    assert run(*solar) == 2
    said = capsys.readouterr().err
    assert "351 nm, 633 nm: of one wavelength each" in said
    assert "--solar-band '351 nm=FROM-TO'" in said
    assert said.count("\n") == 1
    bands = ["--solar-band", "351 nm=300-500", "--solar-band", "633 nm=500-2500"]
    assert run(*solar, *bands, "--channel", "633 nm") == 0


def test_the_default_resolution_is_the_formats(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Cells of four dimensions are many: a finer default would take minutes."""
    write_dataset(of_wavelengths(), Path("p.h5"))
    assert run("fit", "lambertian", "p.h5", "--channel", "633 nm", "-o", "pm.h5") == 0
    capsys.readouterr()
    small = ["--size-mb", "0.03"]
    for kind, said in (("tensor3", "resolution 7"), ("tensor4", "resolution 5")):
        assert run("export", "pm.h5", "--format", kind, *small, "-o", f"{kind}.xml") == 0
        captured = capsys.readouterr().err
        assert said in captured
        assert ("(tensor3) hold all of it" in captured) == (kind == "tensor4")  # the sample is isotropic
    assert run("convert", "tensor3.xml", "--format", "tensor3", *small, "-o", "again.xml") == 0
    assert "resolution 7" in capsys.readouterr().err
    assert run("export", folder / "two.h5", "--format", "csv", "-o", "x.csv", "--resolution", "5") == 2
    assert "--resolution goes with tensor3" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["export", "convert"])
def test_help_names_the_default_resolutions(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(command, "--help") == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert f"tensor3 {DEFAULT_RESOLUTION[3]}, tensor4 {DEFAULT_RESOLUTION[4]}" in text
