"""test_interpolation_between.py: models of known samples between, at and beyond the measured incident directions."""

import numpy as np
import pytest
from numpy.typing import NDArray
from sampled_nodes import MIRROR, Moving, dataset, gaussian, spread, towards

from benchmarks.models.samples import RetroCoating
from gonio.dataset.bsdf import Dataset
from gonio.dataset.scattering import Bsdf, Origin, Scattering
from gonio.model.between.choose import Prediction, chosen
from gonio.model.between.mesh import Line, Triangles
from gonio.model.between.resolve import _faded
from gonio.model.between.scheme import SCHEMES
from gonio.model.fitted import fit_bsdf
from gonio.model.nodes.frames import level_axes, tangents
from gonio.units.errors import UsageError

FloatArray = NDArray[np.float64]
THETAS = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)
COATING = RetroCoating()


def _coating(thetas: tuple[float, ...], noise: float = 0.0) -> Dataset:
    def dsf(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        return COATING.dsf_per_sr(incident[None], outgoing)

    return dataset(dsf, [(t, 0.0) for t in thetas], number=20_000, noise=noise)


@pytest.fixture(scope="module")
def coating() -> Bsdf:
    return fit_bsdf(_coating(THETAS))


def _judged(model: Scattering, theta: float) -> tuple[float, float, float, float]:
    """Peak kept, CV(RMSD), share within 5 % on the scatter plane, relative error of the integral."""
    signed = np.arange(-85.0, 85.05, 0.1)
    plane = np.array([towards(abs(s), 180.0 if s > 0 else 0.0) for s in signed])
    incident, all_ = towards(theta)[None], spread(100_000)
    truth, found = COATING.dsf_per_sr(incident, plane), model.dsf_per_sr(incident, plane)
    off = model.dsf_per_sr(incident, all_).mean() / COATING.dsf_per_sr(incident, all_).mean() - 1.0
    cv = np.sqrt(np.mean((found - truth) ** 2)) / truth.mean()
    return found.max() / truth.max(), cv, float(np.mean(np.abs(found - truth) <= 0.05 * truth)), off


@pytest.mark.parametrize("theta", [0.0, 2.5, 30.0, 45.0, 60.0, 80.0])
def test_the_retro_coating_is_kept(coating: Bsdf, theta: float) -> None:
    peak, cv, within_5, integral = _judged(coating.channels["visible"], theta)
    assert peak == pytest.approx(1.0, abs=0.01)
    assert cv < 0.01
    assert within_5 > 0.99
    assert integral == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("left_out", [20.0, 40.0, 60.0])
def test_a_direction_left_out_is_predicted(left_out: float) -> None:
    kept = tuple(t for t in THETAS if t != left_out)
    peak, cv, within_5, integral = _judged(fit_bsdf(_coating(kept), method="lobes-fixed").channels["visible"], left_out)
    assert (peak > 0.98) & (cv < 0.02) & (within_5 > 0.98)
    assert integral == pytest.approx(0.0, abs=2e-3)


def test_leave_one_out_chooses_and_is_recorded(coating: Bsdf) -> None:
    record = coating.provenance["model"]["channels"]["visible"]["front reflection"]
    assert record["chosen"] == "lobes-fixed"
    assert record["by"] == "leave-one-out"
    by_method = {row["method"]: row for row in record["leave_one_out"]}
    assert len(by_method) == 11
    assert min(by_method.values(), key=lambda row: row["hellinger"])["method"].startswith("lobes-fixed")
    assert len(by_method["blend-fixed"]["left_out"]) == 7  # 70 degrees lies between no others
    assert by_method["blend-same"]["cv_rmsd"] < by_method["blend-fixed"]["cv_rmsd"]
    assert sorted(record["follows"]) == ["opposite", "same"]


def test_the_simpler_of_equals_is_chosen() -> None:
    def row(hellinger: float) -> list[Prediction]:
        return [Prediction(hellinger, 1.0, 0.5, 1.0), Prediction(3.0 * hellinger, 1.0, 0.5, 1.0)]

    first, second, third = SCHEMES[:3]
    assert chosen({first: row(0.3), second: row(0.1), third: row(0.2)}) == second
    assert chosen({first: row(0.100), second: row(0.099), third: row(0.2)}) == first
    worse = [Prediction(0.16, 1.0, 0.4, 1.0)]  # some better by the figure, with fewer points within 10 %
    assert chosen({first: row(0.1), second: worse}) == first
    # The straight beam of `make demo`, one direction left out: a little better by the figure, twice the CV(RMSD).
    plain, cubic = Prediction(1.34e-2, 5.95, 0.973, 1.0), Prediction(1.26e-2, 12.5, 0.973, 1.0)
    assert chosen({first: [plain], second: [cubic]}) == first
    assert chosen({first: [plain], second: [Prediction(2e-3, 12.5, 0.98, 1.0)]}) == first
    assert chosen({first: [plain], second: [Prediction(1.2e-2, 5.0, 0.973, 1.0)]}) == first
    assert chosen({first: [plain], second: [Prediction(1e-2, 5.0, 0.973, 1.0)]}) == second


def test_noise_does_not_break_the_model() -> None:
    model = fit_bsdf(_coating(THETAS, noise=0.02)).channels["visible"]
    peak, cv, within_5, integral = _judged(model, 45.0)
    assert peak == pytest.approx(1.0, abs=0.03)
    assert (cv < 0.1) & (within_5 > 0.9) & (abs(integral) < 5e-3)


def test_a_lobe_off_the_mirror_moves_widens_and_weakens() -> None:
    truth = Moving()
    model = fit_bsdf(dataset(truth, [(t, 0.0) for t in (0.0, 15.0, 30.0, 45.0, 60.0)], number=8000))
    unit = spread(20_000)
    for theta, phi in ((22.0, 0.0), (38.0, 123.0), (52.0, 300.0)):
        incident = towards(theta, phi)
        found, right = model.channels["visible"].dsf_per_sr(incident[None], unit), truth(incident, unit)
        assert np.sqrt(np.mean((found - right) ** 2)) < 0.1 * right.mean()
        assert found.mean() == pytest.approx(right.mean(), rel=0.01)
        assert unit[np.argmax(found)] @ unit[np.argmax(right)] > np.cos(np.radians(1.5))


def test_tails_follow_and_diffuse_light_rests() -> None:
    # A retro peak with a tail that no Gaussian has, over diffuse light that does not move.
    def tailed(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        angle = np.degrees(np.linalg.norm(tangents(level_axes(incident), outgoing), axis=1))
        return 0.5 / np.pi * outgoing[:, 2] + 2.0 / (1.0 + (angle / 6.0) ** 2) ** 2

    measured = dataset(tailed, [(t, 0.0) for t in (0.0, 15.0, 30.0, 45.0, 60.0)], number=4000)
    unit, incident, misplaced = spread(8000), towards(37.0, 60.0), {}
    for method in ("lobes-fixed", "lobes-same", "lobes-same-rest"):
        found = fit_bsdf(measured, method=method).channels["visible"].dsf_per_sr(incident[None], unit)
        right = tailed(incident, unit)
        misplaced[method] = np.sum((np.sqrt(found) - np.sqrt(right)) ** 2) / right.sum()
    assert misplaced["lobes-same-rest"] < 0.7 * misplaced["lobes-fixed"]
    assert misplaced["lobes-same-rest"] < 0.7 * misplaced["lobes-same"]


def test_an_anisotropic_sample_between_azimuths() -> None:
    def brushed(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        # Long along the sample's y wherever the light comes from; stronger along x.
        u = tangents(level_axes(incident * MIRROR), outgoing) / np.radians([4.0, 12.0])
        peak = 4.0 + 2.0 * incident[0] ** 2
        return 0.1 / np.pi * outgoing[:, 2] + peak * np.exp(-0.5 * np.sum(u**2, axis=1))

    directions = [(0.0, 0.0), *((t, p) for t in (25.0, 50.0) for p in (0.0, 30.0, 60.0, 90.0))]
    model = fit_bsdf(
        dataset(brushed, directions, number=4000, symmetry="quadrilateral"), method="lobes-fixed"
    ).channels["visible"]
    unit = spread(10_000)
    for theta, phi in ((37.0, 15.0), (40.0, 200.0), (12.0, 100.0)):
        incident = towards(theta, phi)
        found, right = model.dsf_per_sr(incident[None], unit), brushed(incident, unit)
        misplaced = np.sum((np.sqrt(found) - np.sqrt(right)) ** 2) / right.sum()
        still = brushed(towards(theta - 12.0, phi), unit)  # what a lobe that does not follow would be worth
        assert misplaced < 0.1 * np.sum((np.sqrt(still) - np.sqrt(right)) ** 2) / right.sum()
        assert found.mean() == pytest.approx(right.mean(), rel=0.03)


def test_a_beam_that_its_neighbours_lack_is_gone_before_them() -> None:
    # A louver: straight through at one direction only, cut off long before the others; they show 0.05/sr there.
    def louver(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        strength = 80.0 if incident[2] > np.cos(np.radians(31.0)) else 0.0
        return 0.05 + gaussian(outgoing, incident * MIRROR, strength, 1.5)

    directions = [(30.0, 90.0), (50.0, 90.0), (40.0, 70.0), (40.0, 110.0)]
    model = fit_bsdf(dataset(louver, directions, number=20_000, symmetry="none")).channels["visible"]

    def towards_beam(theta: float) -> float:
        incident = towards(theta, 90.0)
        return float(model.dsf_per_sr(incident[None], (incident * MIRROR)[None])[0])

    found = [towards_beam(theta) for theta in (30.0, 32.0, 35.0, 40.0, 45.0, 50.0)]
    assert found[0] == pytest.approx(80.05, rel=0.01)
    assert np.all(np.diff(found) < 0.0)
    assert found[3] == pytest.approx(np.sqrt(80.0 * 0.08), rel=0.2)  # no less than 1e-3 of the peak counts as seen
    assert found[5] == pytest.approx(0.05, rel=0.05)


def test_a_peak_with_edges_leaves_no_ring_in_the_ground_where_it_was_measured() -> None:
    # A beam straight through, a top hat: no Gaussian, whose skirts must not be taken off the ground at rest.
    def beam(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        off = np.degrees(np.arccos(np.clip(outgoing @ (incident * MIRROR), -1.0, 1.0)))
        return 0.03 + 400.0 * np.clip((1.3 - off) / 0.2, 0.0, 1.0)

    measured = dataset(beam, [(t, 0.0) for t in (0.0, 30.0, 60.0)], number=100_000)
    model = fit_bsdf(measured, method="lobes-fixed").channels["visible"]
    around = np.array([towards(30.0 + off, 180.0) for off in np.linspace(-6.0, 6.0, 49)])
    np.testing.assert_allclose(model.dsf_per_sr(towards(45.0)[None], around), 0.03, rtol=0.05)


def test_a_lobe_fades_in_proportion_where_as_much_may_be_hidden() -> None:
    share = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(_faded(share, np.full(5, 2.0)), share, atol=1e-5)
    np.testing.assert_allclose(_faded(share, np.full(5, np.log(1e-2))), (100.0**share - 1.0) / 99.0)


def test_light_from_behind_and_through_the_sample() -> None:
    def sheet(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        through = gaussian(outgoing, -incident, 4.0, 5.0)
        return np.where(outgoing[:, 2] * incident[2] < 0.0, through, 0.1 * np.abs(outgoing[:, 2]))

    front = dataset(sheet, [(t, 0.0) for t in (10.0, 30.0, 50.0)], number=3000)
    back = dataset(lambda i, o: sheet(i, -o), [(180.0 - t, 0.0) for t in (10.0, 30.0, 50.0)], number=3000)
    # Points of `back` were sampled below; seen from there its transmitted light is above.
    for part in back.distributions:
        part.theta_deg = 180.0 - part.theta_deg
        part.phi_deg = (part.phi_deg + 180.0) % 360.0
    model = fit_bsdf(Dataset([*front.distributions, *back.distributions], symmetry="isotropic")).channels["visible"]
    assert model.covers(incident_front=True, outgoing_front=True)
    assert model.covers(incident_front=False, outgoing_front=True)
    assert not model.covers(incident_front=True, outgoing_front=False)
    # Two sources at once, on either side, and outgoing directions on either side.
    incident = np.array([towards(30.0, 70.0), towards(140.0, 20.0)])
    outgoing = np.array([towards(40.0, 10.0), towards(150.0, 10.0), towards(40.0, 200.0), towards(140.0, 20.0)])
    which = np.array([0, 0, 1, 1])
    found = model.dsf_per_sr(incident, outgoing, which)
    assert found[0] == pytest.approx(0.1 * np.cos(np.radians(40.0)), rel=0.01)
    assert found[2] == pytest.approx(4.0, rel=0.02)
    assert np.isnan(found[[1, 3]]).all()
    assert list(model.origin(incident, outgoing, which)) == [
        Origin.MEASURED,
        Origin.ABSENT,
        Origin.INTERPOLATED,
        Origin.ABSENT,
    ]


def test_what_is_measured_interpolated_and_extrapolated(coating: Bsdf) -> None:
    model = coating.channels["visible"]
    incident = np.array([towards(t, 77.0) for t in (40.0, 45.0, 75.0, 2.0)])
    found = model.origin(incident, np.tile(towards(20.0, 10.0), (4, 1)), np.arange(4))
    assert list(found) == [Origin.MEASURED, Origin.INTERPOLATED, Origin.EXTRAPOLATED, Origin.INTERPOLATED]
    assert "5 to 70 degrees" in coating.validity[0]
    assert "more than 70 degrees" in coating.validity[0]


def test_features_are_where_the_peaks_are(coating: Bsdf) -> None:
    incident = np.array([towards(33.0, 20.0), towards(120.0, 20.0), towards(55.0, 100.0)])
    found = coating.channels["visible"].features(incident)
    narrow = found.sigma_rad < np.radians(2.0)
    assert list(found.incident[narrow]) == [0, 2]
    np.testing.assert_allclose(found.centre[narrow], incident[[0, 2]], atol=1e-3)
    np.testing.assert_allclose(found.sigma_rad[narrow], np.radians(1.2), rtol=0.01)


def test_values_do_not_depend_on_what_else_is_asked(coating: Bsdf) -> None:
    model, unit = coating.channels["visible"], spread(50)
    incident = np.array([towards(t, 10.0 * t) for t in (3.0, 41.0, 88.0)])
    together = model.dsf_per_sr(incident, np.tile(unit, (3, 1)), np.repeat(np.arange(3), 50)).reshape(3, -1)
    for row in range(3):
        np.testing.assert_array_equal(together[row], model.dsf_per_sr(incident[row][None], unit))


def test_the_line_and_its_ends() -> None:
    line = Line(np.array([towards(t) for t in (10.0, 30.0)] + [towards(t, 180.0) for t in (10.0, 30.0)]))
    found = line.locate(np.array([towards(t) for t in (0.0, 15.0, 30.0, 60.0)]))
    assert sorted(found.node[0, :2]) == [0, 2]
    np.testing.assert_allclose(found.weight, [[0.5, 0.5, 0], [0.75, 0.25, 0], [0, 1, 0], [0, 1, 0]], atol=1e-9)
    assert list(found.origin) == [Origin.INTERPOLATED] * 3 + [Origin.EXTRAPOLATED]
    far = Line(np.array([towards(40.0), towards(40.0, 180.0)]))
    assert far.locate(towards(10.0)[None]).origin[0] == Origin.EXTRAPOLATED


@pytest.mark.parametrize(
    "directions",
    [
        [(30.0, 0.0)],
        [(30.0, 0.0), (50.0, 0.0)],
        [(30.0, 0.0), (50.0, 0.0), (30.0, 180.0)],
        [(60.0, p) for p in (0.0, 36.0, 72.0, 108.0, 144.0)],
        [(0.0, 0.0), *((t, p) for t in (30.0, 60.0) for p in range(0, 360, 45))],
    ],
)
def test_weights_of_any_set_of_directions(directions: list[tuple[float, float]]) -> None:
    nodes = np.array([towards(t, p) for t, p in directions])
    mesh, asked = Triangles(nodes), spread(500)
    found = mesh.locate(asked)
    assert np.all(found.weight >= 0.0)
    np.testing.assert_allclose(found.weight.sum(axis=1), 1.0, atol=1e-12)
    own = mesh.locate(nodes)
    assert np.all(own.origin == Origin.INTERPOLATED)
    for row, (node, weight) in enumerate(zip(own.node, own.weight, strict=True)):
        assert weight[node == row].sum() == pytest.approx(1.0, abs=1e-6)
    if len(directions) == 5:  # a ring: between its azimuths on it, not far off it
        ring = mesh.locate(np.array([towards(60.0, 18.0), towards(60.0, 200.0), towards(85.0, 18.0)]))
        assert list(ring.origin) == [Origin.INTERPOLATED, Origin.EXTRAPOLATED, Origin.EXTRAPOLATED]
        np.testing.assert_allclose(sorted(ring.weight[0]), [0.0, 0.5, 0.5], atol=1e-9)


def test_wrong_wishes_are_refused() -> None:
    measured = _coating((20.0, 40.0))
    with pytest.raises(UsageError, match="--method wild"):
        fit_bsdf(measured, method="wild")
    with pytest.raises(UsageError, match="channel solar"):
        fit_bsdf(measured, channels=["solar"])
    for part in measured.distributions:
        part.flags[:] = 1
    with pytest.raises(UsageError, match="nothing to fit"):
        fit_bsdf(measured)
