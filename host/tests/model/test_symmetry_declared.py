"""test_symmetry_declared.py: images of measured directions, and declarations that the data contradict."""

import numpy as np
import pytest
from numpy.typing import NDArray
from sampled_nodes import MIRROR, dataset, gaussian, spread, towards

from gonio.model.fitted import fit_bsdf
from gonio.model.nodes.points import points_of
from gonio.model.nodes.symmetry import HALF_TURN, LEFT_RIGHT, UP_DOWN, compared_images, declared, images_of
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]


def lopsided(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
    """Left-right symmetric, not up-down: the lobe is lifted by 12 degrees."""
    x, y, z = incident * MIRROR
    lifted = np.array([x, y * np.cos(0.2) + z * np.sin(0.2), z * np.cos(0.2) - y * np.sin(0.2)])
    return 0.2 / np.pi * np.abs(outgoing[:, 2]) + gaussian(outgoing, lifted, 3.0, 6.0)


def test_undeclared_symmetry_is_refused_in_one_line() -> None:
    with pytest.raises(UsageError, match="--symmetry") as refused:
        fit_bsdf(dataset(lopsided, [(30.0, 0.0)], symmetry="undeclared", number=200))
    assert "\n" not in str(refused.value)
    assert declared("up", "undeclared") == "up"
    assert declared(None, "bilateral") == "bilateral"


def test_which_directions_an_image_makes_known() -> None:
    points = points_of(dataset(lopsided, [(0.0, 0.0), (40.0, 30.0), (40.0, 150.0)], number=200), "visible")
    own = next(iter(points.values()))
    incident = np.array([p.incident for p in own])
    source, signs, known = images_of("quadrilateral", own).expand(incident)
    assert len(known) == 5  # the normal once; 30 and 150 are images of each other
    assert list(source[:3]) == [0, 1, 2]
    assert np.all(signs[:3] == 1.0)
    assert {tuple(s) for s in signs[3:]} <= {(1.0, -1.0), (-1.0, -1.0)}
    assert len(images_of("none", own).expand(incident)[0]) == 3
    np.testing.assert_allclose(images_of("up", own).expand(incident)[2][3], towards(40.0, 210.0), atol=1e-12)


@pytest.mark.parametrize(
    ("azimuths", "mirror"),
    [((0.0, 60.0, 120.0, 180.0), UP_DOWN), ((270.0, 330.0, 30.0, 90.0), LEFT_RIGHT), ((0.0, 60.0), LEFT_RIGHT)],
)
def test_the_mirror_of_a_bilateral_sample(azimuths: tuple[float, ...], mirror: tuple[int, int]) -> None:
    points = points_of(dataset(lopsided, [(40.0, phi) for phi in azimuths], number=200), "visible")
    assert images_of("bilateral", next(iter(points.values()))).signs[1] == mirror


def test_the_data_decide_where_either_mirror_would_do() -> None:
    # Light in one plane and from the normal: no azimuth tells the mirror, the distributions do.
    def turned(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        return lopsided(turn @ incident, outgoing @ turn.T)

    normal = [(0.0, 0.0), (30.0, 0.0)]
    straight = points_of(dataset(lopsided, normal, noise=0.02), "visible")
    assert images_of("bilateral", next(iter(straight.values()))).signs[1] == LEFT_RIGHT
    other = points_of(dataset(turned, normal, noise=0.02), "visible")
    assert images_of("bilateral", next(iter(other.values()))).signs[1] == UP_DOWN


def test_a_wrong_declaration_is_contradicted_and_a_right_one_not() -> None:
    measured = dataset(lopsided, [(30.0, 90.0), (30.0, 270.0), (40.0, 20.0), (40.0, 160.0)], noise=0.02)
    own = next(iter(points_of(measured, "visible").values()))
    left_right = compared_images(own, images_of("quadrilateral", own))
    by_name = {found["image"]: found for found in left_right}
    assert not by_name["mirrored left-right"]["contradicted"]
    assert by_name["mirrored left-right"]["rms_u"] < 1.5
    assert by_name["mirrored up-down"]["contradicted"]
    assert by_name["mirrored up-down"]["share"] > 0.1
    turned = compared_images(own, images_of("up", own))
    assert [found["contradicted"] for found in turned] == [True]
    assert images_of("up", own).signs == ((1, 1), HALF_TURN)


def test_isotropic_is_tested_where_a_theta_was_measured_twice() -> None:
    def round_one(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        return 0.2 / np.pi * outgoing[:, 2] + gaussian(outgoing, incident * MIRROR, 3.0, 6.0)

    twice = [(30.0, 0.0), (30.0, 50.0)]
    for function, wrong in ((round_one, False), (lopsided, True)):
        own = next(iter(points_of(dataset(function, twice, noise=0.02), "visible").values()))
        found = compared_images(own, images_of("isotropic", own))
        assert [f["contradicted"] for f in found] == [wrong]
    assert compared_images(own[:1], images_of("isotropic", own[:1])) == []


@pytest.mark.parametrize("method", ["lobes-fixed", "lobes-opposite", "lobes-same-rest"])
def test_a_mirrored_direction_answers_as_its_original(method: str) -> None:
    measured = dataset(lopsided, [(20.0, 60.0), (50.0, 60.0), (50.0, 20.0)], symmetry="bilateral", number=2000)
    model = fit_bsdf(measured, method=method)
    fitted, flip = model.channels["visible"], np.array([-1.0, 1.0, 1.0])
    unit = spread(400)
    for incident in (towards(50.0, 20.0), towards(40.0, 50.0)):
        one = fitted.dsf_per_sr(incident[None], unit)
        other = fitted.dsf_per_sr((incident * flip)[None], unit * flip)
        np.testing.assert_allclose(other, one, rtol=1e-5, atol=1e-6 * one.max())
