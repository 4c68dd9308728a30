"""merging.py: datasets to one dataset: what belongs together is compared, joined, added up and recorded."""

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.dataset.bsdf import Dataset, Distribution, Polarisation
from gonio.geometry.directions import angle_between_deg
from gonio.merge.join import Pass, incident_unit, join, pass_of
from gonio.merge.overlap import Overlap, disagreeing, outliers, overlap
from gonio.merge.points import path_numbers
from gonio.merge.polarisation import unpolarised
from gonio.merge.retro import RetroOptions, beyond, retro_distribution
from gonio.merge.scopes import Scopes
from gonio.merge.seam import Seam, seam
from gonio.merge.sources import Source, check_alike
from gonio.reduce.coverage import REACH_FACTOR
from gonio.reduce.integrals.hemispheres import evaluated
from gonio.reduce.integrals.peaks import evaluated_peak
from gonio.units.errors import UsageError
from gonio.units.version import gonio_version

_PEAK = re.compile(r"peak (.*) first_point$")
_WAVELENGTH_NM = 0.5  # nearer wavelengths are one

WHAT = (
    "distributions of one channel and incident direction are one: all points, cells over all of them; points of "
    "several sessions within a fraction of the aperture share their cells by inverse variance; a direction that one "
    "session masked and another measured belongs to the other; effects of sessions and mountings are kept apart"
)


@dataclass(frozen=True)
class MergeOptions:
    """`tolerance_deg`: of incident directions that are one. `reach`: cells end so many pitches from their points.
    `together_deg`: see sharing.py. `limit`: combined standard uncertainties at which a pass is an outlier and a seam a
    step. `force`: join what says that it is of different samples or polarisations."""

    tolerance_deg: float = 0.1
    reach: float = REACH_FACTOR
    together_deg: float = 0.14
    limit: float = 3.0
    drop_outliers: bool = False
    force: bool = False


@dataclass(frozen=True)
class Rig:
    """A scan through the beam splitters, and where its reference beam is: in itself if there is no other."""

    source: Source
    reference: Source | None
    options: RetroOptions


@dataclass
class Merged:
    """The dataset; statistics as plain JSON values; and what the user should know, one line each."""

    dataset: Dataset
    statistics: dict[str, Any]
    remarks: list[str] = field(default_factory=list)


@dataclass
class _Group:
    """Passes of one channel and incident direction."""

    passes: list[Pass]
    retro_radius_deg: float | None = None

    @property
    def where(self) -> str:
        first = self.passes[0].distribution
        return f"{first.channel}, incident ({first.incident_theta_deg:g}, {first.incident_phi_deg:g})"


def merge(sources: Sequence[Source], rigs: Sequence[Rig], options: MergeOptions) -> Merged:
    """One dataset of all. Raises UsageError for what cannot be joined."""
    everyone = [*sources, *(rig.source for rig in rigs)]
    remarks = check_alike(everyone, force=options.force)
    polarisation = _polarisation(everyone, force=options.force)
    scopes = Scopes.of(everyone)
    groups = _groups([pass_of(s, d, scopes) for s in sources for d in s.dataset.distributions], options)
    retro_facts = [_add_retro(groups, rig, scopes, options, remarks) for rig in rigs]
    distributions, described = [], []
    for group in groups:
        found = _of_group(group, polarisation, options, remarks)
        if found is not None:
            distributions.append(found[0])
            described.append(found[1])
    if not distributions:
        raise UsageError("nothing is left to merge: no incident direction has both an s and a p set")
    first = sources[0].dataset
    statistics = {
        "sources": [source.described() for source in everyone],
        "options": asdict(options),
        "distributions": described,
        "retro": retro_facts,
    }
    dataset = replace(
        first,
        distributions=distributions,
        front_faces=_declared(everyone, "front_faces"),
        symmetry=_declared(everyone, "symmetry"),
        polarisation=polarisation,
        thickness_mm=next((s.dataset.thickness_mm for s in everyone if s.dataset.thickness_mm is not None), None),
        manufacturer=next((s.dataset.manufacturer for s in everyone if s.dataset.manufacturer), ""),
        provenance=_provenance(everyone, options, statistics, remarks),
    )
    return Merged(dataset, statistics, remarks)


def _groups(passes: Sequence[Pass], options: MergeOptions) -> list[_Group]:
    """In the order in which their first passes come."""
    groups: list[_Group] = []
    for one in passes:
        group = _group_of(groups, one.distribution, options)
        if group is None:
            groups.append(_Group([one]))
        else:
            group.passes.append(one)
    return groups


def _group_of(groups: Sequence[_Group], distribution: Distribution, options: MergeOptions) -> _Group | None:
    for group in groups:
        first = group.passes[0].distribution
        if first.channel != distribution.channel or not _one_wavelength(first, distribution):
            continue
        if angle_between_deg(incident_unit(first), incident_unit(distribution)) <= options.tolerance_deg:
            return group
    return None


def _one_wavelength(a: Distribution, b: Distribution) -> bool:
    if a.wavelength_nm is None or b.wavelength_nm is None:
        return a.wavelength_nm is b.wavelength_nm
    return abs(a.wavelength_nm - b.wavelength_nm) <= _WAVELENGTH_NM


def _polarisation(sources: Sequence[Source], *, force: bool) -> Polarisation:
    """Of the merged dataset. s and p together are unpolarised."""
    found = {source.dataset.polarisation: source.name for source in sources}
    if len(found) == 1:
        return next(iter(found))
    if set(found) == {"s", "p"}:
        return "unpolarised"
    if not force:
        (one, of_one), (two, of_two) = list(found.items())[:2]
        raise UsageError(
            f"{of_two}: polarisation {two}, but {of_one} has {one}: only s and p make a mean; say --force to join them "
            "as of unknown polarisation"
        )
    return "unknown"


def _declared(sources: Sequence[Source], field: str) -> Any:
    values = [getattr(source.dataset, field) for source in sources]
    return next((value for value in values if value != "undeclared"), "undeclared")


def _add_retro(
    groups: list[_Group], rig: Rig, scopes: Scopes, options: MergeOptions, remarks: list[str]
) -> dict[str, Any]:
    """Puts what the rig saw about the retro direction into the groups, and takes the rest's points there away."""
    facts = []
    for d in rig.source.dataset.distributions:
        reference = d if rig.reference is None else _reference_of(rig.reference, d)
        found = retro_distribution(d, reference, rig.source.dataset.polarisation, rig.options)
        own = pass_of(rig.source, found.distribution, scopes)
        group = _group_of(groups, d, options)
        removed = 0
        if group is None:
            group = _Group([])
            groups.append(group)
            remarks.append(
                f"{rig.source.name}: no other set has incident ({d.incident_theta_deg:g}, {d.incident_phi_deg:g}) in "
                f"the channel {d.channel}: it holds only what is about the retro direction"
            )
        for k, other in enumerate(group.passes):
            far, inside = beyond(other.distribution, found.radius_deg)
            group.passes[k] = replace(other, distribution=far)
            removed += inside
        group.passes.append(own)
        group.retro_radius_deg = found.radius_deg
        facts.append(
            {"channel": d.channel, "incident_deg": [d.incident_theta_deg, d.incident_phi_deg]}
            | found.facts
            | {"points_removed_elsewhere": removed}
        )
    reference_name = None if rig.reference is None else rig.reference.name
    settings = {k: v for k, v in asdict(rig.options).items() if v is not None}
    return {"source": rig.source.name, "reference": reference_name, "options": settings, "distributions": facts}


def _reference_of(source: Source, like: Distribution) -> Distribution:
    """The distribution of the same channel whose incident direction is nearest."""
    own = [d for d in source.dataset.distributions if d.channel == like.channel]
    if not own:
        raise UsageError(f"{source.name}: has nothing in the channel {like.channel}, which is to be referred to it")
    return min(own, key=lambda d: float(angle_between_deg(incident_unit(d), incident_unit(like))))


def _of_group(
    group: _Group, polarisation: Polarisation, options: MergeOptions, remarks: list[str]
) -> tuple[Distribution, dict[str, Any]] | None:
    """The joined distribution and its statistics."""
    by_polarisation: dict[str, list[Pass]] = {}
    for one in group.passes:
        by_polarisation.setdefault(one.source.dataset.polarisation, []).append(one)
    mean_of_two = polarisation == "unpolarised" and set(by_polarisation) <= {"s", "p"}
    if mean_of_two and len(by_polarisation) == 1:
        remarks.append(f"{group.where}: only {next(iter(by_polarisation))} polarised light: left out")
        return None
    sets = list(by_polarisation.values()) if mean_of_two else [group.passes]
    joined, described = [], []
    for passes in sets:
        kept, statistics = _compared(passes, group.where, options, remarks)
        found = join(kept, reach=options.reach, together_deg=options.together_deg)
        joined.append(found.distribution)
        described.append(statistics | {"points": len(found.distribution.theta_deg), "counts": found.counts})
    result = joined[0]
    entry: dict[str, Any] = {
        "channel": result.channel,
        "incident_deg": [result.incident_theta_deg, result.incident_phi_deg],
        "sets": described,
    }
    if mean_of_two:
        named = dict(zip(by_polarisation, joined, strict=True))
        result, counts = unpolarised(named["s"], named["p"], reach=options.reach)
        entry["mean_of_s_and_p"] = counts
    _add_up(result, group)
    return result, entry


def _add_up(result: Distribution, group: _Group) -> None:
    """Integrals and budgets anew, and the peaks that the passes' own paths were flown about."""
    beams = [one.source.dataset.beam for one in group.passes]
    evaluated(result, beam=next((beam for beam in beams if beam is not None), None)).into(result)
    named = {match[1] for one in group.passes for key in one.distribution.integrals if (match := _PEAK.match(key))}
    longest: dict[str, NDArray[np.intp]] = {}
    for number, path in enumerate(result.paths):
        name, points = path.partition(" #")[0], np.flatnonzero(path_numbers(result) == number)
        if name in named and len(points) > len(longest.get(name, ())):
            longest[name] = points
    for name, points in longest.items():
        # Of one path the points are in one piece: join() keeps the order flown.
        evaluated_peak(result, slice(int(points[0]), int(points[-1]) + 1), name)[1].into(result)
        result.integrals |= {f"peak {name} first_point": float(points[0]), f"peak {name} points": float(len(points))}


def _compared(
    passes: list[Pass], where: str, options: MergeOptions, remarks: list[str]
) -> tuple[list[Pass], dict[str, Any]]:
    """The passes to be joined, and how they agree with each other."""
    overlaps, seams = _pairs(passes, options)
    odd = outliers(overlaps, options.limit)
    for name, others in odd.items():
        fate = "left out (--drop-outliers)" if options.drop_outliers else "kept; --drop-outliers leaves it out"
        remarks.append(
            f"{where}: {name} is an outlier, off by more than {options.limit:g} u from {', '.join(others)}: {fate}"
        )
    for pair in disagreeing(overlaps, options.limit):
        if pair.one not in odd and pair.other not in odd:
            remarks.append(
                f"{where}: {pair.one} and {pair.other} disagree by {abs(pair.offset_in_u):.1f} u (ratio "
                f"{pair.ratio:.4g} +- {pair.ratio_u:.2g}); which one is off they do not tell"
            )
    for border in seams:
        if border.is_step(options.limit):
            remarks.append(
                f"{where}: a step of {border.step_in_u:.1f} u (log ratio {border.mean_log_ratio:+.3f}) between "
                f"{border.one} and {border.other}: an artefact"
            )
    dropped = list(odd) if options.drop_outliers else []
    kept = [one for one in passes if one.source.name not in dropped]
    statistics = {
        "passes": [one.source.name for one in passes],
        "dropped": dropped,
        "outliers": odd,
        "overlaps": [pair.as_json() for pair in overlaps],
        "seams": [border.as_json() | {"step": border.is_step(options.limit)} for border in seams],
    }
    return kept, statistics


def _pairs(passes: Sequence[Pass], options: MergeOptions) -> tuple[list[Overlap], list[Seam]]:
    """Of every two passes: their overlap, or, where they have none, their seam."""
    overlaps, seams = [], []
    for a, b in combinations(passes, 2):
        one, other = (a.source.name, a.distribution), (b.source.name, b.distribution)
        common = overlap(one, other, options.reach)
        if common is not None:
            overlaps.append(common)
            continue
        border = seam(one, other)
        if border is not None:
            seams.append(border)
    return overlaps, seams


def _provenance(
    sources: Sequence[Source], options: MergeOptions, statistics: dict[str, Any], remarks: list[str]
) -> dict[str, Any]:
    """What reproduces the merge: the sources' own provenance, options, statistics, and what was dropped and why."""
    first = sources[0].dataset.provenance
    text = first.get("instrument_text")
    kept = []
    for source in sources:
        own = dict(source.dataset.provenance)
        if own.get("instrument_text") == text:
            own.pop("instrument_text", None)
        kept.append(source.described() | {"provenance": own})
    step = {"name": "merge", "applied": True, "what": WHAT, "parameters": asdict(options)}
    raw = dict.fromkeys(value for s in sources for value in s.dataset.provenance.get("raw_sha256", ()))
    return {
        **({"instrument_text": text} if text else {}),
        "corrections": [*first.get("corrections", ()), step],
        "raw_sha256": list(raw),
        "notes": list(dict.fromkeys(remarks)),
        "versions": {"gonio": gonio_version(), "numpy": np.__version__},
        "merge": statistics | {"sources": kept},
    }
