"""test_sharpened.py: a whole dataset deconvolved, through the command: what it writes, says and refuses."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from signature_scene import beam_scan, distribution, spiral, truth_of
from typer.testing import CliRunner

from gonio.cli.main import app, run
from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.geometry.directions import mirror
from gonio.reduce.signature import deconvolve as deconvolution
from gonio.reduce.signature.sharpened import sharpened
from gonio.units.errors import UsageError

LOBE = '{ kind = "gaussian", about = "mirror", sigma_deg = 1.2, integral = 0.2 }'
INCIDENT = (30.0, 40.0)
HEIGHT = 0.2 / (2.0 * np.pi * np.radians(1.2) ** 2)


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    truth = truth_of(tmp_path_factory.mktemp("sharpened"), LOBE)
    theta_deg, phi_deg = (float(angle) for angle in mirror(*INCIDENT))
    unit = spiral((theta_deg, phi_deg), 4.5, 0.3, 0.15)
    lobe = distribution(INCIDENT, unit, truth.dsf_per_sr(*INCIDENT, unit), noise_per_sr=0.5)
    bare = distribution((60.0, 0.0), unit, np.zeros(len(unit)))  # nothing was flown about its mirror direction
    return Dataset([lobe, bare], sample_name="lobe", beam=beam_scan(truth)[1])


def test_the_command_writes_the_sharper_peak_and_says_its_noise(
    measured: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deconvolution, "_MOST_CELLS", 400)
    write_dataset(measured, tmp_path / "seen.h5")
    done = CliRunner().invoke(app, ["deconvolve", str(tmp_path / "seen.h5"), "-o", str(tmp_path / "sharp.h5")])
    assert done.exit_code == 0
    assert "incident 30/40: height" in done.stderr
    found = read_dataset(tmp_path / "sharp.h5")
    (sharp,) = found.distributions
    top = int(np.argmax(sharp.dsf_per_sr))
    u = float(np.hypot(np.sqrt(sharp.variance_per_sr2[top]), sharp.effects["smoothing"][top]))
    seen = measured.distributions[0].dsf_per_sr.max()
    assert abs(sharp.dsf_per_sr[top] - HEIGHT) < 3.0 * u
    assert abs(sharp.dsf_per_sr[top] - HEIGHT) < 0.5 * abs(seen - HEIGHT)
    assert 0.0 < u < abs(seen - HEIGHT)
    assert found.provenance["deconvolved"][0]["points"] > 1000
    assert any("60/0" in note for note in found.provenance["notes"])


def test_a_model_is_compared_as_the_measured_beam_shows_it(
    measured: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The scenario's lobe bare is 4 % too high; through the beam that was scanned it is the measurement."""
    write_dataset(replace(measured, distributions=measured.distributions[:1]), tmp_path / "seen.h5")
    truth_of(tmp_path, LOBE)
    with_other_beam = (tmp_path / "scene.toml").read_text().replace("divergence_deg = 1.0", "divergence_deg = 3.0")
    (tmp_path / "scene.toml").write_text(with_other_beam)
    found = {}
    for option in ([], ["--signature"]):
        assert run(["compare", str(tmp_path / "seen.h5"), str(tmp_path / "scene.toml"), "--json", *option]) == 0
        (pair,) = json.loads(capsys.readouterr().out)["distributions"]
        found[bool(option)] = pair["metrics"]["whole"]["chi_square_per_point"]
    assert found[False] > 10.0
    assert found[True] == pytest.approx(1.0, abs=0.2)
    assert run(["compare", str(tmp_path / "seen.h5"), str(tmp_path / "seen.h5"), "--signature"]) == 2


def test_without_a_free_beam_there_is_nothing_to_take_out(measured: Dataset, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no scan of the free beam"):
        sharpened(replace(measured, beam=None), "mirror", 4.0)
    with pytest.raises(UsageError, match=r"30/40: .*too few.*60/0"):
        sharpened(measured, "through", 4.0)
    write_dataset(measured, tmp_path / "seen.h5")
    assert run(["deconvolve", str(tmp_path / "seen.h5"), "--radius", "0.3", "-o", str(tmp_path / "no.h5")]) == 2
    assert not (tmp_path / "no.h5").exists()
