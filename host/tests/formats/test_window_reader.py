"""test_window_reader.py: reading and validating files from the wild, damaged files and hostile ones."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_bsdf import lambert_and_mirror

from gonio.formats import validate, xml_guard
from gonio.formats.window import read as window_reader
from gonio.formats.window import write as window_xml
from gonio.units.errors import UsageError

SEATEX = Path(__file__).parents[1] / "data" / "window_xml" / "46016_SEATEX_Midnight.xml"


@pytest.fixture(scope="module")
def seatex() -> str:
    return SEATEX.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def small() -> bytes:
    """A complete small file (41 patches), so that mutations are quick to read."""
    dataset = lambert_and_mirror((30.0,), coarse=600)
    built = window_xml.build(dataset, basis="klems-quarter", fill="nearest", assume_flat=True)
    return window_xml.render(dataset, built, window_xml.ThermalValues())


def read_text(tmp_path: Path, text: str) -> window_reader.WindowBsdf:
    path = tmp_path / "wild.xml"
    path.write_text(text, encoding="utf-8")
    return window_reader.read(path)


def test_seatex_reads_with_its_published_values() -> None:
    content = window_reader.read(SEATEX)
    for side in ("Front", "Back"):
        assert content.hemispherical("Visible", "Transmission", side)[0] == pytest.approx(0.059277, abs=5e-7)
        assert content.hemispherical("Visible", "Reflection", side)[0] == pytest.approx(0.082136, abs=5e-7)
    assert content.text["Name"] == "SEATEX Midnight"
    assert content.thickness_mm == pytest.approx(0.48)
    assert content.numbers["EmissivityFront"] == 0.835
    findings = validate.validate(SEATEX)
    assert findings.exit_status == 0
    assert json.loads(json.dumps(findings.as_json()))["exit_status"] == 0


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda t: "exported 2020\n" + t, "stray-bytes"),
        (lambda t: t.replace('unit="Millimeter"', 'unit="millimeter"'), "unit"),
        (lambda t: t.replace('<Thickness unit="Millimeter">0.48', "<Thickness>0.00048"), "unit"),
        (lambda t: t.replace(">Visible<", ">visible<"), "label"),
        (lambda t: t.replace("Reflection Front", "Reflectance Front"), "label"),
        (lambda t: t.replace(">BTDF<", ">BRDF<"), "data-type"),
        (lambda t: t.replace(' xmlns="http://windows.lbl.gov"', ""), "namespace"),
        (lambda t: re.sub(r"<ThetaBounds>.*?</ThetaBounds>", "", t, flags=re.DOTALL), "basis"),
        (lambda t: t.replace("<IncidentDataStructure>Columns</IncidentDataStructure>", ""), "structure"),
    ],
)
def test_untidy_files_are_read_and_remarked_on(tmp_path: Path, seatex: str, change, code: str) -> None:  # type: ignore[no-untyped-def]
    content = read_text(tmp_path, change(seatex))
    assert code in content.findings.codes
    assert content.hemispherical("Visible", "Reflection", "Front")[0] == pytest.approx(0.082136, abs=5e-7)
    assert content.thickness_mm == pytest.approx(0.48)


def test_tabs_and_newlines_separate_as_well_as_commas(tmp_path: Path, seatex: str) -> None:
    text = re.sub(r",\s+", "\t", seatex)
    assert read_text(tmp_path, text).hemispherical("Visible", "Transmission", "Front")[0] == pytest.approx(
        0.059277, abs=5e-7
    )


def test_transposed_structure_is_turned(tmp_path: Path, seatex: str) -> None:
    columns = read_text(tmp_path, seatex).matrices["Visible", "Reflection", "Front"]
    rows = read_text(tmp_path, seatex.replace(">Columns<", ">Rows<")).matrices["Visible", "Reflection", "Front"]
    np.testing.assert_array_equal(rows, columns.T)


def cut_block(text: str, label: str) -> str:
    parts = re.split(r"(?=<WavelengthData>)", text)
    return "".join(p for p in parts if f"<WavelengthDataDirection>{label}" not in p or "</Layer>" in p)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda t: t.replace("1.614498", "-1.614498"), "negative"),
        (lambda t: t.replace("1.614498", "41.614498"), "energy"),
        (lambda t: t.replace("<TIR>0.07</TIR>", ""), "field"),
        (lambda t: t.replace("<EmissivityFront>0.835", "<EmissivityFront>8.35"), "field"),
        (lambda t: t.replace("<Manufacturer> Hunter Douglas </Manufacturer>", ""), "field"),
        (lambda t: t.replace("<DeviceType>Other", "<DeviceType>Curtain"), "schema"),
        (lambda t: cut_block(t, "Transmission Back"), "missing"),
        (lambda t: t.replace(">Transmission Back<", ">Transmission Front<"), "repeated"),
    ],
)
def test_validate_finds(tmp_path: Path, seatex: str, change, code: str) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "changed.xml"
    path.write_text(change(seatex), encoding="utf-8")
    findings = validate.validate(path)
    assert code in findings.codes
    assert findings.exit_status == 1
    assert f"[{code}]" in findings.text()


def test_radiance_does_not_need_what_windows_engine_needs(tmp_path: Path, seatex: str) -> None:
    path = tmp_path / "changed.xml"
    path.write_text(cut_block(seatex.replace("<TIR>0.07</TIR>", ""), "Transmission Back"), encoding="utf-8")
    assert validate.validate(path, "window").exit_status == 1
    assert validate.validate(path, "radiance").exit_status == 0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not readable"),
        (b"MCAP0 something else", "not readable"),
        (b"<html><body/></html>", "<html>"),
        (b'<!DOCTYPE x [<!ENTITY a "b">]><WindowElement>&a;</WindowElement>', "DOCTYPE"),
        (b"<a>" * 40 + b"</a>" * 40, "deeper"),
        (b"<WindowElement/>", r"no <Optical>"),
        (b"<WindowElement><Optical><Layer/></Optical></WindowElement>", "no visible or solar"),
        (b'<?xml version="1.0" encoding="klingon"?><a/>', "not readable"),
    ],
)
def test_foreign_and_hostile_files_are_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "foreign.xml"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=words):
        validate.validate(path)


def test_entities_in_another_encoding_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "wide.xml"
    path.write_bytes('<?xml version="1.0" encoding="utf-16"?><!DOCTYPE x><WindowElement/>'.encode("utf-16"))
    with pytest.raises(UsageError, match="DOCTYPE"):
        window_reader.read(path)


def test_large_and_missing_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xml_guard, "MAX_BYTES", 1000)
    with pytest.raises(UsageError, match="larger"):
        window_reader.read(SEATEX)
    with pytest.raises(UsageError, match="cannot be read"):
        window_reader.read(tmp_path / "nothing.xml")
    with pytest.raises(UsageError, match="cannot be read"):
        window_reader.read(tmp_path)


@pytest.mark.parametrize(
    "change", [("1.614498", "nan"), ("1.614498", "1e999"), ("1.614498", "glass"), ("1.614498,", "")]
)
def test_values_that_are_no_numbers_are_refused(tmp_path: Path, seatex: str, change: tuple[str, str]) -> None:
    with pytest.raises(UsageError, match="Visible Transmission Front"):
        read_text(tmp_path, seatex.replace(*change))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_a_cut_off_file_is_refused(tmp_path: Path, seatex: str, share: float) -> None:
    with pytest.raises(UsageError, match=r"wild\.xml"):
        read_text(tmp_path, seatex[: int(len(seatex) * share)])


def outcome(path: Path) -> str:
    """One line: what is wrong with the file, or its exit status. Any other exception fails the test."""
    try:
        return f"exit {validate.validate(path).exit_status}"
    except UsageError as error:
        return str(error)


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_mutated_bytes_give_an_error_or_findings(tmp_path: Path, small: bytes, data: st.DataObject) -> None:
    content = bytearray(small)
    for _ in range(data.draw(st.integers(1, 4))):
        # Two thirds of the cuts hit the head, where the structure is.
        head = data.draw(st.booleans()) or data.draw(st.booleans())
        at = data.draw(st.integers(0, 4000 if head else len(content) - 1))
        length = data.draw(st.integers(0, 40))
        content[at : at + length] = data.draw(st.binary(max_size=20))
    path = tmp_path / "mutated.xml"
    path.write_bytes(bytes(content))
    assert "\n" not in outcome(path)


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    old=st.sampled_from(
        [
            "Theta",
            "nPhis",
            "9",
            "27",
            "41",
            "0",
            "LBNL/Klems Quarter",
            "Visible",
            "Front",
            "BTDF",
            "Layer",
            "1",
            "Columns",
        ]
    ),
    new=st.sampled_from(
        [
            "",
            "-1",
            "0",
            "nan",
            "1e308",
            "1e-320",
            "inf",
            "2.5",
            "99999999999",
            "Phi",
            "<x/>",
            "TensorTree4",
            "\u0660",
            "Back",
        ]
    ),
    count=st.integers(1, 5),
)
def test_mutated_words_give_an_error_or_findings(tmp_path: Path, small: bytes, old: str, new: str, count: int) -> None:
    path = tmp_path / "mutated.xml"
    path.write_text(small.decode().replace(old, new, count), encoding="utf-8")
    assert "\n" not in outcome(path)
