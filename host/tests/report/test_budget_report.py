"""test_budget_report.py: the budget as printed: numbers of the dataset, largest first, root of squares as stated."""

import json
from pathlib import Path

import numpy as np
import pytest
from synthetic_bsdf import distribution, sphere_points

from gonio.cli import main
from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.nexus import write_dataset
from gonio.dataset.uncertainty import linear_result
from gonio.report import budget
from gonio.report.budget_html import uncertainty


def with_effects() -> Distribution:
    """Lambertian, 0.5 in reflection: P_i to 0.3 %, dark 1e-4 per sr, tilt odd in x, so that its integral vanishes."""
    d = distribution(
        (30.0, 0.0), sphere_points(3000), lambda u: 0.5 / np.pi * np.maximum(u[:, 2], 0.0), masked_below_deg=3
    )
    d.dsf_per_sr = np.where(d.measured & (d.theta_deg > 90), 0.01, d.dsf_per_sr)
    x = np.sin(np.radians(d.theta_deg)) * np.sin(np.radians(d.phi_deg))
    d.effects = {
        "p_i": -0.003 * d.dsf_per_sr,
        "dark": np.where(d.measured, 1e-4, np.nan),
        "tilt_x": np.where(d.measured, 0.01 * x, np.nan),
    }
    front = d.theta_deg <= 90
    for name, side in (("rho", front), ("tau", ~front)):
        result = linear_result(d, np.where(side, d.solid_angle_sr, 0.0)).with_effect("quadrature", 2e-4)
        d.budgets[name] = result.budget
        d.integrals |= {f"{name}_measured": result.value, f"{name}_u": result.u}
    d.budgets["rho_filled"] = {"coverage": 1e-3}
    d.integrals["rho_filled"] = 0.01
    for field in ("integral", "sigma_deg"):
        d.budgets[f"peak mirror 30/0 {field}"] = {"p_i": 0.001}
        d.integrals[f"peak mirror 30/0 {field}"] = 0.2
    return d


@pytest.fixture
def dataset() -> Dataset:
    return Dataset([with_effects()], sample_name="matt", front_faces="exterior")


def test_budgets_are_those_of_the_dataset(dataset: Dataset) -> None:
    d = dataset.distributions[0]
    ((_, found),) = budget.sections(dataset)
    assert list(found)[:2] == ["\u03c1, covered directions", "\u03c4, covered directions"]
    assert not any("filled" in words for words in found)
    assert "peak mirror, integral" in found
    assert "peak mirror, sigma deg" not in found
    rho = found["\u03c1, covered directions"]
    assert rho.u == pytest.approx(d.integrals["rho_u"])
    assert rho.expanded_u == pytest.approx(2 * d.integrals["rho_u"])
    by_effect = {row.effect: row.contribution for row in rho.rows}
    assert by_effect["p_i"] == pytest.approx(0.003 * d.integrals["rho_measured"])
    assert by_effect["dark"] == pytest.approx(1e-4 * 2 * np.pi, rel=0.01)
    assert list(by_effect.values()) == sorted(by_effect.values(), reverse=True)


def test_typical_points_are_the_top_and_the_median_by_solid_angle(dataset: Dataset) -> None:
    """Of a cosine, half of the hemisphere's solid angle lies above cos theta = 1/2."""
    d = dataset.distributions[0]
    points = budget.typical_points(d)
    top, median = points["highest point, reflection"], points["median point, reflection"]
    assert d.theta_deg[top] < 3
    assert d.theta_deg[median] == pytest.approx(60.0, abs=1.0)
    found = budget.point_budgets(d)["median point, reflection"]
    combined = np.sqrt(d.variance_per_sr2[median] + sum(column[median] ** 2 for column in d.effects.values()))
    assert found.u == pytest.approx(combined)
    d.solid_angle_sr[:] = 0.0
    assert budget.typical_points(d) == {}


def test_text_is_a_table_largest_first(dataset: Dataset) -> None:
    lines = budget.as_text(dataset).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("\u03c1, covered"))
    assert f"{dataset.distributions[0].integrals['rho_measured']:.6g}" in lines[start]
    assert "(k = 2)" in lines[start]
    assert lines[start + 1].split()[-1] == "effect"
    assert "incident power: P_i of the reference beam" in lines[start + 2]
    shown = [float(line.split()[0]) for line in lines[start + 2 : lines.index("", start)] if "more" not in line]
    assert shown == sorted(shown, reverse=True)
    assert "more, each below 0.01 %" in "\n".join(lines)  # the tilt, which cancels


def test_page_states_every_column(dataset: Dataset) -> None:
    d = dataset.distributions[0]
    page = uncertainty(dataset)
    assert f"{d.integrals['rho_measured']:.5g}" in page
    percent = 100 * d.integrals["rho_u"] / d.integrals["rho_measured"]
    assert f"<td>{percent:.2g}</td>" in page
    assert f"<td>{2 * percent:.2g}</td>" in page


def test_json_holds_all_and_is_valid(dataset: Dataset) -> None:
    told = json.loads(json.dumps(budget.as_json(dataset), allow_nan=False))
    first = told["sections"][0]["budgets"][0]
    assert first["quantity"] == "rho"
    quantities = [found["quantity"] for found in told["sections"][0]["budgets"]]
    assert {"rho_filled", "peak mirror 30/0 sigma_deg"} < set(quantities)
    squares = sum(row["contribution"] ** 2 for row in first["rows"])
    assert np.sqrt(squares) == pytest.approx(first["u"])
    assert sum(row["variance_share"] for row in first["rows"]) == pytest.approx(1.0)


def test_what_has_no_budget_says_so(dataset: Dataset) -> None:
    d = dataset.distributions[0]
    d.effects, d.budgets = {}, {}
    assert budget.without_budget(dataset) in " ".join(budget.as_text(dataset).split())
    assert "no uncertainty budget" in uncertainty(dataset)
    assert budget.as_json(dataset)["sections"] == []


@pytest.mark.parametrize(
    ("key", "words"), [("cone mirror 7", "cone \u00b17\u00b0 about mirror"), ("odd_name", "odd name")]
)
def test_words_of_integrals(key: str, words: str) -> None:
    assert budget.integral_words(key) == words


def test_command_prints_the_budget(dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, page = tmp_path / "x.h5", tmp_path / "x.html"
    write_dataset(dataset, file)
    assert main.run(["report", str(file)]) == 0
    assert "incident power: P_i" in capsys.readouterr().out
    assert main.run(["report", str(file), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["sample"] == "matt"
    assert printed["sections"]
    assert main.run(["report", str(file), "-o", str(page)]) == 0
    assert capsys.readouterr().out.strip() == str(page)
    assert main.run(["report", str(file), "-o", str(page), "--budget"]) == 0
    out = capsys.readouterr().out
    assert "incident power: P_i" in out
    assert str(page) in out


def test_a_raw_signal_is_called_one_and_fits_a_terminal(dataset: Dataset) -> None:
    for d in dataset.distributions:
        d.effects, d.budgets, d.p_i, d.signal_unit = {}, {}, np.nan, "A"
    text = budget.as_text(dataset)
    assert "raw signal (unit A)" in text
    assert max(map(len, text.splitlines())) <= 100


def test_the_overview_leaves_peaks_to_the_full_tables(dataset: Dataset) -> None:
    overview, _, full = uncertainty(dataset).partition("Each budget in full")
    assert "peak mirror" not in overview
    assert "peak mirror" in full
