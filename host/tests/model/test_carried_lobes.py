"""test_carried_lobes.py: a lobe behind the detector's head is carried over from its neighbours; one that is not there
is not."""

import numpy as np
import pytest
from numpy.typing import NDArray
from sampled_nodes import MIRROR, dataset, gaussian, towards

from gonio.dataset.bsdf import Dataset
from gonio.dataset.scattering import Bsdf, Origin
from gonio.geometry.directions import unit_from_angles_deg
from gonio.model.between.energy import integrals
from gonio.model.fit_text import text
from gonio.model.fitted import fit_bsdf
from gonio.model.nodes.points import Component

FloatArray = NDArray[np.float64]
SIGMA_DEG, PEAK = 2.0, 25.0
SHADED_DEG = 4.0  # about the source: two standard deviations of the lobe


def _sample(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
    return 0.3 / np.pi * outgoing[:, 2] + gaussian(outgoing, incident * MIRROR, PEAK, SIGMA_DEG)


def _without_mirror_at_normal(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
    strength = 0.0 if incident[2] > 0.99 else 1.0
    return 0.3 / np.pi * outgoing[:, 2] + strength * gaussian(outgoing, incident * MIRROR, PEAK, SIGMA_DEG)


def _shaded(measured: Dataset) -> Dataset:
    """Without what the head at the source shades."""
    for part in measured.distributions:
        source = towards(part.incident_theta_deg, part.incident_phi_deg)
        hidden = unit_from_angles_deg(part.theta_deg, part.phi_deg) @ source > np.cos(np.radians(SHADED_DEG))
        part.flags[hidden] = 1
    return measured


@pytest.fixture(scope="module")
def shaded() -> Bsdf:
    return fit_bsdf(_shaded(dataset(_sample, [(t, 0.0) for t in (0.0, 30.0, 60.0)], number=20_000)))


def test_a_lobe_behind_the_head_is_there_at_the_node_and_about_it(shaded: Bsdf) -> None:
    model = shaded.channels["visible"]
    for theta in (0.0, 10.0, 15.0, 30.0):
        incident = towards(theta)
        outgoing = np.array([incident * MIRROR, towards(theta + 2.0, 180.0), towards(theta + 5.0, 180.0)])
        np.testing.assert_allclose(
            model.dsf_per_sr(incident[None], outgoing), _sample(incident, outgoing), rtol=0.02, atol=0.01
        )


def test_integrals_do_not_press_it_down(shaded: Bsdf) -> None:
    component = shaded.channels["visible"].components[Component(True, True)]  # type: ignore[attr-defined]
    incident = np.array([towards(t) for t in (0.0, 15.0, 30.0)])
    found = integrals(component.slices(incident), component.resolver.grids)
    np.testing.assert_allclose(found, 0.3 + 2.0 * np.pi * PEAK * np.radians(SIGMA_DEG) ** 2, rtol=5e-3)


def test_it_is_no_measurement_and_the_report_says_so(shaded: Bsdf) -> None:
    model = shaded.channels["visible"]
    outgoing = np.array([towards(0.0), towards(30.0)])
    assert list(model.origin(towards(0.0)[None], outgoing)) == [Origin.INTERPOLATED, Origin.MEASURED]
    nodes = shaded.provenance["model"]["channels"]["visible"]["front reflection"]["nodes"]
    assert [[lobe["carried_over"] for lobe in node["lobes"]] for node in nodes] == [[True], [False], [False]]
    assert "carried over from the neighbouring incident directions" in text(shaded.provenance["model"])
    assert any("top of the lobes at 0, 0 at theta_i 0" in sentence for sentence in shaded.validity)


def test_leaving_a_direction_out_does_not_know_it_through_another() -> None:
    # Twice as strong at 30 degrees: left out, the lobe at 0 is carried over from 60, and 30 is predicted like 60.
    def sample(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
        strength = 2.0 if 0.8 < incident[2] < 0.9 else 1.0
        return 0.3 / np.pi * outgoing[:, 2] + strength * gaussian(outgoing, incident * MIRROR, PEAK, SIGMA_DEG)

    fitted = fit_bsdf(_shaded(dataset(sample, [(t, 0.0) for t in (0.0, 30.0, 60.0)], number=20_000)))
    record = fitted.provenance["model"]["channels"]["visible"]["front reflection"]
    row = next(row for row in record["leave_one_out"] if row["method"] == "lobes-fixed")
    light = 2.0 * np.pi * PEAK * np.radians(SIGMA_DEG) ** 2
    (left_out,) = row["left_out"]
    assert left_out["integral_ratio"] == pytest.approx((0.3 + light) / (0.3 + 2.0 * light), rel=0.01)


def test_flanks_that_are_not_there_contradict_a_lobe() -> None:
    measured = _shaded(dataset(_without_mirror_at_normal, [(t, 0.0) for t in (0.0, 30.0, 60.0)], number=20_000))
    model = fit_bsdf(measured)
    nodes = model.provenance["model"]["channels"]["visible"]["front reflection"]["nodes"]
    assert not nodes[0]["lobes"]
    assert model.channels["visible"].dsf_per_sr(towards(0.0)[None], towards(0.0)[None])[0] < 0.2
