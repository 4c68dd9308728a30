"""test_validate_klems.py: the figures of gonio validate about Klems matrices, against plain sums and known samples."""

import json
from pathlib import Path

import numpy as np
import pytest
from lopsided_sample import exact_matrices
from wild_xml import SMALL, klems_xml

from gonio.cli.main import run
from gonio.dataset.scattering import FloatArray
from gonio.formats import validity
from gonio.formats.findings import Findings
from gonio.formats.validate import validate
from gonio.formats.validate.document import Profile
from gonio.formats.validate.klems_values import opposite_patches, residual_of
from gonio.formats.window.klems import BASES, basis_from_rings

Matrices = dict[tuple[str, str, str], FloatArray]
FULL = BASES["klems-full"]


def both(matrices: dict[tuple[str, str], FloatArray], solar: float = 0.5) -> Matrices:
    return {
        (band, *key): factor * matrix
        for band, factor in (("Visible", 1.0), ("Solar", solar))
        for key, matrix in matrices.items()
    }


def lopsided() -> dict[tuple[str, str], FloatArray]:
    return {(process, side): matrix for (process, side), matrix in exact_matrices(SMALL).items()}


def judged(tmp_path: Path, matrices: Matrices, profile: Profile = "window", **how: str) -> Findings:
    path = tmp_path / "x.xml"
    path.write_text(klems_xml(matrices, **how))  # type: ignore[arg-type]
    return validate(path, profile)


def message(findings: Findings, code: str, where: str) -> str:
    return next(f.message for f in findings.items if (f.code, f.where) == (code, where))


def reciprocal(direction: str) -> dict[tuple[str, str], FloatArray]:
    """A sample whose BSDF depends on |x_i - x_s| and so on only: the same with the light reversed."""
    polar, azimuth = np.radians(SMALL.centres_deg).T
    xy = np.stack((np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth)), axis=1)
    source = -xy  # a column's azimuth is the source's plus 180 degrees
    apart = np.linalg.norm(xy[:, None] - source[None, :], axis=2)
    forth = 0.05 + 0.02 * np.exp(-(apart**2)) + 0.01 * (xy[:, None] + source[None, :]).sum(axis=2)
    return {(process, side): forth for process in ("Reflection", "Transmission") for side in ("Front", "Back")} | {
        (direction, "Front"): forth
    }


def test_reciprocity_is_nothing_for_a_reciprocal_sample_and_what_was_done_to_it_else(tmp_path: Path) -> None:
    findings = judged(tmp_path, both(reciprocal("Reflection")))
    for where in ("Reflection Front", "Reflection Back", "Transmission"):
        assert message(findings, "reciprocity", f"Visible {where}").startswith("residual 0.00 %")
    bent = reciprocal("Reflection")
    bent["Reflection", "Front"] = bent["Reflection", "Front"].copy()
    bent["Reflection", "Front"][:, 7] *= 1.5  # one incident patch is half as bright again
    opposite = opposite_patches(SMALL)
    assert opposite is not None
    size = SMALL.projected_solid_angle_sr
    r = bent["Reflection", "Front"]
    above = below = 0.0
    for row in range(SMALL.size):
        for column in range(SMALL.size):
            back = r[opposite[column], opposite[row]]
            above += size[row] * size[column] * (r[row, column] - back) ** 2
            below += size[row] * size[column] * (0.5 * (r[row, column] + back)) ** 2
    expected = f"residual {100 * np.sqrt(above / below):.2f} %"
    findings = judged(tmp_path, both(bent))
    assert message(findings, "reciprocity", "Visible Reflection Front").startswith(expected)
    assert message(findings, "reciprocity", "Visible Transmission").startswith("residual 0.00 %")
    # Transmission is compared between the two sides.
    bent = reciprocal("Transmission")
    bent["Transmission", "Back"] = 1.1 * bent["Transmission", "Back"]
    findings = judged(tmp_path, both(bent))
    assert message(findings, "reciprocity", "Visible Transmission").startswith(f"residual {100 * 0.1 / 1.05:.2f} %")
    assert findings.exit_status == 1  # because of the basis alone
    assert {f.code for f in findings.of("error", "warning") if f.code != "schema"} == {"basis"}


def test_opposite_patches_are_half_a_turn_away() -> None:
    for basis in BASES.values():
        opposite = opposite_patches(basis)
        assert opposite is not None
        assert np.array_equal(opposite[opposite], np.arange(basis.size))
        polar, azimuth = basis.centres_deg.T
        assert np.array_equal(basis.patch_of(polar, azimuth + 180.0), opposite)
    assert opposite_patches(basis_from_rings("odd", (0, 45), (0, 10, 90), (1, 7))) is None
    assert residual_of(np.zeros((2, 2)), np.zeros((2, 2)), np.ones((2, 2))) == 0.0


def test_column_sums_are_the_files(tmp_path: Path) -> None:
    findings = judged(tmp_path, both(lopsided()), "radiance")
    size = SMALL.projected_solid_angle_sr
    for side in ("Front", "Back"):
        tau, rho = (size @ lopsided()[process, side] for process in ("Transmission", "Reflection"))  # type: ignore[index]
        found = message(findings, "column-sums", f"Visible {side}")
        assert f"transmission {tau.min():.4f} to {tau.max():.4f} ({tau[0]:.4f} at normal)" in found
        assert f"reflection {rho.min():.4f} to {rho.max():.4f}" in found
    assert findings.exit_status == 0


def test_too_much_energy_in_one_column(tmp_path: Path) -> None:
    matrices = both(lopsided())
    matrices["Solar", "Transmission", "Back"] = matrices["Solar", "Transmission", "Back"].copy()
    matrices["Solar", "Transmission", "Back"][:, 5] += 0.3
    findings = judged(tmp_path, matrices, "radiance")
    assert [(f.code, f.where) for f in findings.of("error")] == [("energy", "Solar Back")]
    assert "1 columns" in findings.of("error")[0].message
    assert "column 6" in findings.of("error")[0].message


def test_copied_blocks_and_equal_sides(tmp_path: Path) -> None:
    assert "copied" in judged(tmp_path, both(lopsided(), 1.0)).codes
    found = judged(tmp_path, both(lopsided(), 0.999))
    assert not found.codes & {"copied", "same-sides"}
    same = lopsided()
    same["Reflection", "Back"] = same["Reflection", "Front"]
    assert [f.where for f in judged(tmp_path, both(same)).items if f.code == "same-sides"] == [
        "Visible Reflection",
        "Solar Reflection",
    ]


def test_sides_and_blocks(tmp_path: Path) -> None:
    front_only = {key: m for key, m in both(lopsided()).items() if key[2] == "Front"}
    comments = f"{validity.FRONT_SENTENCE}back."
    findings = judged(tmp_path, front_only, "window", comments=comments)
    assert "where the sample's back faces" in message(findings, "sides", "WavelengthDataDirection")
    assert len([f for f in findings.of("error") if f.code == "missing"]) == 4
    assert judged(tmp_path, front_only, "radiance").exit_status == 0
    solar = {key: m for key, m in front_only.items() if key[0] == "Solar"}
    assert [f.code for f in judged(tmp_path, solar, "radiance").of("error")] == ["missing"]
    zeros = front_only | {("Visible", "Reflection", "Front"): np.zeros((SMALL.size, SMALL.size))}
    findings = judged(tmp_path, zeros, "radiance")
    assert message(findings, "zeros", "Visible Reflection Front") == "all values are zero: not measured?"
    negative = {key: m - 0.06 for key, m in front_only.items()}
    assert "negative" in judged(tmp_path, negative, "radiance").codes


def test_the_command_says_it_as_text_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.xml"
    path.write_text(klems_xml(both(lopsided())))
    assert run(["validate", str(path), "--profile", "radiance"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("x.xml: 0 errors, 0 warnings")
    assert run(["validate", str(path), "--profile", "radiance", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["exit_status"] == 0
    assert "reciprocity" in {f["code"] for f in found["findings"]}
    path.write_text(klems_xml({key: -matrix for key, matrix in both(lopsided()).items()}))
    assert run(["validate", str(path), "--profile", "radiance"]) == 1
    path.write_text("<WindowElement>")
    assert run(["validate", str(path)]) == 2
