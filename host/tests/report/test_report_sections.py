"""test_report_sections.py: what was done to the data, as the dataset records it; what else it adds up to."""

import re

import numpy as np
import pytest
from page_outline import Outline
from synthetic_bsdf import lambert_and_mirror

from gonio.dataset.bsdf import Dataset
from gonio.report import result_tables, sections


@pytest.fixture
def dataset() -> Dataset:
    return lambert_and_mirror((30.0,), coarse=1500)


def rows_of(page: str) -> list[list[str]]:
    return [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr[^>]*>(.*?)</tr>", page)][1:]


def test_corrections_say_whether_they_were_applied_and_with_what(dataset: Dataset) -> None:
    dataset.provenance["corrections"] = [
        {"name": "dark", "applied": True, "what": "closed shutter", "parameters": {"counts": [351.5, 12.0], "u": 0.1}},
        {"name": "stray_light", "applied": False, "what": "a share", "parameters": {}},
        "merged by weight",
    ]
    first, second, third = rows_of(sections.corrections(dataset))
    assert first == ["dark", "applied", "closed shutter", "counts = 351.5, 12.0; u = 0.1"]
    assert second[:2] == ["stray light", "switched off"]
    assert third[2] == "merged by weight"
    dataset.provenance["corrections"] = ["lamp <1>"]
    assert "<li>lamp &lt;1&gt;</li>" in sections.corrections(dataset)
    dataset.provenance = {}
    assert sections.corrections(dataset) == ""


def test_a_merge_shows_sources_overlaps_and_seams(dataset: Dataset) -> None:
    assert sections.merged(dataset) == ""
    overlap = {"one": "a.h5", "other": "b.h5", "points": 120, "ratio": 1.0123456, "ratio_u": 0.004, "steep": 0}
    dataset.provenance["merge"] = {
        "distributions": [
            {"where": "visible (30, 0)", "passes": ["a.h5", "b.h5"], "dropped": [], "overlaps": [overlap], "seams": []}
        ],
        "sources": [
            {"name": "a.h5", "mount": "1", "raw_sha256": ["ab", "cd"], "provenance": {"counters": {"samples": 7}}},
            {"name": "b.h5", "mount": "2", "raw_sha256": ["ef"], "provenance": {}},
        ],
    }
    page = sections.merged(dataset)
    outline = Outline(page)
    assert not outline.open
    rows = rows_of(page)
    assert ["a.h5", "b.h5", "120", "1.012", "0.004", "0"] in rows
    assert ["a.h5", "1", "ab, cd"] in rows
    assert "Visible (30, 0): overlaps" in outline.text
    assert "Provenance of a.h5" in outline.text
    assert "counters.samples" in outline.text
    assert "Provenance of b.h5" not in outline.text
    assert "merge" not in Outline(sections.provenance(dataset)).text


def test_parts_and_coverage_are_the_datasets_numbers(dataset: Dataset) -> None:
    d = dataset.distributions[0]
    d.integrals = {
        "rho_measured": 0.7,
        "rho_voronoi": 0.707,
        "rho_quadrature": 0.002,
        "measured_share_front": 0.99,
        "measured_cosine_share_front": 0.98,
        "masked_sr_front": 0.0123,
        "uncovered_sr_front": 0.25,
        "tau_direct": 0.1,
        "tau_direct_u": 0.0005,
        "tau_direct_half_angle_deg": 1.5,
        "cone mirror 7": 0.2,
        "cone mirror 7_u": 0.001,
        "cone mirror 7_measured_share": 0.97,
    }
    (row,) = rows_of(result_tables.coverage(dataset))
    assert row[1:] == ["front", "99.00 %", "98.00 %", "0.0123", "0.25", "0.002", "-0.9901 %"]
    direct, cone = rows_of(result_tables.parts(dataset))
    assert direct[1:5] == ["\u03c4 direct (regular)", "0.1", "0.0005", "0.50 %"]
    assert "\u00b11.5\u00b0" in direct[5]
    assert cone[1:] == ["cone \u00b17\u00b0 about mirror", "0.2", "0.001", "0.50 %", "97.0 % of the cone covered"]
    d.integrals = {"rho_measured": np.nan}
    assert result_tables.parts(dataset) == ""
    assert result_tables.coverage(dataset) == ""
