"""test_exchange.py: import and export on the command line: formats told apart, P_i, sets of files, one-line errors."""

import csv
from pathlib import Path

import numpy as np
import pytest

from gonio.cli import main
from gonio.dataset.nexus import read_dataset

SCAN = '#sample_name "tile"\n#incident_angle 30 90\n#upphi 90\n#stage: B\n#format: theta phi {}\n'
ROWS = "10\t20\t{0}e-3\n40.5\t270\t{0}.25e-2\n60\t100.125\t-{0}e-5\n50\t30\t2e-3\n"
NIST = "lambda,thetai,phi,thetar,phir,f_r11\n0.633,-30,0,20,180,3.10E-01\n0.633,-30,0,40,-90.5,3.20E-01\n"
CSV = "theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,dsf_per_sr\n30,0,20,180,0.3\n"


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(name: str, text: str) -> str:
    Path(name).write_text(text)
    return name


def one_line(capsys: pytest.CaptureFixture[str]) -> str:
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err


def scans(quantity: str = "DSF") -> list[str]:
    front = write("front.dat", SCAN.format(quantity) + ROWS.format(1))
    back = write("back.dat", SCAN.format(quantity).replace("stage: B", "stage: C") + "170 350 7e-4\n")
    other = write("other.dat", SCAN.format(quantity).replace("30 90", "45 180") + ROWS.format(3))
    return [front, back, other]


def test_pab_files_become_one_dataset_and_the_same_files_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["import", *scans(), "-o", "x.h5"]) == 0
    dataset = read_dataset(Path("x.h5"))
    assert dataset.sample_name == "tile"
    assert [(d.incident_theta_deg, d.incident_phi_deg, len(d.theta_deg)) for d in dataset.distributions] == [
        (30, 90, 5),
        (45, 180, 4),
    ]
    capsys.readouterr()
    assert main.run(["export", "x.h5", "--format", "pab", "-o", "set"]) == 2
    assert "--front" in one_line(capsys)
    assert not Path("set").exists()
    assert main.run(["export", "x.h5", "--format", "pab", "--front", "interior", "-o", "set"]) == 0
    captured = capsys.readouterr()
    names = ["front_reflection_t30_p90.txt", "front_transmission_t30_p90.txt", "front_reflection_t45_p180.txt"]
    assert captured.out.split() == [str(Path("set") / name) for name in names]
    assert "single incident direction in front_transmission" in captured.err
    text = Path("set", names[0]).read_text().splitlines()
    rows = [tuple(float(word) for word in line.split()) for line in text if not line.startswith("#")]
    assert rows == [tuple(float(word) for word in line.split()) for line in ROWS.format(1).splitlines()]
    assert "#stage: B" in text
    assert "#stage: C" in Path("set", names[1]).read_text().splitlines()
    assert main.run(["export", "x.h5", "--format", "pab", "--front", "interior", "-o", "named.txt"]) == 0
    assert capsys.readouterr().out.split() == [f"named_{name}" for name in names]
    assert main.run(["export", "x.h5", "--format", "pab", "--front", "interior", "-o", "none/set"]) == 2
    assert "no folder none" in one_line(capsys)


def test_a_raw_scan_waits_for_p_i(capsys: pytest.CaptureFixture[str]) -> None:
    files = scans("photocurrent A")
    assert main.run(["import", *files, "-o", "raw.h5", "--sample-name", "another"]) == 0
    assert "not normalised: give --beam or --p-i" in capsys.readouterr().err
    raw = read_dataset(Path("raw.h5"))
    assert raw.sample_name == "another"
    assert all(d.signal_unit == "A" and np.isnan(d.p_i) for d in raw.distributions)
    for kind in ("csv", "nist", "klems-full"):
        assert main.run(["export", "raw.h5", "--format", kind, "--front", "interior", "-o", "y"]) == 2
        assert "raw signal (unit A), not normalised" in one_line(capsys)
    assert main.run(["export", "raw.h5", "--format", "pab", "--front", "interior", "-o", "set"]) == 0
    assert "#format: theta phi photocurrent A\n" in Path("set", "front_reflection_t30_p90.txt").read_text()
    assert main.run(["import", *files, "-o", "dsf.h5", "--p-i", "2.0"]) == 0
    np.testing.assert_allclose(
        read_dataset(Path("dsf.h5")).distributions[1].dsf_per_sr, raw.distributions[1].signal / 2
    )
    x, y = np.meshgrid(np.linspace(-2, 2, 41), np.linspace(-2, 2, 41))
    polar, value = np.hypot(x, y), np.exp(-0.5 * (np.hypot(x, y) / 0.4) ** 2)
    lines = zip(180 - polar.ravel(), np.degrees(np.arctan2(y, x)).ravel(), value.ravel(), strict=True)
    beam = SCAN.format("A") + "\n".join(f"{t:.9f} {p:.9f} {v:.9e}" for t, p, v in lines)
    write("beam.dat", beam)
    assert main.run(["import", *files, "-o", "beam.h5", "--beam", "beam.dat"]) == 0
    found = read_dataset(Path("beam.h5"))
    assert found.distributions[0].p_i == pytest.approx(2 * np.pi * np.radians(0.4) ** 2, rel=2e-3)
    assert found.beam is not None
    assert found.beam.signal_unit == "A"


@pytest.mark.parametrize("kind", ["auto", "named"])
def test_formats_are_told_apart_by_content(kind: str) -> None:
    """Names say nothing: all are called .dat."""
    for name, text, again in (("nist", NIST, True), ("csv", CSV, False)):
        source = write(f"{name}.dat", text)
        named = [] if kind == "auto" else ["--format", name]
        assert main.run(["import", source, "-o", f"{name}.h5", *named]) == 0
        if again:
            assert main.run(["export", f"{name}.h5", "--format", name, "-o", "again.dat"]) == 0
            assert Path("again.dat").read_text() == text
    assert read_dataset(Path("csv.h5")).distributions[0].dsf_per_sr.tolist() == [0.3]
    assert main.run(["export", "nist.h5", "--format", "csv", "-o", "n.csv"]) == 0
    assert main.run(["import", "n.csv", "-o", "n.h5"]) == 0
    first, second = (read_dataset(Path(name)).distributions[0] for name in ("nist.h5", "n.h5"))
    assert first.dsf_per_sr.tolist() == second.dsf_per_sr.tolist()
    assert (second.channel, second.wavelength_nm) == ("633 nm", 633.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["front.dat", "nist.dat"], "different formats (nist, pab)"),
        (["nist.dat", "csv.dat", "--format", "nist"], "one table at a time"),
        (["front.dat", "--p-i", "1"], "normalised already"),
        (["nist.dat", "--p-i", "1"], "normalised already"),
        (["raw.dat", "--p-i", "1", "--beam", "front.dat"], "both state P_i"),
        (["raw.dat", "--beam", "none.dat"], "none.dat: no such file"),
        (["raw.dat", "--p-i", "nan"], "P_i is nan"),
        (["else.dat"], "is neither pab text"),
        (["nist.dat", "--format", "pab"], "is no pab text"),
        (["front.dat", "front.dat"], "same file"),
        ([], "FILE"),
    ],
)
def test_wrong_imports_are_one_line_and_leave_nothing(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scans()
    write("raw.dat", SCAN.format("A") + ROWS.format(1))
    write("nist.dat", NIST)
    write("csv.dat", CSV)
    write("else.dat", "once upon a time\n")
    assert main.run(["import", *arguments, "-o", "x.h5"]) == 2
    assert words in one_line(capsys)
    assert not list(Path().glob("*.h5"))


def test_the_uncertainty_of_patches_is_a_second_file(capsys: pytest.CaptureFixture[str]) -> None:
    theta, phi = (grid.ravel() for grid in np.meshgrid(np.arange(2.5, 90, 5), np.arange(0.0, 360, 15)))
    rows = [f"30,0,{t},{p},{0.2 * np.cos(np.radians(t)):.6f},0.001,0.004" for t, p in zip(theta, phi, strict=True)]
    header = "theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,dsf_per_sr,u_dsf_per_sr,u_combined_per_sr"
    write("points.csv", "\n".join([header, *rows]))
    assert main.run(["import", "points.csv", "-o", "points.h5"]) == 0
    assert main.run(["reduce", "points.h5", "-o", "x.h5"]) == 0
    capsys.readouterr()
    export = ["export", "x.h5", "--front", "interior", "-o", "x.xml"]
    assert main.run([*export, "--format", "csv", "--uncertainty", "u.csv"]) == 2
    assert "goes with a klems format" in one_line(capsys)
    assert main.run([*export, "--format", "klems-half", "--uncertainty", "u.csv"]) == 2
    assert "give --fill none or --fill nearest" in one_line(capsys)
    export += ["--fill", "none"]
    assert main.run([*export, "--format", "klems-half", "--uncertainty", "x.xml"]) == 2
    assert "named twice" in one_line(capsys)
    assert main.run([*export, "--format", "klems-half", "--uncertainty", "u.csv"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "x.xml\nu.csv\n"
    assert "largest relative standard uncertainty" in captured.err
    table = list(csv.DictReader(line for line in Path("u.csv").read_text().splitlines() if not line.startswith("#")))
    assert len(table) == 77  # one incident patch
    values = np.array([[float(row[c]) for c in ("bsdf_per_sr", "u_per_sr", "stated per_sr")] for row in table])
    np.testing.assert_allclose(values[:, 0], 0.2, rtol=0.03)
    # What is stated as systematic stays whole in a mean; noise averages out.
    u_point = np.sqrt(0.004**2 - 0.001**2) / np.cos(np.radians([float(row["outgoing_theta_deg"]) for row in table]))
    np.testing.assert_allclose(values[:65, 2], u_point[:65], rtol=0.1)
    assert (values[:, 1] < 1.02 * values[:, 2] + 2e-4).all()
