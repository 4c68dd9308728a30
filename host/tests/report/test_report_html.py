"""test_report_html.py: one self-contained file that says what was measured, what not, and how far off."""

import base64
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image as mpimage
from page_outline import Outline
from synthetic_bsdf import distribution, lambert_and_mirror, lobe_per_sr, sphere_points, spiral_about, with_evaluation

from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.formats.tables import nist as nist_csv
from gonio.reduce.imported import reduce_dataset
from gonio.report.html import render, write_report

NIST = Path(__file__).parents[3] / "docs" / "examples" / "nist_ptfe" / "PTFE.data.csv"


class KnownTruth:
    """The closed form of lambert_and_mirror."""

    def dsf_per_sr(self, incident_theta_deg, incident_phi_deg, outgoing):  # type: ignore[no-untyped-def]
        front = outgoing[:, 2] > 0
        diffuse = np.where(front, 0.5, 0.1) / np.pi * np.abs(outgoing[:, 2])
        return diffuse + front * lobe_per_sr(outgoing, (incident_theta_deg, incident_phi_deg + 180), 0.2)

    def integrals(self, incident_theta_deg: float, incident_phi_deg: float) -> dict[str, float]:
        assert 0 <= incident_theta_deg < 90
        assert 0 <= incident_phi_deg < 360
        return {"rho": 0.7, "tau": 0.1}


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    made = lambert_and_mirror((30.0, 60.0))
    for d in made.distributions:
        d.dsf_per_sr *= 1.002
        with_evaluation(d)
        d.integrals[f"peak mirror {d.incident_theta_deg:g}/0 sigma_deg"] *= 1.01
    made.beam = distribution((0, 0), spiral_about(0, 0, 3, 0.2), lambda u: np.where(u[:, 2] > 0.9997, 1.0, 1e-4))
    made.provenance = {
        "counters": {"strobes_lost": 3, "syncs_lost": 0},
        "raw_logs": [{"path": "raw.mcap", "sha256": "abc123"}],
        "note": "<script>alert(1)</script>",
    }
    made.sample_name = "glass <b>&"
    return made


@pytest.fixture(scope="module")
def page(dataset: Dataset) -> str:
    return render(dataset, KnownTruth())


def test_page_is_well_formed_and_needs_no_network(page: str) -> None:
    outline = Outline(page)
    assert not outline.open
    assert outline.tags.count("script") == 1  # our own, the lobes'
    assert outline.tags.count("canvas") == 2
    assert "link" not in outline.tags
    local = [a for a in outline.addresses if a.startswith("#")]
    assert {a[1:] for a in local} == set(outline.ids)
    assert all(a.startswith(("data:image/png;base64,", "#")) for a in outline.addresses)
    assert not re.search(r"url\(|@import|https?://", page)
    assert len(page) < 5_000_000


def test_the_controller_is_shown_where_a_real_one_measured(dataset: Dataset, page: str) -> None:
    assert "Controller" not in Outline(page).text  # a twin in virtual time
    told = {
        "kernel": "Linux 6.1.0 x86_64",
        "realtime": False,
        "notes": {"node 3": "no 0x6007"},
        "latency": {"motion": {"wakeups": 1000, "max_us": 5000, "bins": [0, 0, 999, 0, 1]}},
        "position_time_u_us": {"arm azimuth": 1.0, "arm elevation": 12.34},
    }
    counters = dataset.provenance["counters"] | {"cycles_missed": 17}
    provenance = dataset.provenance | {"controller": told, "counters": counters}
    text = Outline(render(replace(dataset, provenance=provenance))).text
    for words in ("Linux 6.1.0 x86_64 has no PREEMPT_RT", "node 3: no 0x6007", "99.9% within", "1,000 4 5,000"):
        assert words in text
    for words in ("Cycles missed 17", "12.3 \u00b5s"):
        assert words in text
    provenance["controller"] = told | {"realtime": True}
    assert "has no PREEMPT_RT" not in Outline(render(replace(dataset, provenance=provenance))).text


def test_text_from_data_is_escaped(page: str) -> None:
    assert "glass &lt;b&gt;&amp;" in page
    assert "<b>" not in page
    assert "<script>alert" not in page


def test_it_says_what_the_issue_asks_for(page: str) -> None:
    text = Outline(page).text
    for words in (
        "strobes_lost",
        "raw_logs[0].sha256",
        "abc123",
        "shadowed",
        "zeros: Transmission Back, Reflection Back",
        "Solar: not measured",
        "numpy",
        "relative standard uncertainty",
    ):
        assert words in text, words


def cells_of(page: str, word: str) -> list[str]:
    """Cells of the first table row that holds the word."""
    row = next(row for row in re.findall(r"<tr>(.*?)</tr>", page) if word in row)
    return re.findall(r"<td[^>]*>(.*?)</td>", row)


def test_integrals_are_compared_over_the_measured_directions(page: str) -> None:
    """Values 0.2 % too high; the masked zone about the source is in neither sum."""
    cells = cells_of(page, "reflected")
    measured, u, there, whole = float(cells[2]), float(cells[3]), float(cells[5]), float(cells[9])
    assert measured == pytest.approx(1.002 * there, abs=1e-4)
    assert cells[6] == "+0.200 %"
    assert u == pytest.approx(0.001 * measured, rel=0.1)  # of the reference beam
    assert whole == 0.7
    assert there < whole
    assert float(cells[7]) == pytest.approx(1.002 * whole, abs=0.004)  # masked modelled


def test_peaks_are_compared_with_the_same_fit_of_the_truth(page: str) -> None:
    cells = cells_of(page, "<td class=name>mirror</td>")
    integral, u = (float(part) for part in cells[6].split(" \u00b1 "))
    assert integral == pytest.approx(0.2, rel=0.01)
    assert 0 < u < 0.01 * integral
    assert cells[7].endswith("under-sampled")  # 0.4 degrees of pitch across 2.8
    assert float(cells[8]) < 1e-6
    assert cells[9:] == ["+1.000 %", "+0.200 %"]


def test_reports_of_several_channels_name_them() -> None:
    several = lambert_and_mirror((30.0, 60.0))
    for d, channel in zip(several.distributions, ("visible", "solar"), strict=True):
        d.channel = channel
        with_evaluation(d)
    assert cells_of(render(several), "reflected")[:3] == ["30\u00b0 / 0\u00b0", "visible", "\u03c1 reflected"]


def test_losses_are_said_first(page: str) -> None:
    text = re.sub(r"\s+", " ", Outline(page).text)
    assert "Strobe edges lost 3" in text
    assert "syncs_lost 0" in text


def test_figures_are_pictures_of_a_readable_size(page: str) -> None:
    images = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert len(images) == 2 * 3 + 2 + 1  # maps of DSF and uncertainty and planes, paths, beam
    for encoded in images:
        pixels = mpimage.imread(io.BytesIO(base64.b64decode(encoded)))
        assert pixels.shape[1] > 400
        assert pixels.std() > 0.02


def test_dataset_without_truth_beam_and_sides_is_reported_too(tmp_path: Path) -> None:
    bare = lambert_and_mirror((30.0,))
    bare.front_faces = "undeclared"
    bare.distributions[0].time_ns[:] = 0
    path = tmp_path / "report.html"
    write_report(bare, path)
    outline = Outline(path.read_text(encoding="utf-8"))
    assert "--front" in outline.text
    assert "path" not in outline.ids
    assert "reference-beam" not in outline.ids
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_simulated_points_are_not_called_measured() -> None:
    made = lambert_and_mirror((30.0,))
    for d in made.distributions:
        with_evaluation(d)
        d.flags |= np.uint16(PointFlag.SIMULATED)
    made.beam = distribution((0, 0), spiral_about(0, 0, 3, 0.2), lambda u: np.where(u[:, 2] > 0.9997, 1.0, 1e-4))
    made.beam.flags |= np.uint16(PointFlag.SIMULATED)
    made_page = render(made)
    text = Outline(made_page).text
    assert "Simulated at" in text
    assert "simulated without the sample" in text
    assert "columns simulated" in text
    assert "alignment" not in text
    assert "measured" not in made_page.partition('id="klems-matrices"')[0].lower()


def test_nist_report_has_a_row_per_wavelength() -> None:
    dataset = nist_csv.read(NIST)
    dataset.distributions = [d for d in dataset.distributions if d.incident_theta_deg < 1]
    dataset = reduce_dataset(dataset)
    text = Outline(render(dataset)).text
    for d, zero_forty_five in zip(dataset.distributions, ("0.984", "0.998", "0.997", "0.992"), strict=True):
        rho, share = d.integrals["rho_measured"], 100 * d.integrals["rho_measured_share"]
        row = rf"{d.wavelength_nm:g} nm\s+{zero_forty_five}\s+{rho:.4f}\s+81\.9\u00b0\s+{share:.1f} %"
        assert re.search(row, text), row
        assert 0.9 < rho < 1.0


def test_three_hundred_thousand_points_are_drawn_small(tmp_path: Path) -> None:
    units = np.concatenate([sphere_points(2000), spiral_about(30, 180, 8, 0.1)])
    part = distribution((30.0, 0.0), units, lambda u: np.abs(u[:, 2]) / np.pi)
    for name in (
        "theta_deg",
        "phi_deg",
        "dsf_per_sr",
        "variance_per_sr2",
        "count",
        "flags",
        "solid_angle_sr",
        "time_ns",
    ):
        setattr(part, name, np.tile(getattr(part, name), 300_000 // len(units) + 1))
    jitter = np.random.default_rng(5).uniform(0, 0.5, len(part.theta_deg))
    part.phi_deg = part.phi_deg + jitter
    path = tmp_path / "report.html"
    write_report(Dataset([part], front_faces="interior"), path)
    assert len(part.theta_deg) >= 300_000
    assert path.stat().st_size < 2_000_000


def test_a_raw_signal_is_drawn_in_its_own_unit_and_nothing_else(dataset: Dataset) -> None:
    d = dataset.distributions[0]
    raw = replace(d, p_i=np.nan, signal_unit="A", dsf_per_sr=np.full(len(d.theta_deg), np.nan), integrals={})
    page = render(Dataset([raw], provenance={}))
    assert "Polar maps of the signal" in page
    assert "Polar maps of the DSF" not in page
    assert "Scatter plane" not in page
    assert "<canvas" not in page
