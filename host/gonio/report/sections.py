"""sections.py: the report's sections on what was done to the data: corrections, merging, losses, provenance."""

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.report import tables
from gonio.report.html_parts import bullets, facts, flatten, folded, number, paragraph, subtitle, table

_COUNTERS = "counters"
_LOST = {
    "samples_lost": "Samples lost",
    "strobes_lost": "Strobe edges lost",
    "sync_echoes_lost": "SYNC echoes lost",
    "tpdo_missing": "Positions missing",
    "link_gap_frames": "Link frames lost",
}
_TOLD_APART = {_COUNTERS, "corrections", "merge"}  # have a section of their own


def corrections(dataset: Dataset) -> str:
    """The corrections in their order as recorded: name, whether applied, what it does, parameters; older datasets and
    imported ones hold a sentence each."""
    recorded = dataset.provenance.get("corrections", [])
    if not isinstance(recorded, list) or not recorded:
        return ""
    if not any(isinstance(step, Mapping) for step in recorded):
        return bullets(str(step) for step in recorded)
    rows = []
    for entry in recorded:
        step = entry if isinstance(entry, Mapping) else {"what": entry}
        parameters = "; ".join(f"{name} = {value}" for name, value in flatten(step.get("parameters", {})) if name)
        state = "applied" if step.get("applied", True) else "switched off"
        name = str(step.get("name", "")).replace("_", " ")
        rows.append([name, state, str(step.get("what", "")), parameters])
    return table(["correction", "", "what", "parameters"], rows, text_columns=(1, 2, 3))


def merged(dataset: Dataset) -> str:
    """How a merged dataset came about: its sources, how they agree where they overlap, the seams, the outliers."""
    told = dataset.provenance.get("merge")
    if not isinstance(told, Mapping):
        return ""
    own_provenance = [
        folded(f"Provenance of {source.get('name', '')}", table(["what", "value"], flatten(source["provenance"])))
        for source in told.get("sources", ())
        if isinstance(source, Mapping) and source.get("provenance")
    ]
    note = (
        "Overlap: where two passes measured the same directions, mean ratio and difference with what they do not "
        "share as uncertainty. Seam: where one ends and the other begins, logarithm of the ratio along the border."
    )
    return _statistics(told, "") + paragraph(note, "note") + "".join(own_provenance)


def _statistics(told: Mapping[str, Any], title: str) -> str:
    """A mapping as facts and tables: lists of mappings are tables, mappings that hold such are titled parts."""
    plain: dict[str, str] = {}
    parts: list[str] = []
    for key, value in told.items():
        name = str(key).replace("_", " ")
        rows = [item for item in value if isinstance(item, Mapping)] if isinstance(value, list | tuple) else []
        if any(_nested(row) for row in rows):
            parts += [_statistics(row, f"{title}{row.get('where', name)}: ") for row in rows]
        elif rows:
            # What a row holds as a mapping, a source's own provenance, has its place elsewhere.
            columns = list(dict.fromkeys(str(k) for row in rows for k, v in row.items() if not isinstance(v, Mapping)))
            cells = [[_cell(row.get(column)) for column in columns] for row in rows]
            heads = [column.replace("_per_sr", " [1/sr]").replace("_", " ") for column in columns]
            words = f"{title}{name}"
            parts.append(subtitle(words[0].upper() + words[1:]) + table(heads, cells, wide=True))
        elif isinstance(value, Mapping):
            parts.append(_statistics(value, f"{title}{name}: ") if value else "")
        elif value not in (None, [], "", ()):
            plain[name] = _cell(value)
    return (facts(plain) if plain else "") + "".join(parts)


def _nested(row: Mapping[str, Any]) -> bool:
    """Whether a row has tables of its own."""
    return any(isinstance(v, list | tuple) and any(isinstance(item, Mapping) for item in v) for v in row.values())


def losses(dataset: Dataset) -> str:
    """Counters of the scan and flags of the points."""
    parts = []
    counters = dict(flatten(dataset.provenance.get(_COUNTERS, {})))
    if counters:
        parts.append(facts({title: counters[name] for name, title in _LOST.items() if name in counters}))
        parts.append(folded("All counters", table(["counter", "count"], list(counters.items()))))
    rows = []
    for d in dataset.distributions:
        counts = [(flag, int(np.count_nonzero(d.flags & flag))) for flag in PointFlag if flag]
        named = [f"{(flag.name or '').lower().replace('_', ' ')} {n:,}" for flag, n in counts if n]
        used = f"{np.count_nonzero(d.measured):,}"
        rows.append([tables.incident(d), d.channel, f"{len(d.theta_deg):,}", used, "; ".join(named)])
    parts.append(table(["incident", "channel", "points", "used", "flags"], rows, text_columns=(4,)))
    notes = dataset.provenance.get("notes")
    if isinstance(notes, list) and notes:
        parts.append(paragraph("Notes of the reduction:") + bullets(str(note) for note in notes))
    return "".join(parts)


def provenance(dataset: Dataset) -> str:
    """Everything else that the dataset says about itself, and what wrote this report."""
    rest = {key: value for key, value in dataset.provenance.items() if key not in _TOLD_APART}
    own = [("gonio", own_version()), ("Python", platform.python_version()), ("numpy", np.__version__)]
    rows = [*flatten(rest), *((f"this report: {name}", value) for name, value in own)]
    shown = table(["what", "value"], rows, text_columns=(1,))
    return folded("Settings, versions, hashes", shown, opened=len(rows) < 25)


def own_version() -> str:
    """Of the installed package."""
    try:
        return version("gonio")
    except PackageNotFoundError:
        return "(not installed)"


def _cell(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "\u2013"}[value]
    if isinstance(value, float):
        return number(value, 4)
    if isinstance(value, list | tuple):
        return ", ".join(_cell(item) for item in value)
    return str(value)
