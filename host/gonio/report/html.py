"""html.py: writes the report of a dataset: one self-contained HTML file, no network, images inside."""

import platform
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.formats import atomic
from gonio.formats.klems_matrices import BANDS, PROCESSES, SIDES, build
from gonio.reduce.integrals.truth_beside import KnownTruth
from gonio.report import figures, tables
from gonio.report.comparison import known_values, word_for
from gonio.report.controller import controller
from gonio.report.html_parts import (
    bullets,
    facts,
    figure,
    flatten,
    folded,
    number,
    paragraph,
    section,
    table,
)
from gonio.report.style import CSS
from gonio.units.errors import GonioError

_MANY = 6  # more distributions than this are folded away and drawn coarser
_COUNTERS = "counters"
_LOST = {
    "samples_lost": "Samples lost",
    "strobes_lost": "Strobe edges lost",
    "sync_echoes_lost": "SYNC echoes lost",
    "tpdo_missing": "Positions missing",
    "link_gap_frames": "Link frames lost",
}


def write_report(dataset: Dataset, path: Path, *, truth: KnownTruth | None = None) -> None:
    """Writes the report, whole or not at all. `truth` (closed form, convolved) is shown beside the measurement."""
    atomic.write_bytes(path, render(dataset, truth).encode("utf-8"))


def render(dataset: Dataset, truth: KnownTruth | None = None) -> str:
    """The HTML document."""
    name = dataset.sample_name or "unnamed sample"
    known = [known_values(d, truth) for d in dataset.distributions]
    sections = [
        ("Integrals", tables.integrals(dataset, known)),
        ("Peaks", tables.peaks(dataset, known)),
        ("Wavelengths", tables.wavelengths(dataset)),
        ("Scattering", _distributions(dataset, truth)),
        ("Path", _path(dataset)),
        ("Reference beam", _beam(dataset)),
        ("Lost and masked", _losses(dataset)),
        ("Controller", controller(dataset)),
        ("Klems matrices", _klems(dataset)),
        ("Provenance", _provenance(dataset)),
    ]
    present = [(title, body) for title, body in sections if body]
    links = "".join(f'<a href="#{_anchor(title)}">{escape(title)}</a>' for title, _ in present)
    body = "".join(section(_anchor(title), title, part) for title, part in present)
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(name)} \u2013 BSDF report</title><style>{CSS}</style></head><body>"
        f'<header><div class="eyebrow">gonio \u00b7 BSDF report</div><h1>{escape(name)}</h1>{_head(dataset, truth)}'
        f"<nav>{links}</nav></header><main>{body}</main>"
        "<footer>Angles: theta 0\u2013180\u00b0 from the front normal, phi 0\u2013360\u00b0 from +x towards +y, "
        "away from the sample. DSF = scattered radiant intensity over incident power [1/sr]; "
        f"BSDF = DSF / |cos theta|. Written by gonio {escape(_own_version())}.</footer></body></html>\n"
    )


def _head(dataset: Dataset, truth: KnownTruth | None) -> str:
    parts = dataset.distributions
    kinds = list(dict.fromkeys(word_for(d) for d in parts)) or ["measured"]
    points = sum(len(d.theta_deg) for d in parts)
    used = sum(int(np.count_nonzero(d.measured)) for d in parts)
    thetas = sorted({round(d.incident_theta_deg, 2) for d in parts})
    lead = f"{' and '.join(kinds).capitalize()} at {points:,} points, {used:,} of them used."
    if truth is not None:
        lead += " The sample's scattering is known in closed form and is shown beside."
    declared = {
        "Incident theta": ", ".join(f"{t:g}\u00b0" for t in thetas) or "none",
        "Channels": ", ".join(sorted({d.channel for d in parts})) or "none",
        "Front faces": dataset.front_faces,
        "Symmetry, declared": dataset.symmetry,
        "Polarisation": dataset.polarisation,
        "Thickness": "not stated" if dataset.thickness_mm is None else f"{dataset.thickness_mm:g} mm",
    }
    if dataset.manufacturer:
        declared["Manufacturer"] = dataset.manufacturer
    return paragraph(lead, "lead") + facts(declared)


def _distributions(dataset: Dataset, truth: KnownTruth | None) -> str:
    many = len(dataset.distributions) > _MANY
    dpi = 72 if many else 110
    parts = []
    for d in dataset.distributions:
        masked = "" if d.measured.all() else " Hatched: masked."
        maps = figure(
            figures.polar_maps(d, dpi),
            f"Polar maps of the DSF for incidence {tables.incident(d)}, {d.channel}",
            f"DSF, logarithmic; each pixel shows the nearest point. White: nothing {word_for(d)}.{masked}",
        )
        plane = figure(
            figures.plane_figure(d, truth, dpi),
            f"Scatter plane for incidence {tables.incident(d)}, {d.channel}",
            f"Plane of incidence, {word_for(d)} points only."
            + (
                ""
                if truth is None
                else f" Below: {word_for(d)} over truth, less one, at the points themselves; dark: their means per "
                "degree."
            ),
        )
        title = f"Incident {tables.incident(d)}, {d.channel}: {len(d.theta_deg):,} points"
        parts.append(folded(title, maps, plane) if many else f"<h3>{escape(title)}</h3>{maps}{plane}")
    return "".join(parts)


def _path(dataset: Dataset) -> str:
    parts: list[str] = []
    for d in dataset.distributions:
        uri = figures.path_figure(d)
        if uri is not None:
            drawn = figure(
                uri, f"Detector path for incidence {tables.incident(d)}", "Path of the detector in flying order."
            )
            parts.append(folded(f"Incident {tables.incident(d)}, {d.channel}", drawn, opened=not parts))
    return "".join(parts)


def _beam(dataset: Dataset) -> str:
    beam = dataset.beam
    if beam is None or not len(beam.theta_deg):
        return ""
    power = {(d.p_i, d.p_i_u_rel) for d in dataset.distributions}
    lines = [
        f"P_i = {number(p, 6)} (signal \u00b7 sr), relative standard uncertainty {number(u, 2)} (independent part)"
        for p, u in sorted(power)
    ]
    done = "scanned" if word_for(beam) == "measured" else "simulated"
    caption = f"Signal of the unobstructed beam, {done} without the sample, over the angle from its axis."
    return bullets(lines) + figure(figures.beam_figure(beam), "Profile of the reference beam", caption)


def _losses(dataset: Dataset) -> str:
    parts = []
    counters = dict(flatten(dataset.provenance.get(_COUNTERS, {})))
    if counters:
        parts.append(facts({title: counters[name] for name, title in _LOST.items() if name in counters}))
        parts.append(folded("All counters", table(["counter", "count"], list(counters.items()))))
    rows = []
    for d in dataset.distributions:
        counts = [(flag, int(np.count_nonzero(d.flags & flag))) for flag in PointFlag if flag]
        named = [f"{(flag.name or '').lower().replace('_', ' ')} {n:,}" for flag, n in counts if n]
        rows.append(
            [
                tables.incident(d),
                d.channel,
                f"{len(d.theta_deg):,}",
                f"{np.count_nonzero(d.measured):,}",
                "; ".join(named),
            ]
        )
    parts.append(table(["incident", "channel", "points", "used", "flags"], rows, text_columns=(4,)))
    return "".join(parts)


def _klems(dataset: Dataset) -> str:
    try:
        built = build(dataset)
    except GonioError as error:
        return paragraph(f"No WINDOW file can be written from this dataset as it is: {error}.", "note")
    rows = []
    for band in BANDS:
        if band not in built.channel_of:
            continue
        for process in PROCESSES:
            for side in SIDES:
                measured, rotated, _, zero = built.column_counts(band, process, side)
                rows.append([f"{band} {process} {side}", str(measured), str(rotated), str(zero)])
    kinds = dict.fromkeys(word_for(d) for d in dataset.distributions)
    head = ["matrix", f"columns {' or '.join(kinds)}", "rotated (isotropic)", "zero"]
    note = f"{built.basis.name}, {built.basis.size} incident columns each, as `gonio export` writes without filling."
    return table(head, rows) + bullets(built.remarks()) + paragraph(note, "note")


def _provenance(dataset: Dataset) -> str:
    rest = {key: value for key, value in dataset.provenance.items() if key != _COUNTERS}
    own = [("gonio", _own_version()), ("Python", platform.python_version()), ("numpy", np.__version__)]
    rows = [*flatten(rest), *((f"this report: {name}", value) for name, value in own)]
    return folded(
        "Settings, versions, hashes, corrections",
        table(["what", "value"], rows, text_columns=(1,)),
        opened=len(rows) < 25,
    )


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _own_version() -> str:
    try:
        return version("gonio")
    except PackageNotFoundError:
        return "(not installed)"
