"""test_merge_command.py: gonio merge and gonio repeatability on files: what they write, say and refuse."""

import json

import numpy as np
import pytest
from closed_form_sets import RETRO_30, dataset, distribution, lambertian, lobe, rings

from gonio.cli.main import run
from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.geometry.directions import angle_between_deg


def written(path, *sets: Dataset) -> list[str]:
    names = []
    for name, found in zip("abcdef", sets, strict=False):
        write_dataset(found, path / f"{name}.h5")
        names.append(str(path / f"{name}.h5"))
    return names


def scan(raw: str, seed: int, rho: float = 0.6, **described) -> Dataset:
    unit = rings(6.0)
    d = distribution(
        unit,
        lambertian(rho),
        noise=0.01,
        floor=0.0,
        rng=np.random.default_rng(seed),
        effects={"p_i": 0.004, "distance": 0.001},
    )
    return dataset(d, raw=raw, **described)


def test_merge_writes_a_dataset_that_says_where_it_comes_from(tmp_path, capsys):
    files = written(tmp_path, scan("one", 1), scan("two", 2))
    out = str(tmp_path / "merged.h5")
    assert run(["merge", *files, "-o", out]) == 0
    printed = capsys.readouterr()
    assert printed.out.strip() == out
    assert "a.h5 / b.h5 = " in printed.err
    assert "chi2/dof" in printed.err
    found = read_dataset(tmp_path / "merged.h5")
    d = found.distributions[0]
    assert len(d.theta_deg) == 2 * len(rings(6.0))
    assert d.integrals["rho_measured"] == pytest.approx(0.6, rel=0.01)
    assert sum(key.startswith("p_i #") for key in d.effects) == 2
    assert found.provenance["raw_sha256"] == ["one", "two"]
    merged = found.provenance["merge"]
    assert [s["name"] for s in merged["sources"]] == ["a.h5", "b.h5"]
    assert all(len(s["sha256"]) == 64 for s in merged["sources"])
    assert merged["options"]["tolerance_deg"] == 0.1


def test_json_is_one_object_without_nan(tmp_path, capsys):
    files = written(tmp_path, scan("one", 1), scan("two", 2, rho=0.7), scan("three", 3))
    assert run(["merge", *files, "-o", str(tmp_path / "m.h5"), "--json", "--drop-outliers"]) == 0

    def no_nan(text):
        raise AssertionError(text)

    found = json.loads(capsys.readouterr().out, parse_constant=no_nan)
    one = found["distributions"][0]["sets"][0]
    assert one["dropped"] == ["b.h5"]
    assert len(one["overlaps"]) == 3
    assert found["remarks"]


def not_normalised() -> Dataset:
    found = scan("two", 2)
    found.distributions[0].p_i = float("nan")
    return found


@pytest.mark.parametrize(
    ("other", "problem"),
    [
        (lambda: scan("two", 2, sample="brick"), 'sample "brick", but a.h5 has "tile"'),
        (not_normalised, "has no P_i"),
        (lambda: scan("one", 1), "has the same content as a.h5"),
        (lambda: scan("two", 2, polarisation="s"), "only s and p make a mean"),
    ],
)
def test_what_does_not_belong_together_is_refused_in_one_line(tmp_path, capsys, other, problem):
    files = written(tmp_path, scan("one", 1), other())
    assert run(["merge", *files, "-o", str(tmp_path / "m.h5")]) == 2
    error = capsys.readouterr().err
    assert problem in error
    assert error.count("\n") == 1
    assert not (tmp_path / "m.h5").exists()


def test_sides_that_differ_are_refused_even_with_force(tmp_path, capsys):
    sets = [scan("one", 1), scan("two", 2, sample="brick")]
    sets[0].front_faces, sets[1].front_faces = "exterior", "interior"
    files = written(tmp_path, *sets)
    assert run(["merge", *files, "-o", str(tmp_path / "m.h5"), "--force"]) == 2
    assert "front faces interior, but a.h5 says exterior" in capsys.readouterr().err
    sets[1].front_faces = "undeclared"
    written(tmp_path, *sets)
    assert run(["merge", *files, "-o", str(tmp_path / "m.h5"), "--force"]) == 0
    assert read_dataset(tmp_path / "m.h5").front_faces == "exterior"
    assert "front faces: exterior, also for b.h5" in capsys.readouterr().err


def test_a_merged_set_is_not_merged_again(tmp_path, capsys):
    files = written(tmp_path, scan("one", 1), scan("two", 2))
    merged = str(tmp_path / "m.h5")
    assert run(["merge", *files, "-o", merged]) == 0
    assert run(["merge", merged, files[0], "-o", str(tmp_path / "n.h5")]) == 2
    assert "is merged already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--align"], "go with --retro"),
        (["--retro", "RIG", "--plate", "0.5,0.5,0.5"], "wants 4 numbers"),
        (["--retro", "RIG", "--plate", "0.6,0.5,0.5,0.5"], "R + T must be 1 at most"),
        (["--retro", "RIG", "--depolarisation", "1"], "says nothing without"),
        (["--retro", "RIG", "--sample-distance", "far"], "wants 1 or 2 numbers"),
        (["--retro", "RIG"], "is this a scan through the beam splitters"),
    ],
)
def test_wrong_rig_options_are_one_line(tmp_path, capsys, options, problem):
    from test_merge_retro import REFERENCE_LAB, lab_from_sample, rig_set, units  # noqa: PLC0415

    rig = rig_set(lambertian(0.5), (30.0, 0.0))
    lab = units(rig) @ lab_from_sample(30.0, 0.0).T
    rig.flags[angle_between_deg(lab, REFERENCE_LAB) > 20.0] = 1
    files = written(tmp_path, scan("one", 1), dataset(rig, raw="rig"))
    options = [files[1] if option == "RIG" else option for option in options]
    assert run(["merge", files[0], *options, "-o", str(tmp_path / "m.h5")]) == 2
    error = capsys.readouterr().err
    assert problem in error
    assert error.count("\n") == 1


def test_the_rig_goes_through_the_command(tmp_path, capsys):
    from test_merge_retro import rig_set  # noqa: PLC0415

    incident = (30.0, 0.0)
    truth = lobe(6.0, 1.5, RETRO_30, ground=0.2)
    hemisphere = distribution(rings(2.0), truth, incident=incident)
    files = written(tmp_path, dataset(hemisphere, raw="h"), dataset(rig_set(truth, incident), raw="r"))
    out = tmp_path / "m.h5"
    options = ["--retro", files[1], "--plate", "0.5,0.5,0.5,0.5", "--align", "--retro-radius", "6"]
    assert run(["merge", files[0], *options, "-o", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["retro"][0]
    assert found["distributions"][0]["radius_deg"] == pytest.approx(6.0, abs=0.15)
    assert found["distributions"][0]["turned_deg"] < 0.02
    d = read_dataset(out).distributions[0]
    assert d.integrals["rho_measured"] == pytest.approx(
        0.2 * np.pi + 6.0 * 2.0 * np.pi * np.radians(1.5) ** 2, rel=0.003
    )


def test_repeatability_of_files(tmp_path, capsys):
    rng = np.random.default_rng(7)
    files = []
    rows = ["file,mount,position,day"]
    for k in range(8):
        found = scan(str(k), k)
        d = found.distributions[0]
        d.integrals = {"rho_measured": 0.6 + 0.01 * (k // 4) + 0.001 * rng.standard_normal(), "rho_u": 0.005}
        write_dataset(found, tmp_path / f"{k}.h5")
        files.append(f"{k}.h5")
        rows.append(f"{k}.h5,{k // 2 % 2},1,{'mo' if k < 4 else 'tu'}")
    table = tmp_path / "runs.csv"
    table.write_text("\n".join(rows))
    assert run(["repeatability", str(table)]) == 0
    text = capsys.readouterr().out
    assert "rho_measured, visible, incident (30, 0): mean 0.604886 +- " in text
    assert "shifted position        not told by these runs" in text
    assert run(["repeatability", str(table), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    day, mount, position, repeat = found["results"][0]["components"]
    assert (day["dof"], mount["dof"], position["dof"], repeat["dof"]) == (1, 2, 0, 4)
    assert np.sqrt(day["variance"]) == pytest.approx(0.01 / np.sqrt(2.0), rel=0.15)
    assert position["variance"] is None
    table.write_text("\n".join([*rows, "missing.h5,1,1,we"]))
    assert run(["repeatability", str(table)]) == 2
    assert "no such file" in capsys.readouterr().err
