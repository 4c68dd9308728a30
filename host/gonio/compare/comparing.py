"""comparing.py: a whole comparison: B is compared with A, the reference, distribution by distribution."""

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from gonio.compare.field import ModelField, PointField, incident_read
from gonio.compare.match import described, match
from gonio.compare.pair import Beside, judge_pair
from gonio.compare.result import Comparison, Pair, Settings
from gonio.compare.table import pair_name
from gonio.compare.values import shared_effects
from gonio.dataset.bsdf import Dataset, Distribution
from gonio.dataset.scattering import Scattering
from gonio.units.errors import UsageError


def compare_datasets(
    a: Dataset,
    b: Dataset,
    names: tuple[str, str],
    settings: Settings,
    kind: Literal["dataset", "simulation"] = "dataset",
) -> Comparison:
    """Two datasets: by index where their points are the same, else B is interpolated at A's points. Raises UsageError
    where nothing belongs together or values are not normalised."""
    found = match(a, b, settings.incident_tolerance_deg)
    if not found.pairs:
        raise UsageError(
            f"{names[1]}: {_listed(found.unmatched_b)} belongs to none of {names[0]}, {_listed(found.unmatched_a)}: "
            f"channels must agree, incident directions may differ by {settings.incident_tolerance_deg:g} degrees"
        )
    one_instrument = "instrument_text" in a.provenance and _same(a, b, "instrument_text")
    pairs = []
    for i, j in found.pairs:
        one, other = a.distributions[i], b.distributions[j]
        _check_normalised(one, names[0])
        _check_normalised(other, names[1])
        reference, field = PointField(one), PointField(other)
        same_points = field.has_points(reference.unit)
        if same_points:
            field = PointField(other, like=reference)
        beside = Beside(
            at=field.at_points() if same_points else field.at(reference.unit),
            route="same points" if same_points else "interpolated",
            field=field,
            channel=other.channel,
            incident_deg=(other.incident_theta_deg, other.incident_phi_deg),
            distribution=other,
            shared=shared_effects(one, other, one_instrument=one_instrument),
        )
        pairs.append(judge_pair(reference, beside, settings))
    return Comparison(
        a_name=names[0],
        b_name=names[1],
        b_kind=kind,
        pairs=tuple(pairs),
        unmatched_a=found.unmatched_a,
        unmatched_b=found.unmatched_b,
        settings=settings,
        remarks=(*found.remarks, *_differences(a, b), *_remarks(pairs)),
    )


def compare_with_model(
    a: Dataset,
    model_of: Callable[[Distribution], Scattering | None],
    names: tuple[str, str],
    settings: Settings,
    kind: Literal["scenario", "matrices", "tree", "model"],
    remarks: Sequence[str] = (),
) -> Comparison:
    """A model, evaluated at A's directions and at the incident directions that A's axes read. `model_of` gives that of
    a distribution or None. Raises UsageError where there is none at all."""
    pairs, unmatched = [], []
    for one in a.distributions:
        _check_normalised(one, names[0])
        reference, incident_deg, model = PointField(one), incident_read(one), model_of(one)
        field = None if model is None else ModelField(model, *incident_deg)
        at = None if field is None else field.at(reference.unit)
        if field is None or at is None or not np.isfinite(at.values.dsf_per_sr).any():
            unmatched.append(described(one))
            continue
        beside = Beside(at, "evaluated", field, one.channel, incident_deg, None)
        pairs.append(judge_pair(reference, beside, settings))
    if not pairs:
        raise UsageError(f"{names[1]}: has no value for any distribution of {names[0]}: {_listed(unmatched)}")
    return Comparison(
        a_name=names[0],
        b_name=names[1],
        b_kind=kind,
        pairs=tuple(pairs),
        unmatched_a=tuple(unmatched),
        unmatched_b=(),
        settings=settings,
        remarks=(*remarks, *_remarks(pairs)),
    )


def _check_normalised(distribution: Distribution, name: str) -> None:
    if np.isnan(distribution.p_i):
        raise UsageError(
            f"{name}: {described(distribution)} is in {distribution.signal_unit}, not normalised to a DSF: import it "
            "with a beam scan or its P_i"
        )
    if not distribution.measured.any():
        raise UsageError(f"{name}: {described(distribution)} has no unmasked point: nothing to compare")


def _differences(a: Dataset, b: Dataset) -> list[str]:
    """What the two files say about themselves that does not agree, one sentence each."""
    remarks = []
    for what, one, other, silent in (
        ("front", a.front_faces, b.front_faces, "undeclared"),
        ("polarisation", a.polarisation, b.polarisation, "unknown"),
    ):
        if one != other and silent not in (one, other):
            remarks.append(f"{what}: A says {one}, B says {other}")
    if a.provenance.get("raw_sha256") and _same(a, b, "raw_sha256"):
        remarks.append("both come from the same raw logs: their noise is the same, and u(A - B) is too large")
    return remarks


def _remarks(pairs: Sequence[Pair]) -> list[str]:
    """What the pairs show that the user should know."""
    remarks = []
    for pair in pairs:
        name = pair_name(pair)
        if not pair.metrics:
            remarks.append(f"{name}: A and B have no point in common")
            continue
        whole = pair.metrics["whole"]
        if not whole.solid_angle_sr > 0.0:
            remarks.append(f"{name}: A has no solid angles, so nothing is weighted by them: gonio reduce gives them")
        if whole.without_uncertainty:
            remarks.append(f"{name}: {whole.without_uncertainty} of {whole.points} points have no uncertainty")
    return remarks


def _same(a: Dataset, b: Dataset, key: str) -> bool:
    return bool(a.provenance.get(key) == b.provenance.get(key))


def _listed(names: Sequence[str], most: int = 4) -> str:
    shown = ", ".join(names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown or "(nothing)"
