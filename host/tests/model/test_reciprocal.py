"""test_reciprocal.py: residuals of f(i, o) = f(o, i) of samples that keep it and of one that does not."""

import numpy as np
from numpy.typing import NDArray
from sampled_nodes import MIRROR, dataset

from gonio.dataset.bsdf import Dataset
from gonio.model.fitted import fit_bsdf

FloatArray = NDArray[np.float64]
THETAS = (0.0, 12.0, 24.0, 36.0, 48.0, 60.0, 72.0)


def reciprocal(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
    """BSDF of the difference of direction cosines from the mirror direction: the same both ways."""
    d = outgoing - incident * MIRROR
    return (0.1 + 2.0 * np.exp(-0.5 * (d[:, 0] ** 2 + d[:, 1] ** 2) / 0.3**2)) * outgoing[:, 2]


def one_sided(incident: FloatArray, outgoing: FloatArray) -> FloatArray:
    """More light for larger theta_i."""
    return reciprocal(incident, outgoing) * (2.0 - incident[2])


def _measured(function: object) -> Dataset:
    return dataset(function, [(t, 0.0) for t in THETAS], noise=0.01)  # type: ignore[arg-type]


def _record(function: object, *, enforce: bool = False) -> dict[str, dict[str, float]]:
    found = fit_bsdf(_measured(function), method="blend-opposite", enforce_reciprocity=enforce).provenance["model"]
    assert found["reciprocity_enforced"] is enforce
    record: dict[str, dict[str, float]] = found["channels"]["visible"]["front reflection"]
    return record


def test_a_reciprocal_sample_leaves_little() -> None:
    record = _record(reciprocal)
    assert record["reciprocity"]["relative_rms"] < 0.08  # what interpolation over 12 degrees costs
    assert record["reciprocity"]["pairs"] > 500
    assert "reciprocity_enforced" not in record


def test_one_that_is_not_is_reported_and_mended_only_on_request() -> None:
    # f(i, o) - f(o, i) = f (cos(theta_o) - cos(theta_i)): some 10 % of f in the mean.
    before = _record(one_sided)["reciprocity"]["relative_rms"]
    assert 0.06 < before < 0.4
    record = _record(one_sided, enforce=True)
    assert record["reciprocity"]["relative_rms"] == before
    assert record["reciprocity_enforced"]["relative_rms"] < 0.5 * before
