"""test_tables.py: names, relative differences and what a table says where there is nothing."""

import pytest
from synthetic_bsdf import lambert_and_mirror

from gonio.report import tables
from gonio.report.comparison import relative, short_name


@pytest.mark.parametrize(
    ("name", "short"),
    [("mirror 30/0", "mirror"), ("through 60/180", "through"), ("retro", "retro"), ("40/90 30/0", "40/90 30/0")],
)
def test_short_name(name: str, short: str) -> None:
    assert short_name(name) == short


def test_relative_difference_of_what_is_missing_or_zero() -> None:
    assert relative(1.02, 1.0) == pytest.approx(0.02)
    assert relative(0.1, 0.0) is None
    assert relative(None, 1.0) is None
    assert relative(1.0, None) is None
    assert relative(float("nan"), 1.0) is None


def test_peak_at_the_pole_has_no_azimuth() -> None:
    dataset = lambert_and_mirror((0.0,))
    known: list[dict[str, float]] = [{}]
    for theta_deg, azimuth in ((0.001, "\u2013"), (179.995, "\u2013"), (0.5, "64.200")):
        dataset.distributions[0].integrals = {"peak p theta_deg": theta_deg, "peak p phi_deg": 64.2}
        assert f"<td>{azimuth}</td>" in tables.peaks(dataset, known)


def test_without_values_there_is_no_table() -> None:
    dataset = lambert_and_mirror((0.0,))
    assert tables.integrals(dataset, [{}]) == ""
    assert tables.peaks(dataset, [{}]) == ""
    assert tables.wavelengths(dataset) == ""
