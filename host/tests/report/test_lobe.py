"""test_lobe.py: the lobe's mesh: radius by the logarithm, closed where points are, open where they are masked."""

import base64
import json
import re
from html import unescape

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_bsdf import distribution, lobe_per_sr, sphere_points, spiral_about

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.report.lobe import build_mesh, canvas, colour_table
from gonio.report.lobe_script import script


def peak_on_ground(masked_deg: float = 0.0) -> Distribution:
    units = np.concatenate([sphere_points(6000), spiral_about(40.0, 180.0, 6.0, 0.2)])
    return distribution(
        (40.0, 0.0), units, lambda u: 0.1 + lobe_per_sr(u, (40.0, 180.0), 0.2), masked_below_deg=masked_deg
    )


def volume(direction: NDArray[np.float64], facets: NDArray[np.int64]) -> float:
    """Of the body between the facets and the centre."""
    a, b, c = (direction[facets[:, i]] for i in range(3))
    return float(np.abs(np.sum(a * np.cross(b, c), axis=1)).sum() / 6)


def test_radius_is_the_logarithm_between_floor_and_top() -> None:
    d = peak_on_ground()
    mesh = build_mesh(d)
    assert mesh is not None
    assert mesh.top_per_sr == pytest.approx(float(d.dsf_per_sr.max()))
    assert mesh.radius.max() == 1.0
    decades = np.log10(mesh.top_per_sr / mesh.floor_per_sr)
    value = mesh.floor_per_sr * 10 ** (decades * mesh.radius)
    expected = 0.1 + lobe_per_sr(mesh.direction, (40.0, 180.0), 0.2)
    np.testing.assert_allclose(value, expected, rtol=1e-9)


def test_peak_keeps_more_points_than_the_ground() -> None:
    d = peak_on_ground()
    mesh = build_mesh(d)
    assert mesh is not None
    away = angle_between_deg(mesh.direction, unit_from_angles_deg(40.0, 180.0))
    at_peak = np.sum(away < 5) / (1 - np.cos(np.radians(5)))
    on_ground = np.sum(away > 30) / (1 + np.cos(np.radians(30)))
    assert at_peak > 8 * on_ground
    assert len(mesh.radius) < 25_000


def test_facets_close_over_all_but_the_equator() -> None:
    """On a unit sphere of such facets the volume is nearly the ball's; the strip across theta = 90 is left open."""
    mesh = build_mesh(peak_on_ground())
    assert mesh is not None
    assert volume(mesh.direction, mesh.facets) == pytest.approx(4 * np.pi / 3, rel=0.06)
    assert np.all(np.isin((mesh.direction[mesh.facets][:, :, 2] >= 0).sum(axis=1), (0, 3)))


def test_masked_points_leave_a_hole() -> None:
    """A cap of 15 degrees is open."""
    mesh = build_mesh(peak_on_ground(15.0))
    assert mesh is not None
    centres = mesh.direction[mesh.facets].mean(axis=1)
    away = angle_between_deg(centres / np.linalg.norm(centres, axis=1, keepdims=True), unit_from_angles_deg(40.0, 0.0))
    assert away.min() > 14.0
    assert np.sum(away < 22.0) > 10


def test_one_hemisphere_has_no_lid() -> None:
    units = sphere_points(3000)
    mesh = build_mesh(distribution((0, 0), units[units[:, 2] > 0], lambda u: u[:, 2] / np.pi))
    assert mesh is not None
    assert volume(mesh.direction, mesh.facets) == pytest.approx(2 * np.pi / 3, rel=0.06)


def test_too_few_points_have_no_mesh() -> None:
    assert build_mesh(distribution((0, 0), sphere_points(12), lambda u: np.ones(len(u)))) is None


def test_the_page_carries_what_the_mesh_holds() -> None:
    d = peak_on_ground()
    mesh = build_mesh(d)
    assert mesh is not None
    element = canvas(d, mesh, 'a "lobe"')
    packed = dict(re.findall(r'data-(places|directions|facets)="([^"]+)"', element))
    places = np.frombuffer(base64.b64decode(packed["places"]), "<i2").reshape(-1, 3) / 32767
    np.testing.assert_allclose(places, mesh.direction * mesh.radius[:, None], atol=2e-5)
    facets = np.frombuffer(base64.b64decode(packed["facets"]), "<u2").reshape(-1, 3)
    np.testing.assert_array_equal(facets, mesh.facets)
    told = json.loads(unescape(re.search(r'data-told="([^"]+)"', element)[1]))  # type: ignore[index]
    assert 10 ** told["top"] == pytest.approx(mesh.top_per_sr)
    assert told["incident"] == [40.0, 0.0]
    assert "a &quot;lobe&quot;" in element
    assert len(element) < 1_200_000


def test_colours_of_the_script_are_those_of_the_maps() -> None:
    table = colour_table()
    assert len(table) == 256 * 6
    assert f"var COLOURS='{table}'" in script(table)
    assert not re.search(r"https?:|import |fetch\(|XMLHttp", script(table))
