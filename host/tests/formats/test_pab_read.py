"""test_pab_read.py: pab text as it is found: angles, quantities, units, files of one dataset, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from gonio.dataset.bsdf import Distribution
from gonio.formats.pab import dataset as pab_dataset
from gonio.geometry.directions import unit_from_angles_deg
from gonio.units.errors import UsageError

# The smallest header that pabopto2bsdf takes; no #upphi: up is at azimuth 0.
MINIMAL = "#incident_angle 82.5 180\n#format: theta phi DSF\n84.968 125.790 0.009744\n84.889 125.610 -0.000737\n"
HEAD = "#incident_angle 30 45\n#upphi 90\n"


def read(tmp_path: Path, *texts: str | bytes, **options):  # type: ignore[no-untyped-def]
    paths = []
    for number, text in enumerate(texts):
        paths.append(tmp_path / f"scan{number}.txt")
        paths[-1].write_bytes(text if isinstance(text, bytes) else text.encode())
    return pab_dataset.read(paths, **options)


def only(tmp_path: Path, text: str | bytes, **options) -> Distribution:  # type: ignore[no-untyped-def]
    (distribution,) = read(tmp_path, text, **options).distributions
    return distribution


def test_without_upphi_up_is_at_azimuth_zero_and_comes_to_ours(tmp_path: Path) -> None:
    d = only(tmp_path, MINIMAL)
    assert (d.incident_theta_deg, d.incident_phi_deg) == (82.5, 270.0)
    assert d.theta_deg.tolist() == [84.968, 84.889]
    assert d.phi_deg.tolist() == [215.79, 215.61]  # to the digit, not 215.79000000000002
    assert d.dsf_per_sr.tolist() == [0.009744, -0.000737]  # negative noise is kept
    np.testing.assert_allclose(np.sqrt(12 * d.variance_per_sr2), 1e-6, rtol=1e-12)  # of rounding
    assert d.p_i == 1.0
    assert d.channel == "visible"


def test_upphi_says_where_up_is(tmp_path: Path) -> None:
    """What lies towards up has +y in our frame, whatever the file calls that azimuth."""
    for up in (0, 90, 215.5, -30):
        d = only(tmp_path, f"#incident_angle 40 {up}\n#upphi {up}\n#format: theta phi DSF\n60 {up + 90} 1\n")
        np.testing.assert_allclose(
            unit_from_angles_deg(d.incident_theta_deg, d.incident_phi_deg)[:2], [0, 0.642788], atol=1e-6
        )
        np.testing.assert_allclose(unit_from_angles_deg(d.theta_deg, d.phi_deg)[0, :2], [-0.866025, 0], atol=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "#format: theta phi DSF\n10\t20\t0.5\n170 350.25 -1e-3\n",
        HEAD.replace("\n", "\r\n") + "#format: theta phi DSF\r\n  10 20   0.5\r\n170\t350.25 -1E-3 \r\n\r\n",
        "\ufeff" + HEAD + "#format:\ttheta\tphi\tdsf\n\n10 20 .5\n# shutter opened again\n170 350.25 -0.001",
        "#intheta 30\n#inphi 45\n" + HEAD + "#format: theta phi DSF\n10 20 5e-1\n170 -9.75 -0.001\n",
        "#intheta\t-30\n#inphi\t225\n#upphi 90\n#format: theta phi DSF\n-10 200 0.5\n190 170.25 -0.001\n",
    ],
    ids=["tabs", "crlf", "bom and comment", "both angles", "signed"],
)
def test_ways_of_writing_the_same(tmp_path: Path, text: str) -> None:
    d = only(tmp_path, text)
    assert (d.incident_theta_deg, d.incident_phi_deg) == (30.0, 45.0)
    assert d.theta_deg.tolist() == [10.0, 170.0]
    assert d.phi_deg.tolist() == [20.0, 350.25]
    assert d.dsf_per_sr.tolist() == [0.5, -0.001]


@pytest.mark.parametrize("word", ["BSDF", "brdf", "BTDF"])
def test_bsdf_becomes_dsf_and_is_no_dsf_at_the_horizon(tmp_path: Path, word: str) -> None:
    d = only(tmp_path, HEAD + f"#format: theta phi {word}\n60 0 2\n120 0 2\n90 0 2\n")
    np.testing.assert_allclose(d.dsf_per_sr, [1.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(np.sqrt(12 * d.variance_per_sr2), [0.5, 0.5, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("line", "unit"),
    [
        ("#format: theta phi photocurrent A\n", "A"),
        ("#format: theta phi [nA]\n", "nA"),
        ("#format: theta phi\n", "unstated"),
        ("", "unstated"),
    ],
)
def test_a_raw_signal_keeps_its_unit_until_p_i_is_known(tmp_path: Path, line: str, unit: str) -> None:
    text = HEAD + line + "10 20 3.25e-9\n30 40 -1.5e-10\n"
    d = only(tmp_path, text)
    assert d.signal_unit == unit
    assert d.signal.tolist() == [3.25e-9, -1.5e-10]
    assert np.isnan(d.p_i)
    assert np.isnan(d.dsf_per_sr).all()
    assert "--beam or --p-i" in pab_dataset.remarks(read(tmp_path, text))[0]
    known = only(tmp_path, text, p_i=2.5e-9)
    assert known.signal_unit == unit
    np.testing.assert_allclose(known.dsf_per_sr, [1.3, -0.06], rtol=1e-15)
    np.testing.assert_allclose(np.sqrt(12 * known.variance_per_sr2), [1e-11 / 2.5e-9, 1e-11 / 2.5e-9], rtol=1e-12)


def gaussian_scan(sigma_deg: float, peak: float, about: tuple[float, float], pitch_deg: float = 0.05) -> str:
    """A square grid of readings of a round beam about a direction, 9 sigma wide."""
    steps = np.arange(-4.5 * sigma_deg, 4.5 * sigma_deg + 1e-9, pitch_deg)
    x, y = (np.radians(grid.ravel()) for grid in np.meshgrid(steps, steps))
    pole = unit_from_angles_deg(*about)
    e1 = unit_from_angles_deg(about[0] - 90.0, about[1])
    e2 = np.cross(pole, e1)
    r = np.hypot(x, y)
    along = np.sinc(r / np.pi)[:, None] * (x[:, None] * e1 + y[:, None] * e2)
    unit = np.cos(r)[:, None] * pole + along
    theta = np.degrees(np.arccos(unit[:, 2]))
    phi = np.degrees(np.arctan2(unit[:, 1], unit[:, 0]))
    value = peak * np.exp(-0.5 * (r / np.radians(sigma_deg)) ** 2)
    rows = "\n".join(f"{t:.6f} {p:.6f} {v:.9e}" for t, p, v in zip(theta, phi, value, strict=True))
    return f"#incident_angle 0 0\n#upphi 90\n#format: theta phi A\n{rows}\n"


@pytest.mark.parametrize("about", [(180.0, 0.0), (139.0, 77.0)])
def test_p_i_of_a_scanned_beam_is_its_closed_form(tmp_path: Path, about: tuple[float, float]) -> None:
    """The integral of peak exp(-r^2 / 2 sigma^2) is 2 pi sigma^2 peak (small angles)."""
    beam = tmp_path / "beam.txt"
    beam.write_text(gaussian_scan(0.4, 2e-6, about))
    dataset = read(tmp_path, HEAD + "#format: theta phi A\n10 20 1e-9\n", beam=beam)
    (d,) = dataset.distributions
    expected = 2 * np.pi * np.radians(0.4) ** 2 * 2e-6
    assert d.p_i == pytest.approx(expected, rel=1e-3)
    assert d.dsf_per_sr[0] == pytest.approx(1e-9 / expected, rel=1e-3)
    assert d.p_i_u_rel < 0.01
    assert dataset.beam is not None
    assert dataset.beam.theta_deg[np.argmax(dataset.beam.signal)] < 0.01
    axis = dataset.provenance["imported"]["beam"]["axis_deg"]
    assert axis[0] == pytest.approx(about[0], abs=1e-3)
    assert float(dataset.beam.signal @ dataset.beam.solid_angle_sr) == pytest.approx(d.p_i, rel=1e-12)


def test_a_beam_in_another_unit_or_wider_than_a_beam_is_refused(tmp_path: Path) -> None:
    scan = HEAD + "#format: theta phi A\n10 20 1e-9\n"
    beam = tmp_path / "beam.txt"
    for text, words in (
        (gaussian_scan(0.4, 1, (180, 0), 0.3).replace("phi A", "phi nA"), "beam is in nA"),
        (gaussian_scan(20, 1, (180, 0), 4.0), "no scan of a beam"),
        (gaussian_scan(0.4, -1, (180, 0), 0.3), "saw no light"),
        (MINIMAL, "a free beam is a raw signal"),
    ):
        beam.write_text(text)
        with pytest.raises(UsageError, match=words):
            read(tmp_path, scan, beam=beam)


def test_files_of_one_incident_direction_are_one_distribution(tmp_path: Path) -> None:
    front = '#sample_name "a tile"\n' + HEAD + "#operator LK\n#format: theta phi DSF\n10 20 1\n20 20 2\n"
    back = HEAD + "#filter 3\n#format: theta phi DSF\n170 20 3\n"
    other = "#incident_angle 60 45\n#upphi 90\n#format: theta phi DSF\n10 20 4\n"
    dataset = read(tmp_path, front, other, back)
    assert dataset.sample_name == "a tile"
    first, second = dataset.distributions
    assert first.dsf_per_sr.tolist() == [1, 2, 3]
    assert first.path.tolist() == [0, 0, 1]
    assert first.paths == ("scan0.txt", "scan2.txt")
    assert second.dsf_per_sr.tolist() == [4]
    entries = dataset.provenance["imported"]["files"]
    assert [entry["header"] for entry in entries] == [["#operator LK"], [], ["#filter 3"]]
    assert all(len(entry["sha256"]) == 64 for entry in entries)


def test_cie_xyz_is_three_channels(tmp_path: Path) -> None:
    dataset = read(tmp_path, HEAD + "#colorimetry: CIE-XYZ\n#format: theta phi DSF\n10 20 1 2 3\n30 40 4 5 6\n")
    found = {d.channel: d.dsf_per_sr.tolist() for d in dataset.distributions}
    assert found == {"CIE-X": [1, 4], "CIE-Y": [2, 5], "CIE-Z": [3, 6]}


def test_a_wrong_count_of_points_is_said(tmp_path: Path) -> None:
    text = HEAD + "#datapoints_in_file: 3\n#format: theta phi DSF\n10 20 1\n"
    assert pab_dataset.remarks(read(tmp_path, text)) == ["scan0.txt: says 3 points and holds 1."]
    assert not pab_dataset.remarks(read(tmp_path, text.replace("file: 3", "file 1")))


FORMAT = "#format: theta phi DSF\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("once upon a time\n", "is no pab text"),
        ("#\0", "is no text file"),
        (FORMAT + "1 2 3\n", "no #incident_angle"),
        ("#intheta 20\n" + FORMAT + "1 2 3\n", "no #incident_angle"),
        (HEAD + FORMAT, "no row"),
        (HEAD + FORMAT + "1 2\n", "line 4 is not 3 numbers"),
        (HEAD + FORMAT + "1 2 3\n\n1 2 3 4\n", "line 6"),
        (HEAD + FORMAT + "1 2 3\n1 2 x\n1 2 3\n", "line 5"),
        (HEAD + FORMAT + "1 2 3\n1 2 1e\n1 2 3\n", "line 5"),
        (HEAD + FORMAT + "1 2 3\n1 2 nan\n", "line 5"),
        (HEAD + FORMAT + "1 2 3\n# pause\n1 2 1e999\n", "line 6"),
        (HEAD + FORMAT + "1,2,3\n", "line 4"),
        (HEAD + FORMAT + "400 2 3\n", "impossible angle"),
        (HEAD + FORMAT + "1 2 3\n#incident_angle 40 45\n1 2 3\n", "two files in one"),
        (HEAD + "#intheta 31\n" + FORMAT + "1 2 3\n", "differs"),
        (HEAD + "#upphi 0\n" + FORMAT + "1 2 3\n", "something else before"),
        ("#incident_angle 30\n" + FORMAT + "1 2 3\n", "incident_angle '30' is not 2 angle"),
        ("#incident_angle 300 0\n" + FORMAT + "1 2 3\n", "over 180"),
        (HEAD + "#format: phi theta DSF\n1 2 3\n", "only that order"),
        (HEAD + "#colorimetry: CIE-XYZ\n" + FORMAT + "1 2 3\n", "not 5 numbers"),
        (HEAD + "#gonio_front_faces up\n" + FORMAT + "1 2 3\n", "none of exterior"),
        (HEAD + "#gonio_wavelength_nm long\n" + FORMAT + "1 2 3\n", "not one length"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("texts", "options", "words"),
    [
        ([MINIMAL], {"p_i": 1.0}, "normalised already"),
        ([HEAD + "1 2 3\n"], {"p_i": -1.0}, "P_i is -1"),
        ([MINIMAL, HEAD + "#format: theta phi A\n1 2 3\n"], {}, "holds a signal in A"),
        ([MINIMAL, MINIMAL], {}, "same file"),
        ([MINIMAL, HEAD + "#gonio_front_faces exterior\n#format: theta phi DSF\n1 2 3\n"], {}, "differ in"),
    ],
)
def test_files_that_do_not_fit_together_are_refused(tmp_path: Path, texts, options, words: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(UsageError, match=words):
        read(tmp_path, *texts, **options)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + FORMAT + "1 2 3\n4 5 0.0", "the last line has no end"),
        (HEAD + FORMAT + "1 2 3\n200 5 1\n", "rows with theta over 180: 1"),
        (HEAD + "1 2 3\n", "say so in a line #format: theta phi DSF"),
    ],
)
def test_what_looks_odd_is_said_and_read(tmp_path: Path, text: str, words: str) -> None:
    assert words in " ".join(pab_dataset.remarks(read(tmp_path, text)))
    assert pab_dataset.remarks(read(tmp_path, HEAD + FORMAT + "1 2 3\n")) == []


def test_of_several_files_it_is_said_which_went_together(tmp_path: Path) -> None:
    rows = FORMAT + "1 2 3\n"
    told = pab_dataset.remarks(read(tmp_path, HEAD + rows, HEAD + FORMAT + "4 5 6\n", "#incident_angle 40 0\n" + rows))
    assert told == [
        "incident 30/45, visible: 2 points of scan0.txt, scan1.txt.",
        "incident 40/90, visible: 1 points of scan2.txt.",
    ]
