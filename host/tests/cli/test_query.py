"""test_query.py: gonio query: single pairs and tables, from every kind of file, with origin and reason."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lopsided_sample import COMPONENTS, Lopsided, exact_matrices, lopsided_bsdf, lopsided_dataset
from wild_xml import SMALL, klems_xml

from gonio.cli.main import run
from gonio.dataset.nexus import write_dataset
from gonio.dataset.scattering import Bsdf, FloatArray, IndexArray, Origin
from gonio.formats import asked_table, asking, validity
from gonio.formats.asking import Reason, ask
from gonio.formats.pab import write as pab_write
from gonio.formats.tables import csv_write as csv_points
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

FRONT_ONLY = {key: matrix for key, matrix in exact_matrices(SMALL).items() if key[1] == "Back"}  # the interior's light


@pytest.fixture(autouse=True)
def _own_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def klems() -> str:
    """Measured at the front up to 60 degrees, front to the interior."""
    matrices = {(band, *key): m for band in ("Visible", "Solar") for key, m in FRONT_ONLY.items()}
    said = validity.Validity(
        "interior",
        "none",
        tuple(validity.Range(("visible", "solar"), True, to, (0.0, 60.0), (0.0, 360.0), (0.0, 90.0)) for to in (1, 0)),
    )
    Path("klems.xml").write_text(klems_xml(matrices, comments=said.line().replace("&", "&amp;")))
    return "klems.xml"


def asked(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[dict[str, object], str]:
    assert run(["query", *arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    return json.loads(out, parse_constant=pytest.fail), err


def test_one_pair_of_a_file_of_patches(klems: str, capsys: pytest.CaptureFixture[str]) -> None:
    row, column = SMALL.patch_of(36.0, 90.0), SMALL.patch_of(18.0, 180.0 + 45.0)
    expected = exact_matrices(SMALL)["Reflection", "Back"][row, column]
    found, err = asked([klems, "--incident", "18,45", "--outgoing", "36,90"], capsys)
    assert err == ""
    assert found["bsdf_per_sr"] == pytest.approx(expected)
    assert found["dsf_per_sr"] == pytest.approx(expected * np.cos(np.radians(36.0)))
    assert (found["origin"], found["reason"], found["channel"]) == ("interpolated", None, "visible")
    assert run(["query", klems, "--incident", "18,45", "--outgoing", "36,90"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[0] == f"BSDF    {expected:.7g} 1/sr"
    assert out[2] == "origin  interpolated"


def test_outside_the_validity_range_there_is_a_warning(klems: str, capsys: pytest.CaptureFixture[str]) -> None:
    found, err = asked([klems, "--incident", "70,45", "--outgoing", "36,90"], capsys)
    assert found["origin"] == "extrapolated"
    assert found["bsdf_per_sr"] is not None
    assert err.count("\n") == 1
    assert "outside the validity range" in err
    assert "theta_i 0-60" in err
    found, err = asked([klems, "--incident", "110,45", "--outgoing", "36,90"], capsys)
    assert (found["origin"], found["bsdf_per_sr"], found["dsf_per_sr"]) == ("absent", None, None)
    assert found["reason"] == "this pair of hemispheres was not measured"


def test_grazing_is_a_patchs_value_and_none_of_a_model(klems: str, capsys: pytest.CaptureFixture[str]) -> None:
    row, column = SMALL.patch_of(90.0, 90.0), SMALL.patch_of(18.0, 225.0)
    found, _ = asked([klems, "--incident", "18,45", "--outgoing", "90,90"], capsys)
    assert found["bsdf_per_sr"] == pytest.approx(exact_matrices(SMALL)["Reflection", "Back"][row, column])
    incident, grazing = unit_from_angles_deg([18.0], [45.0]), unit_from_angles_deg([90.0, 89.9995, 89.9], 90.0)
    answers = ask(Lopsided(), incident, grazing)
    assert answers.reason.tolist() == [Reason.HORIZON, Reason.HORIZON, Reason.NONE]
    assert np.isnan(answers.bsdf_per_sr[:2]).all()
    assert np.isfinite(answers.dsf_per_sr).all()


def test_another_front_is_the_same_room(klems: str, capsys: pytest.CaptureFixture[str]) -> None:
    one, _ = asked([klems, "--incident", "18,45", "--outgoing", "36,90"], capsys)
    other, _ = asked([klems, "--front", "exterior", "--incident", "162,135", "--outgoing", "144,90"], capsys)
    assert one["bsdf_per_sr"] == other["bsdf_per_sr"]
    assert (one["front_faces"], other["front_faces"]) == ("interior", "exterior")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["klems.xml"], "--incident"),
        (["klems.xml", "--incident", "3,4"], "--outgoing"),
        (["klems.xml", "--incident", "3;4", "--outgoing", "3,4"], "no direction"),
        (["klems.xml", "--incident", "nan,4", "--outgoing", "3,4"], "no direction"),
        (["klems.xml", "--incident", "3,4", "--outgoing", "190,4"], "no direction"),
        (["klems.xml", "--incident", "3,4", "--outgoing", "3,4", "--channel", "red"], "visible, solar"),
        (["klems.xml", "--table", "none.csv", "-o", "o.csv"], "no such file"),
        (["klems.xml", "--table", "klems.xml", "-o", "klems.xml"], "named twice"),
        (["klems.xml", "--table", "klems.xml"], "-o"),
        (["klems.xml", "--table", "klems.xml", "-o", "o.csv"], "theta_i_deg"),
        (["klems.xml", "--table", "x.csv", "-o", "o.csv", "--incident", "3,4", "--outgoing", "3,4"], "--table"),
        (["none.xml", "--incident", "3,4", "--outgoing", "3,4"], "no such file"),
        (["x.csv", "--incident", "3,4", "--outgoing", "3,4"], "x.csv"),
    ],
)
@pytest.mark.usefixtures("klems")
def test_wrong_use_is_one_line(capsys: pytest.CaptureFixture[str], arguments: list[str], words: str) -> None:
    Path("x.csv").write_text("a,b\n1,2\n")
    assert run(["query", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("gonio: ")
    assert err.count("\n") == 1
    assert words in err
    assert not Path("o.csv").exists()


TABLE = """# from somewhere
name,theta_s_deg,phi_s_deg,theta_i_deg,phi_i_deg,note
a,36,90,18,45,"quoted, with a comma"
b,36,90,70,45,far

c,36,90,110,45,not measured
d,36,90,,45,empty
e,36,x,18,45,word
f,36,90,18,999,angle
g,36,90,18,45
h,36,90,18,45,more,cells
i,90,90,18,45,grazing
j,-36,270,18,45,signed
k,36,90,nan,45,nan
"""


def test_a_table_gets_a_value_or_a_reason_per_row(klems: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("in.csv").write_text(TABLE)
    assert run(["query", klems, "--table", "in.csv", "-o", "out.csv"]) == 0
    out, err = capsys.readouterr()
    assert out == "out.csv\n"
    assert "1 of 11 rows are outside the validity range" in err
    text = Path("out.csv").read_text()
    assert text.startswith(
        "# from somewhere\nname,theta_s_deg,phi_s_deg,theta_i_deg,phi_i_deg,note,bsdf,origin,reason\n"
    )
    rows = {row["name"]: row for row in csv.DictReader(text.splitlines()[1:])}
    expected = exact_matrices(SMALL)["Reflection", "Back"][SMALL.patch_of(36.0, 90.0), SMALL.patch_of(18.0, 225.0)]
    assert float(rows["a"]["bsdf"]) == pytest.approx(expected, rel=1e-8)
    assert rows["a"]["note"] == "quoted, with a comma"
    assert (rows["a"]["origin"], rows["a"]["reason"]) == ("interpolated", "")
    assert (rows["b"]["origin"], bool(rows["b"]["bsdf"])) == ("extrapolated", True)
    assert (rows["c"]["origin"], rows["c"]["bsdf"]) == ("absent", "")
    assert rows["j"]["bsdf"] == rows["a"]["bsdf"]
    assert rows["i"]["bsdf"] != ""
    assert {name: row["reason"] for name, row in rows.items() if row["reason"]} == {
        "c": "this pair of hemispheres was not measured",
        "d": "theta_i_deg is no number",
        "e": "phi_s_deg is no number",
        "f": "phi_i_deg is no possible angle",
        "g": "5 cells instead of 6",
        "h": "7 cells instead of 6",
        "k": "theta_i_deg is no number",
    }
    assert {len(row) for row in csv.reader(text.splitlines()[1:]) if row} == {9}
    assert run(["query", klems, "--table", "out.csv", "-o", "again.csv"]) == 2
    assert "a column bsdf already" in capsys.readouterr().err


def test_a_long_table_goes_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    generator = np.random.default_rng(1)
    angles = np.column_stack((generator.uniform(0, 180, (500, 2)), generator.uniform(0, 180, 500), np.zeros(500)))
    lines = [",".join(asked_table.ANGLES), *(",".join(f"{a:.3f}" for a in row) for row in angles)]
    Path("in.csv").write_text("\r\n".join(lines) + "\r\n")
    model = Lopsided()

    def call(incident: FloatArray, outgoing: FloatArray, which: IndexArray) -> asking.Answers:
        return ask(model, incident, outgoing, which)

    assert asked_table.answer(Path("in.csv"), Path("whole.csv"), call).rows == 500
    monkeypatch.setattr(asked_table, "ROWS_AT_ONCE", 7)
    assert asked_table.answer(Path("in.csv"), Path("pieces.csv"), call).rows == 500
    whole, pieces = (list(csv.DictReader(Path(f"{name}.csv").read_text().splitlines())) for name in ("whole", "pieces"))
    for row, again in zip(whole, pieces, strict=True):
        assert float(row["bsdf"]) == pytest.approx(float(again["bsdf"]), rel=1e-12)
        assert {**row, "bsdf": ""} == {**again, "bsdf": ""}
    for row in whole[:50]:
        theta_i, phi_i, theta_s, phi_s = (float(row[name]) for name in asked_table.ANGLES)
        incident, outgoing = unit_from_angles_deg([theta_i], [phi_i]), unit_from_angles_deg([theta_s], [phi_s])
        part = COMPONENTS[theta_i < 90.0, theta_s < 90.0]
        assert float(row["bsdf"]) == pytest.approx(part.bsdf(incident[:, :2], outgoing[:, :2])[0])


@settings(max_examples=150, deadline=None)
@given(st.one_of(st.binary(max_size=120), st.text(max_size=120).map(lambda t: t.encode("utf-8", "surrogatepass"))))
def test_any_rows_give_a_table_or_one_line(rest: bytes) -> None:
    Path("in.csv").write_bytes(b"theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg\n0,0,10,10\n" + rest)
    model = Lopsided()
    try:
        counts = asked_table.answer(
            Path("in.csv"), Path("out.csv"), lambda incident, outgoing, which: ask(model, incident, outgoing, which)
        )
    except UsageError as error:
        if "\n" in str(error):
            raise
    else:
        assert counts.rows >= 1
        assert Path("out.csv").read_bytes().count(b"\n") >= 2


def test_channels() -> None:
    bsdf = lopsided_bsdf()
    assert asking.channel_of(bsdf, None, "x") == "visible"
    assert asking.channel_of(bsdf, "solar", "x") == "solar"
    assert asking.channel_of(Bsdf({"633 nm": Lopsided()}), None, "x") == "633 nm"
    with pytest.raises(UsageError, match="--channel"):
        asking.channel_of(Bsdf({"a": Lopsided(), "b": Lopsided()}), None, "x")


def test_outside_and_absent_are_told_apart() -> None:
    class Hole(Lopsided):
        def dsf_per_sr(self, incident: FloatArray, outgoing: FloatArray, which: IndexArray | None = None) -> FloatArray:
            dsf = super().dsf_per_sr(incident, outgoing, which)
            return np.where(outgoing[:, 2] < 0.5, np.nan, dsf)

        def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
            return incident_front and outgoing_front

    answers = ask(Hole(), np.array([[0.0, 0.0, 1.0]]), unit_from_angles_deg([10.0, 80.0, 170.0], 0.0))
    assert answers.reason.tolist() == [Reason.NONE, Reason.OUTSIDE, Reason.ABSENT]
    assert answers.origin.tolist() == [Origin.MEASURED, Origin.ABSENT, Origin.ABSENT]


@pytest.mark.parametrize("kind", ["h5", "csv", "pab", "model"])
def test_points_are_fitted_and_asked(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The same sample as dataset, CSV and pab text, and its fitted model: near the closed form in all of them."""
    dataset = lopsided_dataset(((0.0, 0.0), (40.0, 20.0), (40.0, 140.0), (40.0, 260.0)), rings=16)
    path = Path(f"points.{kind}")
    if kind == "h5":
        write_dataset(dataset, path)
    elif kind == "csv":
        csv_points.write(dataset, path)
    elif kind == "pab":
        dataset = lopsided_dataset(((40.0, 20.0),), rings=16)
        paths = pab_write.write(dataset, Path("points.txt"), front="interior").paths
        path = next(p for p in paths if "_r" in p.name or "refl" in p.name or len(paths) == 1)
    else:
        from gonio.model.fitted import fit_bsdf  # noqa: PLC0415 - only here
        from gonio.model.model_file import write_model  # noqa: PLC0415

        write_model(fit_bsdf(dataset), path)
    found, _ = asked([str(path), "--incident", "40,20", "--outgoing", "30,300", "--symmetry", "none"], capsys)
    incident, outgoing = unit_from_angles_deg([40.0], [20.0]), unit_from_angles_deg([30.0], [300.0])
    expected = Lopsided().dsf_per_sr(incident, outgoing)[0] / np.cos(np.radians(30.0))
    assert found["bsdf_per_sr"] == pytest.approx(expected, rel=0.02)
    assert found["origin"] in ("measured", "interpolated")
