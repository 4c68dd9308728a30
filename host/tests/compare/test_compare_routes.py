"""test_compare_routes.py: how B comes to A's directions: the same points, a model evaluated there, interpolation."""

import json
from dataclasses import replace

import numpy as np
import pytest
from compared_data import INCIDENT, FloatArray, dataset, distribution, lattice, masked, of, smooth_per_sr

from gonio.compare.as_json import as_json
from gonio.compare.comparing import compare_datasets, compare_with_model
from gonio.compare.field import PointField
from gonio.compare.per_direction import PerDirection
from gonio.compare.result import Pair, Settings
from gonio.compare.scatter_plane import plane_angles_deg, plane_directions
from gonio.compare.table import text
from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.geometry.directions import angle_between_deg, unit_from_angles_deg
from gonio.units.errors import UsageError


class Smooth:
    """smooth_per_sr as a model; remembers what it was asked."""

    def __init__(self, factor: float = 1.0) -> None:
        self.factor = factor
        self.asked: list[tuple[float, float]] = []

    def dsf_at(self, incident_theta_deg: float, incident_phi_deg: float, outgoing: FloatArray) -> FloatArray:
        self.asked.append((round(incident_theta_deg, 9), round(incident_phi_deg, 9)))
        return self.factor * smooth_per_sr(outgoing)


def judged(a: Distribution, model: Smooth) -> Pair:
    return compare_with_model(
        dataset(a), lambda _: PerDirection(model.dsf_at), ("a", "b"), Settings(), "scenario"
    ).pairs[0]


def pair_of(a: Distribution, b: Distribution) -> Pair:
    return compare_datasets(dataset(a), dataset(b), ("a", "b"), Settings()).pairs[0]


def test_points_that_both_have_are_paired_by_index() -> None:
    unit = lattice(500)
    noise = np.random.default_rng(1).normal(size=500)
    a, b = distribution(unit, noise), distribution(unit, 2.0 * noise)
    pair = pair_of(a, b)
    assert pair.route == "same points"
    assert np.array_equal(pair.b_per_sr, 2.0 * noise)
    assert pair.interpolation_per_sr is None
    assert pair_of(a, of(smooth_per_sr, lattice(501))).route == "interpolated"
    assert pair_of(a, distribution(unit[::-1], noise[::-1])).route == "interpolated"


def test_every_metric_against_plain_numpy() -> None:
    """On a masked, unevenly weighted list; each formula written out again."""
    rng = np.random.default_rng(2)
    unit = lattice(1500)
    omega = rng.uniform(0.001, 0.02, 1500)
    a = replace(masked(of(smooth_per_sr, unit), unit[:, 0] > 0.9), solid_angle_sr=omega)
    b = replace(masked(a, unit[:, 1] > 0.95), dsf_per_sr=a.dsf_per_sr * rng.uniform(0.7, 1.4, 1500))
    b = masked(b, unit[:, 1] > 0.95)
    pair = compare_datasets(dataset(a), dataset(b), ("a", "b"), Settings(floor_per_sr=0.08)).pairs[0]
    for region, side in (("whole", unit[:, 2] > -2), ("reflection", unit[:, 2] >= 0), ("transmission", unit[:, 2] < 0)):
        here = side & ~(unit[:, 0] > 0.9) & ~(unit[:, 1] > 0.95)
        x, y, w = a.dsf_per_sr[here], b.dsf_per_sr[here], omega[here]
        m = pair.metrics[region]  # type: ignore[index]
        assert m.points == here.sum()
        assert m.left_out == {
            "masked_a": int((side & (unit[:, 0] > 0.9)).sum()),
            "masked_b": int((side & (unit[:, 1] > 0.95) & ~(unit[:, 0] > 0.9)).sum()),
            "outside_b": 0,
        }
        assert m.rmse_per_sr.value == pytest.approx(np.sqrt(((y - x) ** 2).mean()))
        assert m.rmse_per_sr.by_solid_angle == pytest.approx(np.sqrt((w * (y - x) ** 2).sum() / w.sum()))
        assert m.cv.value == pytest.approx(2.0 * np.sqrt(((y - x) ** 2).mean()) / ((w * x).sum() + (w * y).sum()))
        assert m.bias_per_sr.value == pytest.approx((y - x).mean())
        assert m.bias_percent.by_solid_angle == pytest.approx(100.0 * ((w * y).sum() / (w * x).sum() - 1.0))
        assert m.global_accordance_percent.value == pytest.approx(
            100.0 * (1.0 - np.sqrt(((x - y) ** 2).sum() / ((x + y) ** 2).sum()))
        )
        over = x >= 0.08
        assert m.under_floor == (~over).sum()
        for share in m.within_percent:
            inside = np.abs(y - x)[over] <= 0.01 * share.limit * x[over]
            assert share.value == pytest.approx(100.0 * inside.mean())
            assert share.by_solid_angle == pytest.approx(100.0 * (w[over] * inside).sum() / w[over].sum())
        assert m.without_uncertainty == m.points
        assert m.chi_square_per_point is None
    integrals = {i.name: i for i in pair.integrals}
    near = angle_between_deg(unit, unit_from_angles_deg(30.0, 180.0)) <= 7.0
    used = near & pair.used
    assert integrals["cone_mirror"].a == pytest.approx((omega * a.dsf_per_sr)[used].sum())
    assert integrals["cone_mirror"].signed_percent == pytest.approx(
        100.0 * ((omega * b.dsf_per_sr)[used].sum() / (omega * a.dsf_per_sr)[used].sum() - 1.0)
    )


def test_interpolation_against_the_closed_form() -> None:
    """B at 2.4 degrees: its interpolated values miss the function by what it says, to a part of that, and comparing the
    function itself with the same points gives nothing at all."""
    a = of(smooth_per_sr, lattice(6000))
    pair = pair_of(a, of(smooth_per_sr, lattice(7000)))
    inside = pair.used & (np.abs(90.0 - pair.theta_deg) > 3.0)
    assert inside.sum() > 5500
    missed = (pair.b_per_sr - smooth_per_sr(lattice(6000)))[inside]
    assert pair.interpolation_per_sr is not None
    stated = pair.interpolation_per_sr[inside]
    assert np.sqrt(np.mean(missed**2)) == pytest.approx(np.sqrt(np.mean(stated**2)), rel=0.1)
    assert np.sqrt(np.mean((missed - stated) ** 2)) < 0.25 * np.sqrt(np.mean(missed**2))
    assert pair.metrics["whole"].global_accordance_percent.value > 99.7  # type: ignore[operator]
    direct = compare_with_model(
        dataset(a), lambda _: PerDirection(Smooth().dsf_at), ("a", "b"), Settings(), "scenario"
    ).pairs[0]
    assert direct.route == "evaluated"
    assert direct.metrics["whole"].global_accordance_percent.value == pytest.approx(100.0, abs=1e-10)
    interpolated, evaluated = (pair.profiles[0], direct.profiles[0])
    both = interpolated.used & evaluated.used
    assert interpolated.b_per_sr[both] == pytest.approx(evaluated.b_per_sr[both], rel=0.02, abs=0.01)


def test_the_error_of_interpolation_falls_with_the_square_of_the_spacing() -> None:
    coarse, fine = (
        PointField(of(smooth_per_sr, lattice(count))).at(lattice(1999)).interpolation_per_sr for count in (3000, 12000)
    )
    assert coarse is not None
    assert fine is not None
    assert np.nanmedian(np.abs(coarse)) == pytest.approx(4.0 * np.nanmedian(np.abs(fine)), rel=0.15)


@pytest.mark.parametrize("power", [1, 2])
def test_the_error_is_known_at_the_horizon_too(power: int) -> None:
    """Between the last points and theta = 90 a point's mirror image stands in, so a power of the cosine is read too
    high there."""
    unit, wanted = lattice(5000), lattice(3001)

    def white(directions: FloatArray) -> FloatArray:
        return np.abs(directions[:, 2]) ** power

    at = PointField(of(white, unit)).at(wanted)
    assert at.interpolation_per_sr is not None
    edge = np.abs(wanted[:, 2]) < 2e-4  # nearer to the horizon than any point of the source
    missed = at.values.dsf_per_sr[edge] - white(wanted[edge])
    assert edge.any()
    assert np.all(missed > 0.0)
    assert at.interpolation_per_sr[edge] == pytest.approx(missed, rel=0.05)


def test_points_in_one_plane_are_interpolated_along_it() -> None:
    """As in-plane goniometers measure, front and back: neighbours by angle, the error by second differences."""

    def in_plane(signed_deg: FloatArray) -> FloatArray:
        return unit_from_angles_deg(np.abs(signed_deg), np.where(signed_deg < 0.0, 0.0, 180.0))

    angles = np.concatenate((np.arange(-85.0, 86.0, 2.0), np.arange(95.0, 176.0, 2.0)))
    order = np.random.default_rng(3).permutation(len(angles))
    source = PointField(of(smooth_per_sr, in_plane(angles[order])))
    wanted = np.array([-84.3, -10.5, 0.0, 12.2, 29.9, 84.0, 95.7, 150.5, 90.0, 190.0])
    at = source.at(in_plane(wanted))
    truth = smooth_per_sr(in_plane(wanted))
    assert np.isfinite(at.values.dsf_per_sr).tolist() == [True] * 8 + [False, False]
    by_hand = np.interp(wanted[:8], angles, smooth_per_sr(in_plane(angles)))
    assert at.values.dsf_per_sr[:8] == pytest.approx(by_hand, abs=1e-12)
    missed = at.values.dsf_per_sr[:8] - truth[:8]
    assert at.interpolation_per_sr is not None
    assert at.interpolation_per_sr[:8] == pytest.approx(missed, abs=0.15 * np.abs(missed).max())
    assert np.isnan(source.at(unit_from_angles_deg([40.0, 40.0], [179.0, 90.0])).values.dsf_per_sr).all()
    profile = judged(source.distribution, Smooth(1.2)).profiles[0]
    assert int(profile.used.sum()) == 1701
    assert profile.b_per_sr / profile.a_per_sr == pytest.approx(np.full(1701, 1.2), rel=0.01)


def test_masked_and_missing_points_of_b_give_no_value() -> None:
    unit = lattice(4000)
    b = masked(of(smooth_per_sr, unit), angle_between_deg(unit, unit_from_angles_deg(40.0, 90.0)) < 10.0)
    keep = angle_between_deg(unit, unit_from_angles_deg(50.0, 270.0)) > 15.0
    b = replace(
        distribution(unit[keep], b.dsf_per_sr[keep]), flags=b.flags[keep], variance_per_sr2=np.zeros(int(keep.sum()))
    )
    a = of(smooth_per_sr, lattice(3000))
    pair = pair_of(a, b)
    in_mask = angle_between_deg(lattice(3000), unit_from_angles_deg(40.0, 90.0)) < 8.0
    in_hole = angle_between_deg(lattice(3000), unit_from_angles_deg(50.0, 270.0)) < 8.0
    assert not pair.used[in_mask | in_hole].any()
    left_out = pair.metrics["whole"].left_out
    by_the_hole = angle_between_deg(lattice(3000), unit_from_angles_deg(50.0, 270.0)) < 16.0
    assert not (
        ~pair.used & ~by_the_hole & (angle_between_deg(lattice(3000), unit_from_angles_deg(40.0, 90.0)) > 14)
    ).any()
    assert left_out["masked_b"] == (~pair.used & ~by_the_hole).sum() > in_mask.sum()
    assert left_out["outside_b"] == (~pair.used & by_the_hole).sum() >= in_hole.sum()
    assert left_out["masked_a"] == 0
    assert pair.used.sum() == 3000 - left_out["masked_b"] - left_out["outside_b"]


def test_a_model_is_asked_for_the_direction_that_the_axes_read() -> None:
    model = Smooth(1.1)
    read = replace(
        of(smooth_per_sr, lattice(300)),
        integrals={"incident_measured_theta_deg": 30.02, "incident_measured_phi_deg": 359.9},
    )
    pair = compare_with_model(
        dataset(read), lambda _: PerDirection(model.dsf_at), ("a", "b"), Settings(), "scenario"
    ).pairs[0]
    assert set(model.asked) == {(30.02, 359.9)}
    assert pair.metrics["whole"].global_accordance_percent.value == pytest.approx(100.0 * (1.0 - 0.1 / 2.1))
    assert pair.metrics["whole"].bias_percent.value == pytest.approx(10.0)
    assert pair.path_b is None


def test_a_model_without_values_is_refused() -> None:
    a = dataset(of(smooth_per_sr, lattice(300)))
    with pytest.raises(UsageError, match=r"b.xml: has no value for any distribution of a: visible \(30, 0\)"):
        compare_with_model(a, lambda _: None, ("a", "b.xml"), Settings(), "matrices")


def test_distributions_are_matched_by_channel_and_incident_direction() -> None:
    unit = lattice(200)
    flat = np.ones(200)

    def at(theta: float, phi: float, channel: str = "visible", factor: float = 1.0) -> Distribution:
        return distribution(unit, factor * flat, incident=(theta, phi), channel=channel)

    a = dataset(at(0, 0), at(30, 0), at(60, 0), at(30, 0, "infrared"))
    b = dataset(at(30.3, 0, factor=3.0), at(30.1, 0), at(30, 0, "infrared", 2.0), at(0, 90), at(45, 0))
    found = compare_datasets(a, b, ("a", "b"), Settings())
    assert [(p.channel, p.incident_theta_deg, p.b_incident_theta_deg) for p in found.pairs] == [
        ("visible", 0.0, 0.0),  # at normal incidence the azimuth means nothing
        ("visible", 30.0, 30.1),
        ("infrared", 30.0, 30.0),
    ]
    assert found.unmatched_a == ("visible (60, 0)",)
    assert found.unmatched_b == ("visible (30.3, 0)", "visible (45, 0)")
    rivals = compare_datasets(dataset(at(30.3, 0), at(30.1, 0)), dataset(at(30, 0)), ("a", "b"), Settings())
    assert [p.incident_theta_deg for p in rivals.pairs] == [30.1]
    assert rivals.unmatched_a == ("visible (30.3, 0)",)
    alone = compare_datasets(dataset(at(30, 0, "photopic")), dataset(at(30, 0)), ("a", "b"), Settings())
    assert "photopic" in alone.remarks[0]
    with pytest.raises(UsageError, match=r"may differ by 0\.05 degrees"):
        compare_datasets(dataset(at(30, 0)), dataset(at(30.1, 0)), ("a", "b"), Settings(incident_tolerance_deg=0.05))


def test_the_scatter_plane() -> None:
    """1701 directions; the mirror direction and straight through lie at +theta_i; CV(RMSD) by plain numpy."""
    angle = plane_angles_deg()
    assert len(angle) == 1701
    assert angle[[0, 850, 1700]] == pytest.approx([-85.0, 0.0, 85.0])
    at_30 = int(np.argmin(np.abs(angle - 30.0)))
    for incident, region, expected in (
        ((30.0, 20.0), "reflection", (30.0, 200.0)),
        ((30.0, 20.0), "transmission", (150.0, 200.0)),
        ((150.0, 20.0), "reflection", (150.0, 200.0)),
        ((150.0, 20.0), "transmission", (30.0, 200.0)),
    ):
        found = plane_directions(*incident, region)[at_30]  # type: ignore[arg-type]
        assert found == pytest.approx(unit_from_angles_deg(*expected), abs=1e-12)
    a = of(smooth_per_sr, lattice(20000))
    pair = compare_with_model(
        dataset(a), lambda _: PerDirection(Smooth(1.3).dsf_at), ("a", "b"), Settings(), "scenario"
    ).pairs[0]
    profile = next(p for p in pair.profiles if p.region == "reflection")
    truth = smooth_per_sr(plane_directions(*INCIDENT, "reflection"))
    expected_cv = 0.3 * np.sqrt(np.mean(truth**2)) / np.mean(truth)
    assert profile.cv_rmsd.value == pytest.approx(expected_cv, rel=0.01)
    assert [share.value for share in profile.within_percent] == [0.0, 0.0, 0.0]
    assert int(profile.used.sum()) == 1701


def test_stored_integrals_stand_side_by_side() -> None:
    unit = lattice(400)
    one, other = (of(smooth_per_sr, unit) for _ in range(2))
    one.integrals = {"rho_measured": 0.5, "rho_u": 0.01, "haze": 0.2, "rho_measured_share": 0.9, "cone direct": 0.0}
    one.integrals["cone direct_measured_share"] = 0.7
    other.integrals = {"rho_measured": 0.52, "rho_u": 0.02, "haze": 0.25, "rho_measured_share": 0.8, "cone direct": 0.1}
    other.integrals["cone direct_measured_share"] = 0.7
    one.budgets = {"haze": {"independent": 0.003, "distance": 0.004, "axis arm azimuth": 0.001}}
    other.budgets = {"haze": {"independent": 0.0, "distance": 0.005, "axis arm azimuth": 0.001}}
    one.effects = other.effects = {"distance": np.zeros(400), "axis arm azimuth": np.zeros(400)}
    found = compare_datasets(dataset(one, instrument="x"), dataset(other, instrument="x"), ("a", "b"), Settings())
    integrals = {i.name: i for i in found.pairs[0].integrals if not i.name.endswith("compared")}
    assert {name for name in integrals if not name.startswith("cone_")} == {"rho_measured", "haze", "cone direct"}
    assert integrals["rho_measured"].delta_percent == pytest.approx(4.0)
    assert integrals["rho_measured"].in_u == pytest.approx(0.02 / np.hypot(0.01, 0.02))
    # The distance scales both alike: 0.004 of 0.2 is 0.005 of 0.25. An axis without sign does not cancel.
    assert integrals["haze"].u_percent == pytest.approx(
        100.0 * np.sqrt((1.25 * 0.003 / 0.2) ** 2 + (1.25 * 0.001 / 0.2) ** 2 + (0.001 / 0.2) ** 2)
    )
    assert integrals["cone direct"].delta_percent is None
    other.integrals = {"haze": float("nan")}
    unknown = compare_datasets(dataset(one), dataset(other), ("a", "b"), Settings())
    haze = json.loads(json.dumps(as_json(unknown), allow_nan=False))["distributions"][0]["integrals"][-1]
    assert (haze["name"], haze["b"], haze["delta_percent"]) == ("haze", None, None)
    assert "nan" not in text(unknown)


def test_the_paths_are_what_was_flown() -> None:
    unit = lattice(100)
    flags = np.where(np.arange(100) < 90, PointFlag.MEASURED, PointFlag.UNREACHABLE).astype(np.uint16)
    dsf = np.where(flags == 0, 1.0, np.nan)
    path = (np.arange(100) // 60).astype(np.int32)
    a = replace(distribution(unit, dsf), flags=flags, path=path, paths=("coarse 30/0", "mirror 30/0"))
    pair = pair_of(a, distribution(unit, np.ones(100)))
    assert pair.path_a.names == ("coarse 30/0", "mirror 30/0")
    assert pair.path_a.path.tolist() == [0] * 60 + [1] * 30
    assert pair.path_a.theta_deg == pytest.approx(a.theta_deg[:90])
    assert pair.path_b is not None
    assert set(pair.path_b.path.tolist()) == {-1}
    assert pair.metrics["whole"].left_out["masked_a"] == 10


def test_json_has_no_nan_and_text_says_who_is_the_reference() -> None:
    unit = lattice(300)
    a = masked(of(smooth_per_sr, unit), unit[:, 2] < 0.2)
    b = masked(distribution(unit, np.zeros(300)), unit[:, 2] > -0.2)
    found = compare_datasets(dataset(a), dataset(b), ("one.h5", "two.h5"), Settings())  # nothing in common
    plain = json.loads(json.dumps(as_json(found), allow_nan=False))
    assert plain["global_accordance_percent"] == {"lowest": None, "mean": None}
    assert "no point in common" in found.remarks[0]
    zero = compare_datasets(
        dataset(distribution(unit, np.zeros(300))), dataset(of(smooth_per_sr, unit)), ("a", "b"), Settings()
    )
    whole = json.loads(json.dumps(as_json(zero), allow_nan=False))["distributions"][0]["metrics"]["whole"]
    assert whole["global_accordance_percent"]["value"] == 0.0
    assert whole["within_percent"][0]["value"] is None
    assert whole["under_floor"] == 300
    assert text(zero).startswith("A (reference): a\nB (dataset): b\n")
