"""test_reduce_options.py: every option of gonio reduce, on a small raw log: what it does, and what it refuses."""

import sys
from pathlib import Path

import numpy as np
import pytest

from gonio.cli import main
from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from big_scan import write_big_scan


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("raw") / "raw.mcap"
    write_big_scan(path, 30_000)
    return path


@pytest.fixture(scope="module")
def plain(raw: Path) -> Dataset:
    return reduced(raw)


def reduced(raw: Path, *options: str) -> Dataset:
    output = raw.with_name("reduced.h5")
    assert main.run(["reduce", str(raw), "-o", str(output), *options]) == 0
    return read_dataset(output)


def test_without_leaves_a_correction_out(raw: Path, plain: Dataset) -> None:
    found = reduced(raw, "--without", "lamp", "--without", "stray_light")
    applied = {step["name"]: step["applied"] for step in found.provenance["corrections"]}
    assert [name for name, on in applied.items() if not on] == ["lamp", "stray_light"]
    assert np.ptp(found.distributions[0].normalisation) == 0.0
    assert np.ptp(plain.distributions[0].normalisation) > 0.0


def test_reach_sets_how_far_a_point_owns(raw: Path, plain: Dataset) -> None:
    near = reduced(raw, "--reach", "0.3")
    assert near.distributions[0].solid_angle_sr.sum() < 0.8 * plain.distributions[0].solid_angle_sr.sum()


def test_calibration_goes_before_that_of_the_instrument(raw: Path, plain: Dataset) -> None:
    file = raw.with_name("calibration.toml")
    file.write_text("[calibration]\naxis_zero_u_deg = 0.1\n")
    effect = [d.distributions[0].effects["axis arm azimuth"] for d in (plain, reduced(raw, "--calibration", str(file)))]
    assert np.nanmax(np.abs(effect[1])) > 2.0 * np.nanmax(np.abs(effect[0]))


def test_declared_p_i_scales_the_dsf(raw: Path, plain: Dataset) -> None:
    p_i = plain.distributions[0].p_i
    found = reduced(raw, "--p-i", str(2.0 * p_i), "--p-i-u", str(0.02 * p_i)).distributions[0]
    assert (found.p_i, found.p_i_u_rel) == pytest.approx((2.0 * p_i, 0.01))
    measured = found.measured
    np.testing.assert_allclose(2.0 * found.dsf_per_sr[measured], plain.distributions[0].dsf_per_sr[measured])


def test_the_beam_of_another_dataset(raw: Path, plain: Dataset) -> None:
    other = raw.with_name("other.h5")
    assert main.run(["reduce", str(raw), "-o", str(other)]) == 0
    found = reduced(raw, "--beam", str(other))
    np.testing.assert_allclose(found.distributions[0].dsf_per_sr, plain.distributions[0].dsf_per_sr)
    assert "other.h5" in str(found.provenance["corrections"])


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--without", "fog"], "--without fog"),
        (["--reach", "0"], "--reach 0"),
        (["--reach", "nan"], "--reach nan"),
        (["--reach", "wide"], "reach"),
        (["--p-i", "-1"], "--p-i -1"),
        (["--p-i-u", "1"], "--p-i-u"),
        (["--p-i", "1", "--beam", "reduced.h5"], "--beam"),
        (["--beam", "raw.mcap"], "raw.mcap"),
        (["--beam", "missing.h5"], "missing.h5"),
        (["--calibration", "unknown.toml"], "unknown.toml: calibration.fog"),
        (["--calibration", "negative.toml"], "negative.toml: calibration.axis_zero_u_deg"),
        (["--calibration", "table.toml"], "table.toml: calibration"),
        (["--calibration", "broken.toml"], "broken.toml: not TOML"),
        (["--calibration", "empty.toml"], "empty.toml: is empty"),
    ],
)
def test_wrong_values_are_one_line(
    raw: Path,
    plain: Dataset,
    options: list[str],
    told: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(raw.parent)
    for name, text in (
        ("unknown", "[calibration]\nfog = 1.0\n"),
        ("negative", "[calibration]\naxis_zero_u_deg = -1.0\n"),
        ("table", "[axis]\nname = 1\n"),
        ("broken", "[calibration\n"),
        ("empty", ""),
    ):
        Path(f"{name}.toml").write_text(text)
    assert plain.beam is not None
    capsys.readouterr()
    assert main.run(["reduce", "raw.mcap", "-o", "wrong.h5", *options]) == 2
    error = capsys.readouterr().err.strip()
    assert len(error.splitlines()) == 1
    assert told in error
    assert not Path("wrong.h5").exists()
