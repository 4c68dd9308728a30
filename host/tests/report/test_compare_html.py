"""test_compare_html.py: a comparison as a page: numbers of the comparison, pictures of A, B and what lies between."""

import copy
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_outline import Outline
from synthetic_bsdf import lambert_and_mirror

from gonio.compare.comparing import compare_datasets
from gonio.compare.result import Comparison, Settings
from gonio.report.compare_figures import difference_end, pictures, relative_percent
from gonio.report.compare_html import render_compare, write_compare


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    """B is 4 % higher than A in front and equal behind."""
    a = lambert_and_mirror((30.0,))
    b = copy.deepcopy(a)
    for d in b.distributions:
        d.dsf_per_sr *= np.where(d.theta_deg <= 90, 1.04, 1.0)
    return compare_datasets(a, b, ("one/a <1>.h5", "two/b.h5"), Settings())


@pytest.fixture(scope="module")
def page(comparison: Comparison) -> str:
    return render_compare(comparison)


def test_page_is_well_formed_and_needs_no_network(page: str) -> None:
    outline = Outline(page)
    assert not outline.open
    assert all(a.startswith("data:image/png;base64,") for a in outline.addresses)
    assert not re.search(r"url\(|@import|https?://|<script", page)
    assert "a &lt;1&gt;.h5" in page
    assert len(page) < 4_000_000


def test_it_shows_maps_differences_planes_and_paths(page: str) -> None:
    captions = re.findall(r'alt="([^"]+)"', page)
    for words in ("Polar maps of A and B", "Difference and local accordance", "Scatter planes", "Detector paths"):
        assert sum(caption.startswith(words) for caption in captions) == 1, words


def test_numbers_are_those_of_the_comparison(page: str, comparison: Comparison) -> None:
    metrics = comparison.pairs[0].metrics["whole"]
    row = next(row for row in re.findall(r"<tr>(.*?)</tr>", page) if "<td class=name>whole</td>" in row)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", row)
    assert cells[2] == f"{metrics.points:,}"
    assert float(cells[3]) == pytest.approx(metrics.global_accordance_percent.value, rel=1e-4)
    assert float(cells[5]) == pytest.approx(metrics.local_accordance_percent.value, rel=1e-4)
    in_u = next(share.value for share in metrics.within_u if share.limit == 2.0)
    assert in_u is not None
    assert cells[8] == f"{100 - in_u:.1f} %"


def test_differences_are_relative_to_a(comparison: Comparison) -> None:
    pair = comparison.pairs[0]
    percent = relative_percent(pair)
    front = pair.theta_deg <= 90
    np.testing.assert_allclose(percent[front & pair.used], 4.0)
    np.testing.assert_allclose(percent[~front & pair.used], 0.0, atol=1e-12)
    assert np.isnan(percent[~pair.used]).all()
    assert difference_end(percent) == (5.0, 0.0)
    assert difference_end(np.concatenate([np.full(99, 1.5), [40.0]])) == (2.0, 0.01)
    assert difference_end(np.array([np.nan])) == (1.0, 0.0)


def test_what_one_of_both_lacks_is_masked(comparison: Comparison) -> None:
    pair = comparison.pairs[0]
    of = pictures(pair)
    assert of.halves["front"].masked.sum() > 20  # the shaded zone about the source
    assert of.scale.top == pytest.approx(1.04 * np.nanmax(pair.a_per_sr))
    without = pair.used & (pair.theta_deg < 90)
    fewer = replace(pair, used=without, b_per_sr=np.where(without, pair.b_per_sr, np.nan))
    assert np.isnan(pictures(fewer).halves["back"].of(fewer.b_per_sr)).all()


def test_nothing_in_common_is_said(comparison: Comparison, tmp_path: Path) -> None:
    pair = comparison.pairs[0]
    none = replace(pair, used=np.zeros(len(pair.used), dtype=np.bool_), metrics={}, integrals=(), profiles=())
    lone = replace(comparison, pairs=(none,), unmatched_b=("visible (60, 0)",), remarks=("mind the <gap>",))
    path = tmp_path / "c.html"
    write_compare(lone, path)
    text = Outline(path.read_text(encoding="utf-8")).text
    assert "no point in common" in text
    assert "Only in B: visible (60, 0)" in text
    assert "mind the <gap>" in text
    assert [p.name for p in tmp_path.iterdir()] == ["c.html"]
