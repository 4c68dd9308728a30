"""test_validity.py: the validity range of a model, written as one line and read back."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lopsided_sample import Lopsided

from gonio.dataset.bsdf import Side
from gonio.dataset.scattering import Bsdf, FloatArray, Origin
from gonio.formats import validity
from gonio.formats.validity import Range, Validity
from gonio.geometry.directions import unit_from_angles_deg


class Partly(Lopsided):
    """Reflection at the front, measured for theta_i 5-70, phi_i 300-60 (through 0), theta_s up to 80 degrees."""

    def covers(self, *, incident_front: bool, outgoing_front: bool) -> bool:
        return incident_front and outgoing_front

    def origin(self, incident, outgoing, which=None):  # type: ignore[no-untyped-def]
        own = incident[np.zeros(len(outgoing), dtype=int) if which is None else which]
        theta = np.degrees(np.arccos(own[:, 2]))
        phi = np.degrees(np.arctan2(own[:, 1], own[:, 0]))
        inside = (theta > 4.999) & (theta < 70.001) & (np.abs(phi) < 60.001)
        inside &= outgoing[:, 2] > np.cos(np.radians(80.001))
        found = np.where(inside, Origin.INTERPOLATED, Origin.EXTRAPOLATED)
        return np.where((own[:, 2] >= 0) & (outgoing[:, 2] >= 0), found, Origin.ABSENT).astype(np.uint8)


def test_ranges_are_found_by_asking() -> None:
    bsdf = Bsdf({"visible": Partly(), "solar": Partly(0.5)}, front_faces="exterior", symmetry="bilateral")
    found = validity.validity_of(bsdf)
    assert found.ranges == (Range(("visible", "solar"), True, True, (5.0, 70.0), (300.0, 420.0), (0.0, 80.0)),)
    assert "front to front: measured for theta_i 5-70, phi_i 300-420 and theta_s 0-80" in found.sentences()[0]
    turned_away = Bsdf({"visible": Partly()}, symmetry="isotropic")  # one azimuth speaks for all
    assert validity.validity_of(turned_away).ranges[0].phi_i_deg == (0.0, 360.0)
    everywhere = validity.validity_of(Bsdf({"a": Lopsided()}, symmetry="none"))
    assert [r.theta_i_deg + r.phi_i_deg + r.theta_s_deg for r in everywhere.ranges] == [(0, 90, 0, 360, 0, 90)] * 4


def asked(found: Validity, incident: tuple[float, float], outgoing: tuple[float, float]) -> Origin:
    return Origin(found.origin("visible", at(incident), at(outgoing))[0])


def at(direction: tuple[float, float]) -> FloatArray:
    return unit_from_angles_deg([direction[0]], [direction[1]])


def test_the_line_answers_as_the_model_did() -> None:
    model = Partly()
    text = f"Some words. {validity.line(Bsdf({'visible': model}, front_faces='interior', symmetry='none'))} More."
    found = validity.parse(text)
    assert found is not None
    assert validity.front_faces_of(text) == "interior"
    generator = np.random.default_rng(7)
    incident, outgoing = (v / np.linalg.norm(v, axis=1)[:, None] for v in generator.normal(size=(2, 4000, 3)))
    which = np.arange(4000)
    same = found.origin("visible", incident, outgoing, which) == model.origin(incident, outgoing, which)
    assert np.mean(same) > 0.999  # only on the rim
    # A band named otherwise than its channel has the file's ranges.
    assert np.array_equal(
        found.origin("other", incident, outgoing, which), found.origin("visible", incident, outgoing, which)
    )
    two = Validity(
        "interior", "none", (*found.ranges, replace(found.ranges[0], channels=("solar",), theta_i_deg=(0, 1)))
    )
    assert not np.array_equal(
        two.origin("solar", incident, outgoing, which), two.origin("visible", incident, outgoing, which)
    )
    turned = found.seen_with("exterior")
    about_y = np.array([-1.0, 1.0, -1.0])
    assert np.array_equal(
        turned.origin("visible", incident * about_y, outgoing * about_y, which),
        found.origin("visible", incident, outgoing, which),
    )
    assert turned.seen_with("interior").ranges == found.ranges


@pytest.mark.parametrize("declared", ["exterior", "undeclared"])
def test_the_sentence_tells_what_a_file_was_written_with(declared: Side) -> None:
    """--front went before what the sample declares; the ranges are in the sample's frame either way."""
    made = validity.validity_of(Bsdf({"visible": Partly()}, front_faces=declared, symmetry="none"))
    text = f"{validity.FRONT_SENTENCE}back. {made.line()}"
    found = validity.parse(text)
    assert found is not None
    assert validity.front_faces_of(text) == found.front_faces == "interior"
    assert found.seen_with("interior").ranges == made.ranges
    assert validity.front_faces_of(made.line()) == (None if declared == "undeclared" else declared)


def test_normal_incidence_has_no_azimuth() -> None:
    found = Validity("exterior", "none", (Range(("visible",), True, True, (0.0, 50.0), (30.0, 60.0), (0.0, 90.0)),))
    assert asked(found, (0.0, 200.0), (10.0, 10.0)) == Origin.INTERPOLATED
    assert asked(found, (10.0, 200.0), (10.0, 10.0)) == Origin.EXTRAPOLATED
    assert asked(found, (10.0, 45.0), (90.0, 10.0)) == Origin.INTERPOLATED
    assert asked(found, (10.0, 45.0), (91.0, 10.0)) == Origin.ABSENT


@pytest.mark.parametrize(
    "change",
    [
        {"front_faces": "north"},
        {"symmetry": 3},
        {"ranges": None},
        {"ranges": [{"channels": "visible"}]},
        {
            "ranges": [
                {"channels": ["v"], "from": "left", "to": "back", "theta_i": [0, 9], "phi_i": [0, 9], "theta_s": [0, 9]}
            ]
        },
        {
            "ranges": [
                {
                    "channels": ["v"],
                    "from": "front",
                    "to": "back",
                    "theta_i": [9, 0],
                    "phi_i": [0, 9],
                    "theta_s": [0, 9],
                }
            ]
        },
        {
            "ranges": [
                {"channels": ["v"], "from": "front", "to": "back", "theta_i": [0, 99], "phi_i": [0, 9], "theta_s": [0]}
            ]
        },
    ],
)
def test_a_damaged_line_is_no_line(change: dict[str, object]) -> None:
    good = {"front_faces": "exterior", "symmetry": "none", "ranges": []}
    assert validity.parse(f"{validity.MARK} {json.dumps(good)}") == Validity("exterior", "none", ())
    assert validity.parse(f"{validity.MARK} {json.dumps(good | change)}") is None


@given(st.text(max_size=200))
def test_any_text_is_read(text: str) -> None:
    assert validity.parse(text) is None
    assert validity.parse(validity.MARK + text) is None
    validity.front_faces_of(validity.FRONT_SENTENCE + text)
