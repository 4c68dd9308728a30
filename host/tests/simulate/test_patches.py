"""test_patches.py: BSDF matrices from light that fills patches: closed forms, sides, reciprocity, equal bytes, wrong
use."""

import json
from pathlib import Path

import numpy as np
import pytest
from mirror_slats import SLATS
from numpy.typing import NDArray

from gonio.cli import main
from gonio.dataset.bsdf import Side
from gonio.dataset.nexus import read_dataset
from gonio.formats.window import read as window_reader
from gonio.formats.window.klems import BASES, KlemsBasis
from gonio.formats.window.matrices import PROCESSES, SIDES, build
from gonio.simulate.patches import SimulatedMatrices, shares_of, simulate_matrices
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import BALANCE, Part
from gonio.simulate.request import Request
from gonio.units.errors import CheckFailed

QUARTER = BASES["klems-quarter"]
FULL = BASES["klems-full"]
WHITE = """
[sample]
kind = "sheet"
material = "white"
[materials.white]
kind = "lambertian"
reflectance = { visible = 0.5, near-infrared = 0.3, red = 0.1 }
transmittance = { visible = 0.3, near-infrared = 0.6, red = 0.1 }
[[band]]
name = "visible"
[[band]]
name = "near-infrared"
wavelength_nm = 900.0
[[band]]
name = "red"
"""
ONE_BAND = "[sample]\nkind = 'lambertian'\nreflectance = 0.6\n"
LOUVER = """
[sample]
kind = "louver"
{stack}
top = "top"
bottom = "bottom"
[materials.top]
kind = "ward-duer"
reflectance = 0.9
specular_share = 0.9
roughness_x = 0.2
[materials.bottom]
kind = "lambertian"
reflectance = 0.8
"""


def simulated(
    text: str, folder: Path, basis: str = "klems-quarter", front: Side = "exterior", photons: int = 4000
) -> SimulatedMatrices:
    path = folder / "scenario.toml"
    path.write_text(text)
    return simulate_matrices(Request(path, photons=photons, threads=2), basis, front, PhotonProgress())


def command(folder: Path, text: str, *options: str) -> int:
    (folder / "scenario.toml").write_text(text)
    wanted = [] if "--format" in options else ["--format", "klems-quarter"]
    return main.run(["simulate", str(folder / "scenario.toml"), "-o", str(folder / "out.xml"), *wanted, *options])


def turned(basis: KlemsBasis) -> NDArray[np.int64]:
    """The patch across the pole from each."""
    return basis.patch_of(basis.centres_deg[:, 0], basis.centres_deg[:, 1] + 180.0)


def test_every_value_of_a_lambertian_sample(tmp_path: Path) -> None:
    """A photon leaves with weight A = reflectance + transmittance: variance of a share is share (A - share)."""
    photons = 4000
    done = simulated(WHITE, tmp_path, photons=photons)
    size = QUARTER.projected_solid_angle_sr
    for block, reflectance, transmittance in (("Visible", 0.5, 0.3), ("Solar", 0.3, 0.6)):
        for (process, _), matrix in done.matrices.bands[block].matrices.items():
            share = (reflectance if process == "Reflection" else transmittance) / np.pi * size
            error = np.sqrt(share * (reflectance + transmittance - share) / photons) / size
            deviation = (matrix - (share / size)[:, None]) / error[:, None]
            assert np.abs(deviation).max() < 5.5
            assert np.mean(deviation**2) == pytest.approx(1.0, abs=5 * np.sqrt(2 / deviation.size))
    assert done.balance["photons"] == 2 * 2 * QUARTER.size * photons
    visible = done.blocks[0]
    assert visible["largest_column_sum"] == pytest.approx(0.8, abs=1e-6)
    assert visible["largest_error_of_a_column_sum"] < 1e-4  # all leave
    # The median patch holds about a hundredth of the light.
    shares = np.outer([0.5, 0.3], size / np.pi).ravel()
    assert visible["median_relative_error"] == pytest.approx(np.median(np.sqrt(0.8 / shares / photons)), rel=0.05)


@pytest.mark.parametrize("front", ["exterior", "interior"])
@pytest.mark.parametrize(
    ("material", "process", "integral"),
    [
        ('kind = "mirror"\nreflectance = 0.9', "Reflection", 0.9),
        ('kind = "thin-plate"\nreflectance_s = 0.0\nreflectance_p = 0.0\ntransmittance_s = 0.8\ntransmittance_p = 0.8',
         "Transmission", 0.8),
    ],
)  # fmt: skip
def test_mirror_and_clear_pane_lie_on_the_diagonal(tmp_path: Path, material, process, integral, front) -> None:  # type: ignore[no-untyped-def]
    text = f'[sample]\nkind = "sheet"\nmaterial = "m"\n[materials.m]\n{material}\n'
    done = simulated(text, tmp_path, front=front, photons=200)
    for (other, _), matrix in done.matrices.bands["Visible"].matrices.items():
        expected = np.diag(integral / QUARTER.projected_solid_angle_sr) if other == process else np.zeros_like(matrix)
        np.testing.assert_allclose(matrix, expected, rtol=1e-6)


@pytest.mark.parametrize("front", ["exterior", "interior"])
def test_light_from_above_is_redirected_upwards(tmp_path: Path, front: Side) -> None:
    """Mirrors that face up: light from above, from the right, at 40 degrees. Its share tan(elevation) is reflected once
    and goes on upwards, the rest passes straight through; light from below is absorbed where it meets a slat."""
    photons = 2000
    done = simulated(SLATS, tmp_path, "klems-full", front, photons)
    matrices = done.matrices.bands["Visible"].matrices
    size = FULL.projected_solid_angle_sr
    theta, phi = np.radians([np.linspace(35, 45, 400), np.linspace(52.5, 67.5, 400)])
    weight = np.sin(theta) ** 2
    met = float(np.sum(weight) * np.mean(np.sin(phi)) / np.sum(np.sin(theta) * np.cos(theta)))
    # Azimuths of Radiance's frame, +x to the right of a person inside; a person at the front sees the sample's x.
    mirrored = front == "exterior"

    def patch(azimuth_deg: float) -> int:
        return int(FULL.patch_of(40.0, 180.0 - azimuth_deg if mirrored else azimuth_deg))

    side = "Front" if mirrored else "Back"  # light on the sample's front
    for source_deg, redirected in ((60.0, 0.7 * met), (300.0, 0.0)):
        column = matrices["Transmission", side][:, patch(source_deg + 180.0)] * size
        expected = {patch(source_deg + 180.0): 1 - met, patch(180.0 - source_deg): redirected}
        for row, share in expected.items():
            assert column[row] == pytest.approx(share, abs=5 * np.sqrt(share * (1 - share) / photons) + 1e-6)
        assert column.sum() == pytest.approx(sum(column[list(expected)]), abs=1e-9)
        assert not matrices["Reflection", side][:, patch(source_deg + 180.0)].any()


@pytest.mark.parametrize("incident", ["[60.0, 60.0]", "[120.0, 60.0]"])
def test_a_column_is_what_export_makes_of_a_simulated_measurement(tmp_path: Path, incident: str) -> None:
    """The louver, lit at a patch's centre: up, down, left and right of both matrices as from the patch, but for the
    patch's width."""
    text = (
        LOUVER.format(stack="") + f"[beam]\ndiameter_mm = 130.0\n[readings]\nincident = [{incident}]\nstep_deg = 3.0\n"
    )
    path = tmp_path / "louver.toml"
    path.write_text(text)
    assert main.run(["simulate", str(path), "-o", str(tmp_path / "sim.h5"), "--photons", "500000"]) == 0
    measured = build(read_dataset(tmp_path / "sim.h5"), front="exterior").bands["Visible"]
    ours = simulated(text, tmp_path, "klems-full", "exterior", 4000).matrices.bands["Visible"]
    side = "Front" if incident.startswith("[60") else "Back"
    size, azimuth = FULL.projected_solid_angle_sr, np.radians(FULL.centres_deg[:, 1])
    quarters = [np.sign(np.sin(azimuth)) == up for up in (1, -1)] + [
        np.sign(np.cos(azimuth).round(9)) == x for x in (1, -1)
    ]
    for process in PROCESSES:
        (column,) = np.flatnonzero(measured.origin[process, side])
        one, other = (block.matrices[process, side][:, column] * size for block in (measured, ours))
        sums = np.array([[column[quarter].sum() for quarter in quarters] for column in (one, other)])
        np.testing.assert_allclose(sums[0], sums[1], atol=0.03)
        alike = one @ other / np.sqrt(one @ one * (other @ other))
        flipped = FULL.patch_of(FULL.centres_deg[:, 0], -FULL.centres_deg[:, 1])
        assert alike > 0.9
        assert alike > one @ other[flipped] / np.sqrt(one @ one * (other @ other)) + 0.1


def test_reciprocity_of_the_louver(tmp_path: Path) -> None:
    """B(i -> o) = B(o -> i), front and back, reflected and transmitted. Weights are at most 1, so the variance of a
    share is at most share / photons."""
    photons = 8000
    text = LOUVER.format(stack="count = 199\nlength_mm = 4000.0")
    matrices = simulated(text, tmp_path, photons=photons).matrices.bands["Visible"].matrices
    size, across = QUARTER.projected_solid_angle_sr, turned(QUARTER)
    chi_square, freedom = 0.0, 0
    for process, side in matrices:
        other = side if process == "Reflection" else SIDES[1 - SIDES.index(side)]
        there, back = matrices[process, side], matrices[process, other][np.ix_(across, across)].T
        share = 0.5 * (there + back) * size[:, None]
        variance = share / photons / size[:, None] ** 2 + 0.5 * (there + back) / photons / size[None, :]
        seen = share * photons > 20
        chi_square += float(np.sum((there - back)[seen] ** 2 / variance[seen]))
        freedom += int(seen.sum())
    assert freedom > 1000
    assert 0.4 * freedom < chi_square < freedom + 5 * np.sqrt(2 * freedom)


def test_the_file_is_good_and_says_what_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--format", "klems-full", "--front", "interior", "--photons", "300", "--json")
    assert command(tmp_path, WHITE, *options) == 0
    told = json.loads(capsys.readouterr().out)
    assert main.run(["validate", str(tmp_path / "out.xml")]) == 0
    found = window_reader.read(tmp_path / "out.xml")
    assert all(matrix.any(axis=0).all() for matrix in found.matrices.values())
    assert len(found.matrices) == 8
    comments = found.text["Comments"]
    assert "Written by gonio from a simulation." in comments
    assert "Front, where light arrives from the exterior, is the sample's back." in comments
    assert "Visible: 300 photons per incident patch; median relative standard error" in comments
    assert "Solar: the scenario's band near-infrared, optics at 900 nm; not an average over the solar" in comments
    assert "measured," not in comments.replace("assumed, not measured", "")
    assert 'band "red" has no place in the file and was not simulated' in told["remarks"]
    assert [block["band"] for block in told["blocks"]] == ["visible", "near-infrared"]
    assert told["balance"]["photons"] == 2 * 2 * FULL.size * 300


def test_solar_is_a_copy_only_where_it_is_declared(tmp_path: Path) -> None:
    options = ("--front", "exterior", "--photons", "100")
    assert command(tmp_path, ONE_BAND, *options) == 0
    plain = window_reader.read(tmp_path / "out.xml")
    assert not plain.matrices["Solar", "Reflection", "Front"].any()
    assert "Solar: not simulated, all matrices are zeros." in plain.text["Comments"]
    assert command(tmp_path, ONE_BAND, *options, "--assume-flat") == 0
    flat = window_reader.read(tmp_path / "out.xml")
    np.testing.assert_array_equal(
        flat.matrices["Solar", "Reflection", "Front"], plain.matrices["Visible", "Reflection", "Front"]
    )
    assert "Solar: copied from Visible (declared spectrally flat)." in flat.text["Comments"]


def test_any_division_gives_the_same_bytes(tmp_path: Path) -> None:
    files = []
    for division in (("--threads", "1"), ("--threads", "3"), ("--workers", "2")):
        options = ("--front", "exterior", "--photons", "200", "--error", "0.2", "--seed", "7")
        assert command(tmp_path, LOUVER.format(stack=""), *options, *division) == 0
        files.append((tmp_path / "out.xml").read_bytes())
    assert files[0] == files[1] == files[2]


def test_photons_until_the_error_is_reached(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(tmp_path, ONE_BAND, "--front", "exterior", "--photons", "50", "--error", "0.1", "--json") == 0
    (block,) = json.loads(capsys.readouterr().out)["blocks"]
    assert 0.05 < block["median_relative_error"] <= 0.1
    assert block["photons_per_patch"][1] < 50_000


def test_more_light_than_came_is_refused() -> None:
    """Nine of ten photons leave, each with weight 1.2; and with weight 1.1 what is above 1 by chance is scaled."""

    def parts(weight: float, photons: int) -> list[Part]:
        one = 2.0**24
        hits = np.array([0.9 * photons, 0.0], dtype=np.uint64)
        balance = dict.fromkeys(BALANCE, 0) | {"photons": photons, "emitted": int(photons * one)}
        sums = ((hits * weight**k * one).astype(np.uint64) for k in (1, 2))
        return [Part(*sums, hits, balance), Part.nothing(2)]

    def both(weight: float, photons: int) -> list[Part]:
        return [parts(weight, photons)[0], parts(weight, photons)[0]]

    with pytest.raises(CheckFailed, match=r"patch 1 of the sample frame: 1\.0800 of it leaves"):
        shares_of(both(1.2, 100_000))
    by_chance = shares_of(both(1.2, 100))
    np.testing.assert_allclose(by_chance.share.sum(axis=2), 1.0)
    np.testing.assert_allclose(by_chance.total, 1.08)


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (ONE_BAND, (), "give --front exterior or --front interior"),
        (ONE_BAND, ("--like", "scenario.toml", "--front", "exterior"), "--like goes with a dataset"),
        (ONE_BAND, ("--format", "dataset", "--front", "exterior"), "--front and --assume-flat are for matrices"),
        ("[sample]\ncomponents = []\n", ("--front", "exterior"), "closed form"),
        (ONE_BAND + "[[band]]\nname = 'red'\n", ("--front", "exterior"), "no band is called visible"),
        (ONE_BAND + "[rig]\nholder = { opening_mm = 50.0 }\n", ("--front", "exterior"), "rig.holder"),
        (ONE_BAND + "[beam]\nkind = 'focused'\n[rig.splitters]\nplate = { kind = 'thin-plate' , thickness_mm = 1.0}\n",
         ("--front", "exterior"), "rig: its parts stand in the way"),
    ],
)  # fmt: skip
def test_wrong_use_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], text, options, said
) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.chdir(tmp_path)
    assert command(tmp_path, text, *options) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out.xml").exists()
