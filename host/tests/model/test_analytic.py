"""test_analytic.py: analytic families as Scattering: sides, frames, JSON, fits, choice, ties, refusals."""

import json
import time

import numpy as np
import pytest
from analytic_cases import ONE, dataset, hemisphere, integral_by_scipy, light, measured

from benchmarks.models.samples import RetroCoating
from gonio.dataset.bsdf import Distribution
from gonio.dataset.scattering import Origin
from gonio.model.analytic import ALL, FAMILIES, AnalyticScattering, Component, fit_family
from gonio.units.errors import UsageError

EXAMPLES = [
    Component.of("lambertian", "transmission", share=0.4),
    Component.of("abg", "reflection", A=0.02, B=0.01, g=2.0),
    Component.of(
        "gaussian", "reflection", diffuse=0.2, opposite_peak=1.0, opposite_sigma=9.0, same_peak=2.0, same_sigma=2.0
    ),
    Component.of("ggx", "reflection", diffuse=0.2, alpha=0.15, f0=0.05),
    Component.of("ggx-dielectric", "reflection", diffuse=0.2, alpha=0.15, index=1.5),
    Component.of("ggx-through", "transmission", diffuse=0.0, alpha=0.15, index=1.4),
    Component.of("ward-duer", "reflection", diffuse=0.2, specular=0.3, alpha=0.15),
]


def sheet() -> AnalyticScattering:
    """Front: ABg reflection, Gaussian transmission; back: Lambertian reflection; no light through from the back."""
    return AnalyticScattering(
        {
            (True, True): EXAMPLES[1],
            (True, False): Component.of(
                "gaussian",
                "transmission",
                diffuse=0.1,
                opposite_peak=5.0,
                opposite_sigma=3.0,
                same_peak=0.0,
                same_sigma=9.0,
            ),
            (False, False): Component.of("lambertian", "reflection", share=0.5),
        },
        (5.0, 60.0),
    )


@pytest.mark.parametrize("component", EXAMPLES, ids=lambda c: c.family.name)
def test_every_family_is_documented_and_bounded(component: Component) -> None:
    family = component.family
    assert type(family).__doc__
    assert family.source
    assert ALL[family.name] is family
    for at, parameter in enumerate(family.parameters):
        assert parameter.lower <= component.values[0, at] <= parameter.upper
        named = {p.name: float(v) for p, v in zip(family.parameters, component.values[0], strict=True)}
        with pytest.raises(ValueError, match=parameter.name):
            Component.of(family.name, component.process, **{**named, parameter.name: parameter.upper * 1.01 + 1})


@pytest.mark.parametrize("component", EXAMPLES, ids=lambda c: c.family.name)
@pytest.mark.parametrize("theta", [0.0, 50.0])
def test_integrals_by_scipy(component: Component, theta: float) -> None:
    centre = np.sin(np.radians(theta)) / (1.4 if component.family.name == "ggx-through" else 1.0)
    truth = integral_by_scipy(component, theta, float(centre))
    assert component.integral(np.array([theta]))[0] == pytest.approx(truth, rel=2e-5)


@pytest.mark.parametrize("component", EXAMPLES, ids=lambda c: c.family.name)
def test_many_directions_are_each_as_alone(component: Component) -> None:
    """k incident rows and m outgoing directions, `which` in any order, turned about the normal: the same values."""
    incident = np.concatenate([light(t, p) for t, p in ((10.0, 0.0), (50.0, 77.0), (50.0, 200.0))])
    unit = hemisphere(60)
    which = np.arange(60) % 3
    together = component.bsdf_per_sr(incident, unit, which)
    for row in range(3):
        alone = component.bsdf_per_sr(incident[row : row + 1], unit[which == row], np.zeros(20, dtype=np.int64))
        assert together[which == row] == pytest.approx(alone, rel=1e-9)
    turn = np.radians(33.0)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    assert component.bsdf_per_sr(incident @ matrix.T, unit @ matrix.T, which) == pytest.approx(together, rel=1e-7)


def test_sides() -> None:
    """Mirror and straight through lie where CONVENTIONS.md has them; what no component covers is absent."""
    s = sheet()
    i = light(40.0, 30.0)
    peaks = np.array([[-1, -1, 1], [-1, -1, -1]]) * i
    assert s.dsf_per_sr(i, peaks) == pytest.approx([2.0 * i[0, 2], 0.1 / np.pi * i[0, 2] + 5.0])
    behind = i * [1, 1, -1]
    values = s.dsf_per_sr(behind, peaks)
    assert np.isnan(values[0])
    assert values[1] == pytest.approx(0.5 / np.pi * i[0, 2])
    assert s.origin(behind, peaks).tolist() == [Origin.ABSENT, Origin.INTERPOLATED]
    assert s.origin(light(70.0), peaks).tolist() == [Origin.EXTRAPOLATED] * 2
    assert s.covers(incident_front=True, outgoing_front=False)
    assert not s.covers(incident_front=False, outgoing_front=True)
    found = s.features(np.concatenate((behind, i)))
    assert found.incident.tolist() == [1, 1]
    assert found.centre[1] == pytest.approx(-i[0])
    both = np.concatenate((i, behind))
    mixed = s.dsf_per_sr(both, np.repeat(peaks, 2, axis=0), np.array([0, 1, 0, 1]))
    assert np.isnan(mixed).tolist() == [False, True, False, False]
    with pytest.raises(ValueError, match="front to back"):
        AnalyticScattering({(True, False): EXAMPLES[1]})


def test_json_there_and_back() -> None:
    s = sheet()
    stored = json.loads(json.dumps(s.to_json(), allow_nan=False))
    again = AnalyticScattering.from_json(stored)
    i = light(33.0, 10.0)
    unit = np.concatenate((hemisphere(200), hemisphere(200) * [1, 1, -1]))
    assert np.array_equal(s.dsf_per_sr(i, unit), again.dsf_per_sr(i, unit))
    assert again.theta_range_deg == (5.0, 60.0)
    for damage in (
        {**stored, "kind": "other"},
        {**stored, "components": [{**stored["components"][0], "family": "phong"}]},
        {**stored, "components": [{**stored["components"][0], "values": [[1.0]]}]},
        {**stored, "components": [{**stored["components"][0], "process": "sideways"}]},
        {**stored, "components": 3},
        [],
    ):
        with pytest.raises(
            (UsageError, LookupError, TypeError, ValueError, AttributeError)
        ):  # one line by model_file.py
            AnalyticScattering.from_json(damage)  # type: ignore[arg-type]


def coating(theta: float, noise: float = 0.03) -> Distribution:
    """Points of the retro coating of benchmarks/models."""
    truth = Component.of(
        "gaussian", "reflection", diffuse=0.25, opposite_peak=0.4, opposite_sigma=12.0, same_peak=150.0, same_sigma=1.2
    )
    own = light(theta)
    unit = hemisphere(300)
    assert truth.dsf_per_sr(own, unit, np.zeros(300, dtype=np.int64)) == pytest.approx(
        RetroCoating().dsf_per_sr(own, unit)
    )
    return measured({True: truth}, theta, noise=noise, n=6000, seed=int(theta))


def test_gaussian_recovers_the_retro_coating() -> None:
    """All five parameters within four of their standard uncertainties, which are a few per cent at most."""
    found = fit_family(dataset(coating(30.0), coating(50.0)), "gaussian")
    record = found.provenance["model"]["channels"]["visible"]["components"]["front reflection"]
    truth = {"diffuse": 0.25, "opposite_peak": 0.4, "opposite_sigma": 12.0, "same_peak": 150.0, "same_sigma": 1.2}
    for line in record["fits"]:
        for name, value in truth.items():
            fit = line["weighted"][name]
            assert fit["u"] < 0.05 * value
            assert abs(fit["value"] - value) < 4 * fit["u"], (name, fit)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("ggx", {"diffuse": 0.3, "alpha": 0.12, "f0": 0.08}),
        ("ward-duer", {"diffuse": 0.3, "specular": 0.2, "alpha": 0.12}),
        ("ggx-dielectric", {"diffuse": 0.3, "alpha": 0.2, "index": 1.6}),
    ],
)
def test_surfaces_recover_their_parameters(name: str, parameters: dict[str, float]) -> None:
    truth = Component.of(name, "reflection", **parameters)
    points = [measured({True: truth}, t, noise=0.05, seed=int(t) + 3) for t in (10.0, 40.0, 65.0)]
    record = fit_family(dataset(*points), name).provenance["model"]["channels"]["visible"]["components"]
    fit = record["front reflection"]["fits"][0]["weighted"]
    for key, value in parameters.items():
        assert fit[key]["u"] < 0.05 * value
        assert abs(fit[key]["value"] - value) < 4 * fit[key]["u"], key
    assert record["front reflection"]["tie"]["factor_at_fits"] == pytest.approx([1.0, 1.0, 1.0], abs=0.01)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("abg", {"A": 0.02, "B": 0.005, "g": 2.2}),
        ("ward-duer", {"diffuse": 0.3, "specular": 0.2, "alpha": 0.2}),
        ("lambertian", {"share": 0.6}),
    ],
)
def test_auto_finds_the_family(name: str, parameters: dict[str, float]) -> None:
    """The family that made the points predicts the direction left out best; the table has all that can."""
    truth = Component.of(name, "reflection", **parameters)
    points = [measured({True: truth}, t, noise=0.05, n=600, seed=int(t) + 3) for t in (5.0, 35.0, 65.0)]
    entry = fit_family(dataset(*points), "auto").provenance["model"]["channels"]["visible"]["components"][
        "front reflection"
    ]
    table = {line["family"]: line["misplaced"] for line in entry["held_out"]["table"]}
    assert set(table) == {n for n, family in ALL.items() if "reflection" in family.processes}
    assert entry["family"] == name
    assert table[name] <= 1.03 * min(table.values())


def test_a_direction_left_out_is_not_seen() -> None:
    """The middle direction differs from its neighbours: predicted from them it is wrong, in shape as in integral."""
    wide = Component.of("abg", "reflection", A=0.1, B=0.4, g=1.0)
    level = (
        wide.integral(np.array([40.0]))[0]
        / Component.of("abg", "reflection", A=1.0, B=1e-4, g=2.5).integral(np.array([40.0]))[0]
    )
    narrow = Component.of("abg", "reflection", A=level, B=1e-4, g=2.5)  # the same integral
    points = [measured({True: c}, t, noise=0.02, n=1000) for c, t in ((wide, 20.0), (narrow, 40.0), (wide, 60.0))]
    held = fit_family(dataset(*points), "abg").provenance["model"]["channels"]["visible"]["components"]
    errors = {
        line["theta_i_deg"]: line["misplaced"]
        for line in held["front reflection"]["held_out"]["table"][0]["directions"]
    }
    assert errors[40.0] > 0.5
    flat = [
        measured({True: Component.of("lambertian", "reflection", share=share)}, t, n=1000)
        for share, t in ((0.2, 20.0), (0.6, 40.0), (0.2, 60.0))
    ]
    held = fit_family(dataset(*flat), "lambertian").provenance["model"]["channels"]["visible"]["components"]
    line = held["front reflection"]["held_out"]["table"][0]["directions"][1]
    assert line["misplaced"] == pytest.approx(0.5 * (0.6 - 0.2) / 0.6, rel=1e-3)


def test_two_directions_are_split_by_points() -> None:
    truth = Component.of("abg", "reflection", A=0.02, B=0.005, g=2.2)
    points = [measured({True: truth}, t, noise=0.05, n=1600) for t in (20.0, 50.0)]
    entry = fit_family(dataset(*points), "abg").provenance["model"]["channels"]["visible"]["components"][
        "front reflection"
    ]
    assert "every 5th point" in entry["held_out"]["rule"]
    assert entry["held_out"]["table"][0]["misplaced"] < 0.04


def test_four_components_and_the_back_only_when_told() -> None:
    """Reflection and transmission from both sides; the back is not made up, unless it is declared equal."""
    front = {
        True: Component.of("lambertian", "reflection", share=0.3),
        False: Component.of("lambertian", "transmission", share=0.2),
    }
    back = {
        True: Component.of("lambertian", "reflection", share=0.5),
        False: Component.of("lambertian", "transmission", share=0.1),
    }
    i, o = light(30.0), np.array([[0.1, 0.2, 0.97], [0.1, 0.2, -0.97]])
    o /= np.linalg.norm(o, axis=1)[:, None]
    z = o[0, 2] / np.pi
    all_four = dataset(
        measured(front, 20.0, n=400), measured(front, 50.0, n=400), measured(back, 20.0, n=400, from_front=False)
    )
    s = fit_family(all_four, "lambertian").channels["visible"]
    assert s.dsf_per_sr(i, o) == pytest.approx([0.3 * z, 0.2 * z], rel=1e-6)
    assert s.dsf_per_sr(-i, o) == pytest.approx([0.1 * z, 0.5 * z], rel=1e-6)
    only_front = dataset(measured(front, 20.0, n=400))
    alone = fit_family(only_front, "lambertian").channels["visible"]
    assert np.isnan(alone.dsf_per_sr(-i, o)).all()
    told = fit_family(only_front, "lambertian", back_as_front=True)
    assert told.channels["visible"].dsf_per_sr(-i, o) == pytest.approx([0.2 * z, 0.3 * z], rel=1e-6)
    assert any("as the user declared" in sentence for sentence in told.validity)


def test_energy_is_stated_and_excess_is_a_finding() -> None:
    bright = {
        True: Component.of("lambertian", "reflection", share=0.8),
        False: Component.of("lambertian", "transmission", share=0.4),
    }
    entry = fit_family(dataset(measured(bright, 20.0, n=400)), "lambertian").provenance["model"]["channels"]["visible"]
    assert entry["energy"][0]["sum"] == pytest.approx(1.2)
    assert "rho + tau is 1.2" in entry["findings"][0]


def test_uncovered_part_is_the_models() -> None:
    """Points in a cap only: the tie is the points' sum times the model's whole over its part in the cap."""
    truth = Component.of("lambertian", "reflection", share=0.6)
    d = measured({True: truth}, 20.0, n=2000)
    seen = d.theta_deg < 45.0
    for name in (
        "theta_deg",
        "phi_deg",
        "dsf_per_sr",
        "variance_per_sr2",
        "signal",
        "normalisation",
        "count",
        "flags",
        "solid_angle_sr",
        "time_ns",
    ):
        setattr(d, name, getattr(d, name)[seen])
    d.integrals = {"rho_measured": float(d.dsf_per_sr @ d.solid_angle_sr)}
    assert d.integrals["rho_measured"] == pytest.approx(0.3, abs=0.01)
    entry = fit_family(dataset(d), "lambertian").provenance["model"]["channels"]["visible"]["components"][
        "front reflection"
    ]
    assert entry["tie"]["value"] == pytest.approx([0.6], abs=0.002)
    assert "filled by the model" in entry["tie"]["source"]


def test_refusals() -> None:
    truth = {True: EXAMPLES[1], False: Component.of("lambertian", "transmission", share=0.2)}
    data = dataset(measured(truth, 20.0, n=400))
    with pytest.raises(UsageError, match="choose one of"):
        fit_family(data, "phong")
    with pytest.raises(UsageError, match="no transmission"):
        fit_family(data, "ward-duer")
    with pytest.raises(UsageError, match="no channel 'NIR'"):
        fit_family(data, "abg", channels=("NIR",))
    with pytest.raises(UsageError, match="are isotropic"):
        fit_family(data, "abg", symmetry="bilateral")
    data.symmetry = "undeclared"
    with pytest.raises(UsageError, match="--symmetry"):
        fit_family(data, "abg")
    data.symmetry = "isotropic"
    data.distributions[0].solid_angle_sr[:] = 0.0
    with pytest.raises(UsageError, match="gonio reduce"):
        fit_family(data, "abg")
    assert FAMILIES[-1] == "auto"


def test_contradicted_symmetry_is_a_finding() -> None:
    """Two azimuths that differ by half: declared isotropic, tested, said."""
    one, other = (Component.of("lambertian", "reflection", share=share) for share in (0.6, 0.3))
    data = dataset(
        measured({True: one}, 30.0, n=1500, noise=0.01), measured({True: other}, 30.0, n=1500, noise=0.01, phi_deg=90.0)
    )
    entry = fit_family(data, "lambertian").provenance["model"]["channels"]["visible"]["components"]["front reflection"]
    assert any("contradicted" in finding for finding in entry["findings"])


def test_a_million_directions_in_processor_time() -> None:
    """Integrators ask for millions: no loop over directions (a Python loop would take a minute)."""
    s = sheet()
    incident = np.concatenate([light(t) for t in np.linspace(0, 80, 200)])
    unit = np.tile(hemisphere(5000), (200, 1))
    which = np.repeat(np.arange(200), 5000)
    start = time.process_time()
    values = s.dsf_per_sr(incident, unit, which)
    assert time.process_time() - start < 5.0
    assert np.isfinite(values).all()
    assert values[:3] == pytest.approx(
        np.concatenate([s.dsf_per_sr(incident[:1], unit[j : j + 1], ONE) for j in range(3)])
    )
