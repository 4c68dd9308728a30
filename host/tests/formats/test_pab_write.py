"""test_pab_write.py: pab text there and back: digits, frames, file sets, header lines that are not ours."""

import re
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_bsdf import distribution, lobe_per_sr, sphere_points

from gonio.dataset.bsdf import Dataset
from gonio.dataset.nexus import read_dataset, write_dataset
from gonio.formats.pab import dataset as pab_dataset
from gonio.formats.pab import write as pab_write
from gonio.units.errors import UsageError

SETTINGS = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def written(text: str) -> str:
    """A decimal as a file might have it, without zeros at its end."""
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


@st.composite
def decimals(draw: st.DrawFn, low: int, high: int, places: int) -> str:
    """Text of a decimal in [low, high) with up to so many places."""
    digits = draw(st.integers(0, places))
    number = draw(st.integers(low * 10**digits, high * 10**digits - 1))
    return written(f"{number / 10**digits:.{digits}f}")


rows_of = st.lists(
    st.tuples(
        decimals(0, 90, 6),
        decimals(0, 360, 6),
        st.tuples(st.integers(-99999, 10**9), st.integers(-12, 6)).map(lambda t: repr(float(f"{t[0]}e{t[1]}"))),
    ),
    min_size=1,
    max_size=30,
    unique_by=lambda row: row[:2],
)


def numbers(path: Path) -> list[tuple[str, ...]]:
    return [tuple(line.split()) for line in path.read_text().splitlines() if not line.startswith("#")]


@SETTINGS
@given(rows=rows_of, theta_i=decimals(0, 90, 4), phi_i=decimals(0, 360, 4), word=st.sampled_from(["DSF", "BSDF", "A"]))
def test_what_was_read_is_written_with_the_same_digits(
    tmp_path: Path, rows: list[tuple[str, str, str]], theta_i: str, phi_i: str, word: str
) -> None:
    source, target = tmp_path / "source.txt", tmp_path / "target.txt"
    lines = "\n".join(" ".join(row) for row in rows)
    source.write_text(f"#incident_angle {theta_i} {phi_i}\n#upphi 90\n#format: theta phi {word}\n{lines}\n")
    pab_write.write(pab_dataset.read([source]), target, front="interior")
    assert [tuple(map(Decimal, row)) for row in numbers(target)] == [tuple(map(Decimal, row)) for row in rows]
    text = target.read_text()
    incident = next(line.split()[1:] for line in text.splitlines() if line.startswith("#incident_angle"))
    assert [Decimal(angle) for angle in incident] == [Decimal(theta_i), Decimal(phi_i)]
    assert f"#format: theta phi {word}\n" in text


@SETTINGS
@given(rows=rows_of, theta_i=decimals(0, 180, 5), phi_i=decimals(0, 360, 5))
def test_a_front_to_the_exterior_is_turned_and_comes_back_to_the_digit(
    tmp_path: Path, rows: list[tuple[str, str, str]], theta_i: str, phi_i: str
) -> None:
    source, target = tmp_path / "source.txt", tmp_path / "target.txt"
    lines = "\n".join(" ".join(row) for row in rows)
    source.write_text(f"#incident_angle {theta_i} {phi_i}\n#upphi 90\n#format: theta phi DSF\n{lines}\n")
    before = pab_dataset.read([source]).distributions[0]
    paths = pab_write.write(pab_dataset.read([source]), target, front="exterior").paths
    after = pab_dataset.read(paths)
    assert after.front_faces == "exterior"
    (again,) = after.distributions
    assert (again.incident_theta_deg, again.incident_phi_deg) == (before.incident_theta_deg, before.incident_phi_deg)
    found = set(zip(again.theta_deg.tolist(), again.phi_deg.tolist(), again.dsf_per_sr.tolist(), strict=True))
    assert found == set(
        zip(before.theta_deg.tolist(), before.phi_deg.tolist(), before.dsf_per_sr.tolist(), strict=True)
    )
    for path in paths:
        theta = np.array([float(row[0]) for row in numbers(path)])
        assert (theta >= 90).all() or (theta < 90).all()
        path.unlink()


def asymmetric(front_faces) -> Dataset:  # type: ignore[no-untyped-def]
    """Light from the front and from behind; lobes up and to the left, through down and to the right."""
    parts = []
    for incident, lobe in (
        ((40.0, 30.0), (55.0, 105.0)),
        ((40.0, 285.0), (120.0, 330.0)),
        ((140.0, 15.0), (60.0, 285.0)),
    ):
        parts.append(
            distribution(
                incident,
                sphere_points(700),
                lambda u, lobe=lobe: 0.01 + u @ [1e-4, 2e-4, 3e-4] + lobe_per_sr(u, lobe, 0.3),
                masked_below_deg=8,
            )  # type: ignore[misc]
        )
    return Dataset(parts, 'a "tile"', front_faces, "s", "bilateral")


@pytest.mark.parametrize("front_faces", ["interior", "exterior"])
def test_an_asymmetric_dataset_goes_there_and_back(tmp_path: Path, front_faces: str) -> None:
    dataset = asymmetric(front_faces)
    result = pab_write.write(dataset, tmp_path / "set")
    names = sorted(path.name for path in result.paths)
    kinds = {re.sub(r"_t[0-9].*", "", name) for name in names}
    assert len(names) == 6
    assert kinds == {"front_reflection", "front_transmission", "back_reflection", "back_transmission"}
    back = pab_dataset.read(result.paths)
    assert (back.sample_name, back.front_faces, back.polarisation, back.symmetry) == (
        "a 'tile'",
        front_faces,
        "s",
        "bilateral",
    )
    for before, after in zip(dataset.distributions, back.distributions, strict=True):
        assert (after.incident_theta_deg, after.incident_phi_deg) == (
            before.incident_theta_deg,
            before.incident_phi_deg,
        )
        used = before.measured
        # Points come back by hemisphere: put in one order by their value.
        mine, found = np.argsort(before.dsf_per_sr[used]), np.argsort(after.dsf_per_sr)
        assert after.dsf_per_sr[found].tolist() == before.dsf_per_sr[used][mine].tolist()
        np.testing.assert_allclose(after.theta_deg[found], before.theta_deg[used][mine], atol=1e-11)
        np.testing.assert_allclose(after.phi_deg[found], before.phi_deg[used][mine], atol=1e-11)
    again = pab_write.write(back, tmp_path / "again")
    for first, second in zip(result.paths, again.paths, strict=True):
        assert first.name == second.name
        assert first.read_bytes() == second.read_bytes()
    assert any("points without a value are left out" in remark for remark in result.remarks)
    assert any("wants two files or more" in remark for remark in result.remarks)


def test_header_lines_that_are_not_known_come_back_through_hdf5(tmp_path: Path) -> None:
    source = tmp_path / "source.txt"
    kept = ["#Mountain 2.7, head 3", "#operator: Léa", "# a remark", "#colorimetry: CIE-L"]
    text = "\n".join(
        [*kept, "#incident_angle 20 0", "#upphi 90", "#format: theta phi A", "10 20 1.5e-09", "170 0 -2e-12"]
    )
    source.write_text(text + "\n", encoding="latin-1")
    write_dataset(pab_dataset.read([source]), tmp_path / "x.h5")
    dataset = read_dataset(tmp_path / "x.h5")
    assert dataset.distributions[0].signal_unit == "A"
    paths = pab_write.write(dataset, tmp_path / "out", front="interior").paths
    assert [path.name for path in paths] == ["front_reflection_t20_p0.txt", "front_transmission_t20_p0.txt"]
    for path, row in zip(paths, ("10\t20\t1.5e-09", "170\t0\t-2e-12"), strict=True):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert [line for line in lines if line in kept] == kept
        assert lines[-1] == row
        assert "#upphi 90" in lines


def test_the_written_text_is_that_of_the_manual_page(tmp_path: Path) -> None:
    source = tmp_path / "source.txt"
    source.write_text("#incident_angle 82.5 180\n#format: theta phi DSF\n84.968 125.790 0.009744\n90 0 1\n")
    target = tmp_path / "x"
    first, second = pab_write.write(pab_dataset.read([source]), target, front="interior").paths
    lines = first.read_text().splitlines()
    for line in ("#incident_angle 82.5 270", "#intheta 82.5", "#inphi 270", "#upphi 90", "#colorimetry: CIE-Y"):
        assert line in lines
    assert lines[-2:] == ["#format: theta phi DSF", "84.968\t215.79\t0.009744"]
    # Radiance counts 90 degrees to the back.
    assert second.name.startswith("front_transmission")
    assert second.read_text().splitlines()[-1] == "90\t90\t1"


def test_a_bsdf_at_grazing_is_left_out(tmp_path: Path) -> None:
    source = tmp_path / "source.txt"
    source.write_text("#incident_angle 20 0\n#upphi 90\n#format: theta phi DSF\n10 0 0.5\n89.9995 0 0.5\n")
    dataset = pab_dataset.read([source])
    result = pab_write.write(dataset, tmp_path / "x.txt", front="interior", quantity="BSDF")
    assert numbers(result.paths[0]) == [("10", "0", f"{0.5 / np.cos(np.radians(10)):.15g}")]
    assert "1 points within 0.001 degrees of grazing are left out: a BSDF is singular there." in result.remarks
    assert len(numbers(pab_write.write(dataset, tmp_path / "x.txt", front="interior").paths[0])) == 2


def test_cie_xyz_is_one_file_again(tmp_path: Path) -> None:
    source = tmp_path / "source.txt"
    source.write_text("#incident_angle 20 0\n#upphi 90\n#colorimetry: CIE-XYZ\n#format: theta phi DSF\n10 0 1 2 3.5\n")
    (path,) = pab_write.write(pab_dataset.read([source]), tmp_path / "x.dat", front="interior").paths
    assert path == tmp_path / "x.dat"
    assert numbers(path) == [("10", "0", "1", "2", "3.5")]
    assert "#colorimetry: CIE-XYZ" in path.read_text()


def test_several_channels_are_sets_of_their_own(tmp_path: Path) -> None:
    parts = [
        distribution((20, 0), sphere_points(50), lambda u: np.abs(u[:, 2]), channel=c) for c in ("visible", "near IR")
    ]
    paths = pab_write.write(Dataset(parts, front_faces="interior"), tmp_path / "x").paths
    assert sorted(path.name for path in paths) == [
        "near_IR_front_reflection_t20_p0.txt",
        "near_IR_front_transmission_t20_p0.txt",
        "visible_front_reflection_t20_p0.txt",
        "visible_front_transmission_t20_p0.txt",
    ]
    assert {d.channel for d in pab_dataset.read(paths).distributions} == {"visible", "near IR"}


def test_a_set_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    dataset = asymmetric("interior")
    folder = tmp_path / "set"
    folder.mkdir()
    blocked = folder / "front_transmission_t40_p285.txt"  # a folder where a file should go
    blocked.mkdir()
    with pytest.raises(UsageError, match="cannot be written"):
        pab_write.write(dataset, folder)
    assert [path.name for path in folder.iterdir()] == [blocked.name]
    blocked.rmdir()
    (folder / "older.txt").write_text("")
    with pytest.raises(UsageError, match="holds other text files"):
        pab_write.write(dataset, folder)
    assert [path.name for path in folder.iterdir()] == ["older.txt"]


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    dataset = asymmetric("undeclared")
    with pytest.raises(UsageError, match="give --front exterior or --front interior"):
        pab_write.write(dataset, tmp_path / "x")
    with pytest.raises(UsageError, match="no channel 'red'"):
        pab_write.write(dataset, tmp_path / "x", front="interior", channel="red")
    with pytest.raises(UsageError, match="choose DSF or BSDF"):
        pab_write.write(dataset, tmp_path / "x", front="interior", quantity="rho")
    for d in dataset.distributions:
        d.flags[:] = 1
    with pytest.raises(UsageError, match="no point of the dataset holds a value"):
        pab_write.write(dataset, tmp_path / "x", front="interior")
    assert not list(tmp_path.iterdir())


def test_a_bsdf_turned_about_and_back_keeps_its_digits(tmp_path: Path) -> None:
    """|cos 120| and |cos 60| differ in their last bit: both frames must divide by what they multiplied with."""
    source = tmp_path / "source.txt"
    rows = "\n".join(f"{theta}\t0\t0.{95490 + theta}" for theta in range(5, 90))
    source.write_text(f"#incident_angle 20 0\n#upphi 90\n#format: theta phi BSDF\n{rows}\n")
    (path,) = pab_write.write(pab_dataset.read([source]), tmp_path / "x.txt", front="exterior").paths
    assert [row[2] for row in numbers(path)] == [f"0.{95490 + theta}".rstrip("0") for theta in range(5, 90)]


def test_a_set_of_nothing_but_grazing_points_is_named(tmp_path: Path) -> None:
    source = tmp_path / "source.txt"
    source.write_text("#incident_angle 20 0\n#upphi 90\n#format: theta phi DSF\n10 0 0.5\n90 0 0.001\n")
    told = pab_write.write(pab_dataset.read([source]), tmp_path / "x.txt", front="interior").remarks
    (line,) = [line for line in told if "theta = 90" in line]
    assert line.startswith("front_transmission_t20_p0: ")
