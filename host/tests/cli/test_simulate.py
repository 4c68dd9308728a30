"""test_simulate.py: the command end to end: traced and closed-form samples, --like, equal bytes, wrong use, Ctrl-C."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gonio.cli import main
from gonio.dataset.bsdf import MASKED, Dataset, PointFlag
from gonio.dataset.nexus import read_dataset, write_dataset

WHITE = """
seed = 3
[sample]
kind = "lambertian"
reflectance = {{ visible = {reflectance}, near-infrared = 0.4 }}
[[band]]
name = "visible"
wavelength_nm = 550.0
[[band]]
name = "near-infrared"
wavelength_nm = 900.0
[photons]
count = 100000
[readings]
incident = [[0, 0], [50, 90]]
step_deg = 6
"""
CLOSED = "[sample]\ncomponents = [{ kind = 'lambertian', reflectance = 0.6, transmittance = 0.1 }]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds white.toml, traced, and sim.h5, what simulate made of it."""
    place = tmp_path_factory.mktemp("simulate")
    (place / "white.toml").write_text(WHITE.format(reflectance=0.6))
    assert main.run(["simulate", str(place / "white.toml"), "-o", str(place / "sim.h5")]) == 0
    return place


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_dataset_is_like_a_measurement(folder: Path) -> None:
    found = read_dataset(folder / "sim.h5")
    assert [(d.incident_theta_deg, d.incident_phi_deg, d.channel) for d in found.distributions] == [
        (0.0, 0.0, "visible"),
        (0.0, 0.0, "near-infrared"),
        (50.0, 90.0, "visible"),
        (50.0, 90.0, "near-infrared"),
    ]
    assert found.beam is not None
    assert found.beam.p_i == pytest.approx(1.0, abs=4.0 * found.beam.p_i_u_rel)
    for d in found.distributions:
        expected = 0.6 if d.channel == "visible" else 0.4
        assert d.wavelength_nm == (550.0 if d.channel == "visible" else 900.0)
        assert d.integrals["rho_measured"] == pytest.approx(expected, abs=4.0 * d.integrals["rho_u"])
        assert d.integrals["tau_measured"] == 0.0
        assert not [name for name in d.integrals if name.startswith("peak")]
        assert (d.flags & PointFlag.SIMULATED != 0).all()
        assert d.solid_angle_sr.sum() == pytest.approx(4.0 * np.pi)
        lit = d.dsf_per_sr > 0.0
        # Hits of equal weight: the relative variance is one over their number, less one over that of the photons.
        relative = d.variance_per_sr2[lit] / d.dsf_per_sr[lit] ** 2
        assert relative == pytest.approx(1.0 / d.count[lit] - 1e-5, abs=1e-6)
    simulation = found.provenance["simulation"]
    assert simulation["seed"] == 3
    assert simulation["scenario_text"] == (folder / "white.toml").read_text()
    for described in simulation["distributions"]:
        balance = described["balance"]
        assert balance["photons"] == 100_000
        assert balance["lost"] == 0
        assert balance["emitted"] + balance["roulette"] == balance["stored"] + balance["absorbed"]


def test_what_reads_measurements_reads_simulations(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sim = str(folder / "sim.h5")
    assert main.run(["export", sim, "--format", "csv", "-o", "sim.csv"]) == 0
    export = ["export", sim, "--format", "klems-full", "--channel", "visible", "--front", "exterior"]
    assert main.run([*export, "--fill", "nearest", "--assume-flat", "-o", "sim.xml"]) == 0
    assert main.run(["validate", "sim.xml"]) == 0
    assert main.run(["report", sim, "-o", "sim.html", "--summary", "sim.json"]) == 0
    assert main.run(["reduce", sim, "-o", "again.h5"]) == 0
    again, first = (read_dataset(Path(path)).distributions for path in ("again.h5", sim))
    assert [d.integrals for d in again] == [d.integrals for d in first]
    summary = json.loads(Path("sim.json").read_text())
    assert summary["distributions"][0]["integrals"]["rho_estimate"] == pytest.approx(0.6, abs=0.1)
    capsys.readouterr()


def test_the_same_bytes_on_any_threads_and_others_with_another_seed(folder: Path) -> None:
    simulate = ["simulate", str(folder / "white.toml"), "-o"]
    assert main.run([*simulate, "one.h5", "--threads", "1"]) == 0
    assert main.run([*simulate, "other.h5", "--seed", "4"]) == 0
    assert Path("one.h5").read_bytes() == (folder / "sim.h5").read_bytes()
    one, other = (read_dataset(Path(name)).distributions[0] for name in ("one.h5", "other.h5"))
    assert not np.array_equal(one.dsf_per_sr, other.dsf_per_sr)


def measured(source: Path, channel: str) -> Dataset:
    """As if it had been measured: one incident direction, not quite the planned one, some of its points shaded."""
    dataset = read_dataset(source)
    distribution = dataset.distributions[2]
    distribution.channel = channel
    distribution.flags = np.where(np.arange(len(distribution.flags)) % 5 == 0, PointFlag.SHADOWED, 0).astype(np.uint16)
    distribution.dsf_per_sr[distribution.flags != 0] = np.nan
    distribution.integrals = {"incident_measured_theta_deg": 50.01, "incident_measured_phi_deg": 89.99}
    dataset.distributions = [distribution]
    dataset.symmetry = "isotropic"
    return dataset


def test_like_a_measurement_point_by_point(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_dataset(measured(folder / "sim.h5", "visible"), Path("measured.h5"))
    simulate = ["simulate", str(folder / "white.toml"), "--like", "measured.h5", "-o", "sim.h5", "--json"]
    assert main.run([*simulate, "--photons", "50000"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["balance"]["photons"] == 50_000
    before, after = read_dataset(Path("measured.h5")), read_dataset(Path("sim.h5"))
    (was,), (now,) = before.distributions, after.distributions
    np.testing.assert_allclose(now.theta_deg, was.theta_deg, atol=1e-9)
    np.testing.assert_allclose(now.phi_deg, was.phi_deg, atol=1e-9)
    np.testing.assert_array_equal(now.solid_angle_sr, was.solid_angle_sr)
    np.testing.assert_array_equal(now.flags & MASKED, was.flags & MASKED)
    assert np.isnan(now.dsf_per_sr[was.flags != 0]).all()
    assert np.isfinite(now.dsf_per_sr[was.flags == 0]).all()
    assert (now.incident_theta_deg, now.incident_phi_deg, now.channel) == (50.0, 90.0, "visible")
    assert now.integrals["incident_measured_theta_deg"] == 50.01
    assert now.wavelength_nm == 550.0
    assert after.symmetry == "isotropic"
    assert after.beam is not None
    assert before.beam is not None
    np.testing.assert_allclose(after.beam.theta_deg, before.beam.theta_deg, atol=1e-9)


def test_a_channel_without_a_band(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_dataset(measured(folder / "sim.h5", "photopic"), Path("measured.h5"))
    simulate = ["simulate", "--like", "measured.h5", "-o", "sim.h5"]
    assert main.run([*simulate, str(folder / "white.toml")]) == 2
    assert '"photopic"' in capsys.readouterr().err
    Path("closed.toml").write_text(CLOSED)  # one band: it serves any channel, and that is said
    assert main.run([*simulate, "closed.toml"]) == 0
    assert 'channel "photopic" is simulated in the band "visible"' in capsys.readouterr().err


def test_photons_until_the_error_is_reached(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulate = [
        "simulate",
        str(folder / "white.toml"),
        "-o",
        "sim.h5",
        "--json",
        "--photons",
        "30000",
        "--error",
        "0.3",
    ]
    assert main.run(simulate) == 0
    report = json.loads(capsys.readouterr().out)
    for described in report["distributions"]:
        assert described["median_relative_error"] <= 0.3
        assert described["balance"]["photons"] > 30_000


def test_directions_that_miss_a_ridge_are_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    louver = Path(__file__).parents[3] / "sim" / "scenarios" / "photon" / "louver_v2.toml"
    coarse = louver.read_text().replace("[readings]", "[readings]\nstep_deg = 12")
    (folder / "coarse.toml").write_text(coarse)
    assert main.run(["simulate", str(folder / "coarse.toml"), "-o", "coarse.h5", "--photons", "100000"]) == 0
    assert "trust the photons" in capsys.readouterr().err
    assert main.run(["simulate", str(folder / "white.toml"), "-o", "white.h5"]) == 0
    assert "trust the photons" not in capsys.readouterr().err


def test_a_direction_without_a_photon_is_low_signal(folder: Path) -> None:
    (folder / "mirror.toml").write_text('[sample]\nkind = "mirror"\nreflectance = 0.5\n[readings]\nstep_deg = 12\n')
    assert main.run(["simulate", str(folder / "mirror.toml"), "-o", "mirror.h5", "--photons", "20000"]) == 0
    points = read_dataset(Path("mirror.h5")).distributions[0]
    dark = points.count == 0
    assert dark.any()
    assert np.all(points.flags[dark] & PointFlag.LOW_SIGNAL)
    assert read_dataset(Path("mirror.h5")).polarisation == "unpolarised"


def test_a_closed_form_is_exact(capsys: pytest.CaptureFixture[str]) -> None:
    Path("closed.toml").write_text(CLOSED + "[readings]\nincident = [[30, 0]]\nstep_deg = 5\n")
    assert main.run(["simulate", "closed.toml", "-o", "sim.h5"]) == 0
    assert "no photons" in capsys.readouterr().err
    (found,) = read_dataset(Path("sim.h5")).distributions
    assert found.integrals["rho_measured"] == pytest.approx(0.6, rel=2e-3)
    assert found.integrals["tau_measured"] == pytest.approx(0.1, rel=2e-3)
    assert not found.variance_per_sr2.any()
    assert main.run(["report", "sim.h5", "-o", "sim.html", "--scenario", "closed.toml"]) == 0


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (WHITE.format(reflectance=1.6), [], "reflectance"),
        ("[sample]\nkind = 'unheard-of'\n", [], "must be one of"),
        ("[sample]\nkind = ", [], "s.toml"),
        (
            "[sample]\nkind = 'sheet'\nmaterial = 'm'\n"
            "[materials.m]\nkind = 'tabulated'\nfile = 'm.h5'\nfollow = 'peak'\n",
            [],
            "m.h5: follow",
        ),
        (CLOSED, ["--photons", "5"], "closed form"),
        (CLOSED + "[readings]\nincident = [[200, 0]]\n", [], "readings.incident"),
        (CLOSED, ["--like", "none.h5"], "none.h5"),
        (CLOSED, ["--like", "s.toml"], "s.toml"),
        (CLOSED, ["--threads", "2", "--workers", "2"], "--threads"),
        (CLOSED, ["--scheduler", "tcp://h:1", "--workers", "2"], "choose one"),
        (CLOSED, ["--error", "7"], "--error"),
        (CLOSED, ["--seed", str(2**64)], "--seed"),
        (CLOSED, ["--photons", str(10**20)], "--photons"),
        (CLOSED, ["--threads", "100000"], "--threads"),
        ("[beam]\nkind = 'focused'\n", [], "no sample"),
        ("sample = 5\n", [], "[sample]"),
        (CLOSED.replace("components", "component"), [], "sample.component "),
        (CLOSED + "[reading]\nstep_deg = 5\n", [], "reading "),
        (CLOSED + "[band]\nname = 'visible'\n", [], "[[band]]"),
    ],
)
def test_wrong_use_is_one_line_and_status_2(
    text: str, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("s.toml").write_text(text)
    assert main.run(["simulate", "s.toml", "-o", "sim.h5", *options]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert words in captured.err
    assert not Path("sim.h5").exists()


def test_few_photons_make_no_peak_of_one_point(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    white = (folder / "white.toml").read_text().replace("step_deg = 6", "step_deg = 30")
    for seed in range(1, 5):
        Path("few.toml").write_text(white.replace("seed = 3", f"seed = {seed}"))
        assert main.run(["simulate", "few.toml", "-o", "few.h5", "--photons", "30"]) == 0
        assert "-0.0000%" not in capsys.readouterr().err


def test_a_traced_sample_has_no_truth_to_report(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["report", str(folder / "sim.h5"), "-o", "x.html", "--scenario", str(folder / "white.toml")]
    assert main.run(arguments) == 2
    assert "traced" in capsys.readouterr().err


def test_ctrl_c_stops_cleanly(folder: Path) -> None:
    code = (
        "import os, signal, sys\n"
        "from gonio.simulate.progress import PhotonProgress\n"
        "from gonio.cli import main\n"
        "at = PhotonProgress.at\n"
        "def at_and_stop(self, photons):\n"
        "    at(self, photons)\n"
        "    if photons > 0: os.kill(os.getpid(), signal.SIGINT)\n"
        "PhotonProgress.at = at_and_stop\n"
        "sys.exit(main.run(sys.argv[1:]))\n"
    )
    arguments = ["simulate", str(folder / "white.toml"), "-o", "sim.h5", "--photons", "1000000000000"]
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == main.INTERRUPTED
    assert done.stderr.count("\n") == 1
    assert "interrupted" in done.stderr
    assert not os.listdir()


def test_the_command_brings_in_dask_only_where_it_is_asked_for(folder: Path) -> None:
    code = (
        "import sys; from gonio.cli import main;"
        "status = main.run(['simulate', sys.argv[1], '-o', 'sim.h5', '--photons', '1000']);"
        "assert status == 0 and not {'dask', 'distributed', 'matplotlib'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder / "white.toml")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
