"""test_klems.py: bases and the mapping of directions, against CONVENTIONS.md and WINDOW's engine."""

import json
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gonio.formats.window.klems import (
    BASES,
    KlemsBasis,
    basis_from_rings,
    basis_named,
    direction_of_patch_deg,
    incident_place,
    process_of,
    to_radiance_deg,
)
from gonio.geometry.directions import angles_deg_from_unit, unit_from_angles_deg
from gonio.units.errors import UsageError


@pytest.mark.parametrize(("name", "size"), [("klems-full", 145), ("klems-half", 77), ("klems-quarter", 41)])
def test_sizes_and_projected_solid_angles(name: str, size: int) -> None:
    basis = basis_named(name)
    assert basis.size == size
    assert basis.projected_solid_angle_sr.sum() == pytest.approx(np.pi, rel=1e-12)


@pytest.mark.judge
def test_projected_solid_angles_are_those_of_windows_engine() -> None:
    script = (
        "import json, pywincalc as p\n"
        "B, D = p.BSDFBasisType, p.BSDFDirection.Outgoing\n"
        "print(json.dumps({n: list(p.BSDFHemisphere.create(b).get_directions(D).lambda_vector())"
        " for n, b in (('klems-full', B.FULL), ('klems-half', B.HALF), ('klems-quarter', B.QUARTER))}))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    for name, values in json.loads(done.stdout).items():
        np.testing.assert_allclose(BASES[name].projected_solid_angle_sr, values, rtol=1e-12)


@pytest.mark.parametrize("basis", BASES.values(), ids=BASES)
def test_every_patch_holds_its_own_centre(basis: KlemsBasis) -> None:
    polar, azimuth = basis.centres_deg.T
    np.testing.assert_array_equal(basis.patch_of(polar, azimuth), np.arange(basis.size))


@given(polar=st.floats(0, 90), azimuth=st.floats(-720, 720, allow_nan=False), name=st.sampled_from(sorted(BASES)))
def test_patch_lies_around_its_direction(polar: float, azimuth: float, name: str) -> None:
    basis = BASES[name]
    patch = int(basis.patch_of(polar, azimuth))
    ring = basis.rings[int(np.searchsorted(basis.ring_start, patch, side="right")) - 1]
    assert ring.lower_deg <= polar <= ring.upper_deg
    off = (azimuth - basis.centres_deg[patch, 1] + 180) % 360 - 180
    assert abs(off) <= 180 / ring.patches + 1e-9


@pytest.mark.parametrize(
    ("process", "side", "incident", "outgoing"),
    [
        ("Transmission", "Front", (140, 180), (40, 90)),
        ("Transmission", "Back", (40, 180), (140, 90)),
        ("Reflection", "Front", (140, 180), (140, 90)),
        ("Reflection", "Back", (40, 180), (40, 90)),
    ],
)
def test_the_four_tried_mappings(process, side, incident, outgoing) -> None:  # type: ignore[no-untyped-def]
    basis = BASES["klems-full"]
    column, row = int(basis.patch_of(40, 0)), int(basis.patch_of(40, 90))
    # A front that faces the interior has Radiance's frame.
    found = direction_of_patch_deg(basis, process, side, row=row, column=column, front_faces="interior")
    assert found[0] == pytest.approx(incident)
    assert found[1] == pytest.approx(outgoing)
    place = incident_place(*incident)
    assert place == (side, 40, 0)
    assert process_of(place[0], outgoing[0] < 90) == process


@given(theta=st.floats(0.01, 179.99), phi=st.floats(0, 359.99))
def test_exterior_front_is_turned_about_y(theta: float, phi: float) -> None:
    turned = to_radiance_deg(theta, phi, "exterior")
    vector = unit_from_angles_deg(theta, phi) * np.array([-1.0, 1.0, -1.0])
    np.testing.assert_allclose(unit_from_angles_deg(*turned), vector, atol=1e-12)
    back = to_radiance_deg(*turned, "exterior")
    np.testing.assert_allclose(unit_from_angles_deg(*back), unit_from_angles_deg(theta, phi), atol=1e-12)
    assert angles_deg_from_unit(vector)[0] == pytest.approx(float(turned[0]), abs=1e-6)


@pytest.mark.parametrize("incident", [(0.0, 0.0), (20.0, 45.0), (140.0, 195.0)])
def test_mirror_and_straight_through_lie_on_the_diagonal(incident: tuple[float, float]) -> None:
    basis = BASES["klems-full"]
    theta, phi = incident
    _, polar, azimuth = incident_place(theta, phi)
    column = int(basis.patch_of(polar, azimuth))
    for out_theta in (theta, 180 - theta):  # mirror, straight through: azimuth + 180
        out_polar = out_theta if out_theta < 90 else 180 - out_theta
        assert int(basis.patch_of(out_polar, (phi + 180) % 360)) == column


def test_undeclared_side_and_unknown_basis_are_refused() -> None:
    with pytest.raises(UsageError, match="--front"):
        to_radiance_deg(10, 0, "undeclared")
    with pytest.raises(UsageError, match="klems-full"):
        basis_named("klems-double")


@pytest.mark.parametrize("bounds", [(0, 10, 80), (0, 50, 40, 90), (5, 90), (0, 90)])
def test_rings_that_do_not_cover_the_hemisphere_are_refused(bounds: tuple[float, ...]) -> None:
    with pytest.raises(UsageError):
        basis_from_rings("odd", [0.0] * 2, bounds, [1, 8])
