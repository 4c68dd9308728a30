"""test_klems_scattering.py: Klems matrices answer where the conventions say, on all four ways through the sample."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from lopsided_sample import COMPONENTS, Lopsided, exact_matrices, patch_means

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, FloatArray, Origin
from gonio.formats import validity
from gonio.formats.findings import Findings
from gonio.formats.window.klems import BASES
from gonio.formats.window.read import WindowBsdf
from gonio.formats.window.scattering import KlemsScattering, bsdf_of, window_bsdf
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

SEATEX = Path(__file__).parents[1] / "data" / "window_xml" / "46016_SEATEX_Midnight.xml"
FULL = BASES["klems-full"]


def sphere(n: int) -> FloatArray:
    """Fibonacci lattice, unit vectors (n, 3)."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    phi = np.pi * (1.0 + 5.0**0.5) * k
    r = np.sqrt(1.0 - z**2)
    return np.stack((r * np.cos(phi), r * np.sin(phi), z), axis=1)


def window_of(
    matrices: dict[tuple[str, str], FloatArray], path: Path = Path("x.xml"), comments: str = ""
) -> WindowBsdf:
    named = {("Visible", *key): matrix for key, matrix in matrices.items()}
    text = {"Comments": comments} if comments else {}
    return WindowBsdf(path, FULL, named, text, {}, None, Findings("x"), ET.Element("x"))  # type: ignore[arg-type]


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_matrices_answer_where_the_conventions_say(faces: Side) -> None:
    """The trial of CONVENTIONS.md: one value at column (40, 0), row (40, 90) of each matrix, in Radiance's frame."""
    column, row = int(FULL.patch_of(40.0, 0.0)), int(FULL.patch_of(40.0, 90.0))
    for process, side, incident, outgoing in (
        ("Transmission", "Front", (140.0, 180.0), (40.0, 90.0)),
        ("Transmission", "Back", (40.0, 180.0), (140.0, 90.0)),
        ("Reflection", "Front", (140.0, 180.0), (140.0, 90.0)),
        ("Reflection", "Back", (40.0, 180.0), (40.0, 90.0)),
    ):
        matrix = np.zeros((FULL.size, FULL.size))
        matrix[row, column] = 2.5
        model = KlemsScattering(window_of({(process, side): matrix}), "Visible", faces)

        def ours(direction: tuple[float, float]) -> FloatArray:
            theta, phi = direction if faces == "interior" else (180.0 - direction[0], 180.0 - direction[1])
            return unit_from_angles_deg([theta], [phi])

        there = model.dsf_per_sr(ours(incident), ours(outgoing))
        assert there == pytest.approx([2.5 * np.cos(np.radians(40.0))])
        unit = sphere(20000)
        everywhere = model.dsf_per_sr(ours(incident), unit)
        assert np.nansum(everywhere) * 4.0 * np.pi / 20000 == pytest.approx(
            2.5 * FULL.projected_solid_angle_sr[row], rel=0.1
        )
        lit, leaves = ours(incident)[0, 2] > 0, ours(outgoing)[0, 2] > 0
        same_side = (unit[:, 2] > 0) == leaves
        assert np.isnan(everywhere[~same_side]).all()  # the file has no matrix for that side
        assert not np.isnan(everywhere[same_side]).any()
        origin = model.origin(ours(incident), unit)
        assert set(origin[~same_side]) == {Origin.ABSENT}
        assert set(origin[same_side]) == {Origin.INTERPOLATED}
        for a in (True, False):
            for b in (True, False):
                assert model.covers(incident_front=a, outgoing_front=b) == ((a, b) == (lit, leaves))


@pytest.mark.parametrize("faces", ["interior", "exterior"])
def test_a_sample_without_symmetry_answers_patch_by_patch(faces: Side) -> None:
    """Every value is the sample's own at the means of the two patches that the directions lie in; many rows at once."""
    model = KlemsScattering(window_of(exact_matrices(FULL, faces)), "Visible", faces)
    generator = np.random.default_rng(3)
    incident, outgoing = (v[generator.permutation(len(v))] for v in (sphere(400), sphere(3000)))
    which = generator.integers(0, len(incident), len(outgoing))
    found = model.bsdf_per_sr(incident, outgoing, which)
    truth = Lopsided().dsf_per_sr(incident, outgoing, which) / np.abs(outgoing[:, 2])
    assert np.abs(found / truth - 1.0).max() < 0.5  # patches are coarse,
    assert np.abs(np.mean(found / truth) - 1.0) < 0.01  # but lie where they should
    one_by_one = [float(model.bsdf_per_sr(incident[[w]], outgoing[[i]])[0]) for i, w in enumerate(which[:200])]
    assert found[:200].tolist() == one_by_one
    # A mirrored or exchanged axis would show: slopes of 20 to 55 % along x and y.
    for turn in (np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0])):
        moved = Lopsided().dsf_per_sr(incident, outgoing * turn, which) / np.abs(outgoing[:, 2])
        assert np.std(moved / found) > 3.0 * np.std(truth / found)


def test_patch_means_are_the_means() -> None:
    unit = sphere(200000)
    unit = unit[unit[:, 2] > 0]
    patch = FULL.patch_of(np.degrees(np.arccos(unit[:, 2])), np.degrees(np.arctan2(unit[:, 1], unit[:, 0])))
    weight = np.bincount(patch, unit[:, 2])
    for axis in (0, 1):
        counted = np.bincount(patch, unit[:, 2] * unit[:, axis]) / weight
        assert counted == pytest.approx(patch_means(FULL)[:, axis], abs=0.004)


def test_grazing_has_a_bsdf_and_no_dsf() -> None:
    model = KlemsScattering(window_of(exact_matrices(FULL)), "Visible", "interior")
    incident, grazing = unit_from_angles_deg([20.0], [30.0]), np.array([[0.0, 1.0, 0.0]])
    assert model.dsf_per_sr(incident, grazing)[0] == 0.0
    row, column = FULL.patch_of(90.0, 90.0), FULL.patch_of(20.0, 210.0)
    assert model.bsdf_per_sr(incident, grazing)[0] == exact_matrices(FULL)["Reflection", "Back"][row, column]


def test_seatex_and_which_way_its_front_faces() -> None:
    bsdf, findings = window_bsdf(SEATEX)
    assert (bsdf.front_faces, list(bsdf.channels), findings.source) == ("exterior", ["visible", "solar"], SEATEX.name)
    unit = sphere(40000)
    normal = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    for front in (True, False):  # of the sample, lit at normal incidence
        dsf = bsdf.channels["visible"].dsf_per_sr(normal[[0 if front else 1]], unit)
        behind = (unit[:, 2] < 0.0) == front
        assert dsf[behind].sum() * 4 * np.pi / len(unit) == pytest.approx(0.059277, rel=0.02)
        assert dsf[~behind].sum() * 4 * np.pi / len(unit) == pytest.approx(0.082136, rel=0.02)
    other, _ = window_bsdf(SEATEX, "interior")
    turned = unit * np.array([-1.0, 1.0, -1.0])
    incident = unit_from_angles_deg([35.0], [60.0])
    assert np.array_equal(
        bsdf.channels["visible"].dsf_per_sr(incident, unit),
        other.channels["visible"].dsf_per_sr(incident * np.array([-1.0, 1.0, -1.0]), turned),
    )
    with pytest.raises(UsageError, match="--front"):
        KlemsScattering(window_of({}), "Visible", "undeclared")


def test_what_a_file_of_ours_says_goes_before_the_default(tmp_path: Path) -> None:
    path = tmp_path / "x.xml"
    path.write_bytes(b"")
    said = f"Written by gonio. {validity.FRONT_SENTENCE}back. Polarisation unknown."
    assert bsdf_of(window_of(exact_matrices(FULL), path, said))[0].front_faces == "interior"
    assert bsdf_of(window_of(exact_matrices(FULL), path, said), "exterior")[0].front_faces == "exterior"
    only_front = Bsdf({"visible": OneSided()}, front_faces="interior", symmetry="none")
    matrices = exact_matrices(FULL, "interior") | {
        ("Transmission", "Front"): np.zeros((145, 145)),
        ("Reflection", "Front"): np.zeros((145, 145)),
    }
    bsdf, findings = bsdf_of(window_of(matrices, path, f"A. {validity.line(only_front)} B."))
    assert (bsdf.front_faces, bsdf.symmetry, findings.items) == ("interior", "none", [])
    scattering = bsdf.channels["visible"]
    down, up = unit_from_angles_deg([130.0], [0.0]), unit_from_angles_deg([50.0], [0.0])
    assert np.isnan(scattering.dsf_per_sr(down, up)[0])  # zeros that nobody measured are no value
    assert scattering.origin(down, up)[0] == Origin.ABSENT
    assert scattering.origin(up, up)[0] == Origin.INTERPOLATED
    assert scattering.origin(unit_from_angles_deg([75.0], [0.0]), up)[0] == Origin.EXTRAPOLATED
    # A band that no range names, as a file's Solar block of zeros.
    both = window_of(matrices, path, validity.line(only_front))
    both.matrices["Solar", "Reflection", "Back"] = np.zeros((145, 145))
    assert np.isnan(bsdf_of(both)[0].channels["solar"].dsf_per_sr(up, up)[0])
    both.matrices["Solar", "Reflection", "Back"] += 0.1
    assert bsdf_of(both)[0].channels["solar"].origin(up, up)[0] == Origin.INTERPOLATED
    # Who says that the front faces the other way sees the same room.
    other, _ = bsdf_of(window_of(matrices, path, validity.line(only_front)), "exterior")
    assert other.channels["visible"].origin(down, down)[0] == Origin.INTERPOLATED
    assert other.channels["visible"].origin(up, down)[0] == Origin.ABSENT
    damaged, findings = bsdf_of(window_of(matrices, path, f"{validity.MARK} {{oops"))
    assert findings.codes == {"validity"}
    assert damaged.channels["visible"].origin(down, up)[0] == Origin.INTERPOLATED


class OneSided(Lopsided):
    """Measured from the front at up to 60 degrees of incidence."""

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        del outgoing_front
        return incident_front

    def origin(self, incident, outgoing, which=None):  # type: ignore[no-untyped-def]
        own = incident[np.zeros(len(outgoing), dtype=int) if which is None else which]
        far = np.where(own[:, 2] < np.cos(np.radians(60.0)) - 1e-9, Origin.EXTRAPOLATED, Origin.MEASURED)
        return np.where(own[:, 2] < 0, Origin.ABSENT, far).astype(np.uint8)


def test_components_are_all_different() -> None:
    assert len(set(COMPONENTS.values())) == 4
