"""sources.py: the datasets to be merged: where each is from, which share a session or a mounting, and whether they may
be joined."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset
from gonio.units.errors import UsageError
from gonio.units.instrument import parse_instrument

_TOGETHER_DEG = 0.14  # a quarter of 10 mm at 1020 mm
_NO_INSTRUMENT = "unknown"


@dataclass(frozen=True)
class Source:
    """One dataset. `session` and `mount` name what it shares with others: equal names, equal causes of error."""

    name: str
    sha256: str
    dataset: Dataset
    session: str
    mount: str
    instrument: str

    def described(self) -> dict[str, Any]:
        """For the provenance of what is made of it."""
        names = ("name", "sha256", "session", "mount", "instrument")
        raw = list(self.dataset.provenance.get("raw_sha256", ()))
        return {name: getattr(self, name) for name in names} | {"raw_sha256": raw}


def sources_of(named: Sequence[tuple[str, str, Dataset]], *, same_mount: bool = False) -> list[Source]:
    """Sources of (name, SHA-256 of the file, dataset) in order. Datasets of one raw log are one session and one
    mounting of the sample; others are sessions of their own, and mountings of their own unless `same_mount`.

    Raises UsageError for a file named twice and for one that is merged already: correlations between a merged set and
    its parts are known only where the parts themselves are named.
    """
    first_of_hash: dict[str, str] = {}
    of_file: dict[str, str] = {}
    found = []
    for name, sha256, dataset in named:
        if sha256 in of_file:
            raise UsageError(f"{name}: has the same content as {of_file[sha256]}: name every dataset once")
        of_file[sha256] = name
        if "merge" in dataset.provenance:
            raise UsageError(f"{name}: is merged already: name the datasets it was made of, and the new ones with them")
        raw = [str(value) for value in dataset.provenance.get("raw_sha256", ())] or [sha256]
        session = next((first_of_hash[value] for value in raw if value in first_of_hash), _short(raw))
        first_of_hash.update(dict.fromkeys(raw, session))
        mount = "one" if same_mount else session
        found.append(Source(name, sha256, dataset, session, mount, _instrument_name(dataset)))
    return found


def check_alike(sources: Sequence[Source], *, force: bool) -> list[str]:
    """Whether the datasets may be one; notes on what was taken over. Raises UsageError: different samples or
    thicknesses (unless `force`), different front faces or symmetries, a distribution without P_i."""
    notes = []
    first = sources[0]
    for other in sources[1:]:
        for field, what in (("sample_name", "sample"), ("thickness_mm", "thickness"), ("manufacturer", "manufacturer")):
            one, two = getattr(first.dataset, field), getattr(other.dataset, field)
            if one == two or not one or not two:
                continue
            if not force:
                raise UsageError(
                    f'{other.name}: {what} "{two}", but {first.name} has "{one}": merge sets of one sample, or say '
                    "--force if it is one"
                )
            notes.append(f'{what} "{two}" of {other.name} is taken for "{one}" (--force)')
    for field, what in (("front_faces", "front faces"), ("symmetry", "symmetry")):
        said = {getattr(s.dataset, field): s.name for s in sources if getattr(s.dataset, field) != "undeclared"}
        if len(said) > 1:
            (one, of_one), (two, of_two) = list(said.items())[:2]
            raise UsageError(
                f"{of_two}: {what} {two}, but {of_one} says {one}: the frames differ; declare them alike before merging"
            )
        silent = [s.name for s in sources if getattr(s.dataset, field) == "undeclared"]
        if said and silent:
            notes.append(f"{what}: {next(iter(said))}, also for {', '.join(silent)}, which does not say")
    for source in sources:
        for d in source.dataset.distributions:
            if not np.isfinite(d.p_i):
                raise UsageError(
                    f"{source.name}: incident ({d.incident_theta_deg:g}, {d.incident_phi_deg:g}) has no P_i, so "
                    "no DSF: import it with --p-i or --beam first"
                )
    return notes


def together_deg(dataset: Dataset) -> float:
    """A quarter of the aperture of the dataset's instrument (of the reference instrument where it does not say): points
    nearer than that see nearly the same."""
    text = dataset.provenance.get("instrument_text")
    if not text:
        return _TOGETHER_DEG
    instrument = parse_instrument(str(text), "instrument file in the dataset")
    return 0.25 * float(np.degrees(instrument.detector_aperture_mm / instrument.arm_radius_mm))


def arm_radius_mm(dataset: Dataset) -> float | None:
    """Of the dataset's instrument, where it says."""
    text = dataset.provenance.get("instrument_text")
    return parse_instrument(str(text), "instrument file in the dataset").arm_radius_mm if text else None


def _short(hashes: Sequence[str]) -> str:
    return hashlib.sha256("\n".join(sorted(hashes)).encode()).hexdigest()[:8]


def _instrument_name(dataset: Dataset) -> str:
    text = dataset.provenance.get("instrument_text")
    return parse_instrument(str(text), "instrument file in the dataset").name if text else _NO_INSTRUMENT
