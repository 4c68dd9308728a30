"""html.py: writes the report of a dataset: one self-contained HTML file, no network, images inside."""

from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.formats import atomic
from gonio.formats.window.matrices import BANDS, PROCESSES, SIDES, build
from gonio.reduce.integrals.truth_beside import KnownTruth
from gonio.report import (
    lobe,
    lobe_script,
    path_figure,
    plane_figure,
    polar_map,
    result_tables,
    sections,
    tables,
    uncertainty_map,
)
from gonio.report.beam_figure import beam_figure
from gonio.report.budget_html import uncertainty
from gonio.report.comparison import known_values, word_for
from gonio.report.controller import controller
from gonio.report.drawing import DPI, Half
from gonio.report.html_parts import bullets, facts, figure, folded, number, paragraph, section, subtitle, table
from gonio.report.plane_profile import plane_profile
from gonio.report.polar_grid import Picture, hemisphere_pictures
from gonio.report.style import CSS
from gonio.units.errors import GonioError

_MANY = 6  # more distributions than this are folded away and drawn coarser
_COARSE_DPI = 80
_MOST_LOBES = 24  # distributions with a lobe and a map of the uncertainty: the page stays small


def write_report(dataset: Dataset, path: Path, *, truth: KnownTruth | None = None) -> None:
    """Writes the report, whole or not at all. `truth` (closed form, convolved) is shown beside the measurement."""
    atomic.write_bytes(path, render(dataset, truth).encode("utf-8"))


def render(dataset: Dataset, truth: KnownTruth | None = None) -> str:
    """The HTML document."""
    name = dataset.sample_name or "unnamed sample"
    known = [known_values(d, truth) for d in dataset.distributions]
    bodies = [
        ("Integrals", tables.integrals(dataset, known) + result_tables.coverage(dataset)),
        ("Parts and cones", result_tables.parts(dataset)),
        ("Peaks", tables.peaks(dataset, known)),
        ("Wavelengths", tables.wavelengths(dataset)),
        ("Scattering", _distributions(dataset, truth)),
        ("Uncertainty", uncertainty(dataset)),
        ("Path", _path(dataset)),
        ("Reference beam", _beam(dataset)),
        ("Corrections", sections.corrections(dataset)),
        ("Merged", sections.merged(dataset)),
        ("Lost and masked", sections.losses(dataset)),
        ("Controller", controller(dataset)),
        ("Klems matrices", _klems(dataset)),
        ("Provenance", sections.provenance(dataset)),
    ]
    present = [(title, body) for title, body in bodies if body]
    links = "".join(f'<a href="#{_anchor(title)}">{escape(title)}</a>' for title, _ in present)
    script = lobe_script.script(lobe.colour_table()) if any("<canvas" in part for _, part in present) else ""
    body = "".join(section(_anchor(title), title, part) for title, part in present)
    header = (
        f'<header><div class="eyebrow">gonio \u00b7 BSDF report</div><h1>{escape(name)}</h1>{_head(dataset, truth)}'
        f"<nav>{links}</nav></header>"
    )
    return page(f"{name} \u2013 BSDF report", f"{header}<main>{body}</main>", script)


def page(title: str, body: str, script: str = "") -> str:
    """The document around header and main part (HTML), with the style sheet; `title` is plain text."""
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{escape(title)}</title><style>{CSS}</style></head><body>{body}"
        "<footer>Angles: theta 0\u2013180\u00b0 from the front normal, phi 0\u2013360\u00b0 from +x towards +y, "
        "away from the sample. DSF = scattered radiant intensity over incident power [1/sr]; "
        f"BSDF = DSF / |cos theta|. Written by gonio {escape(sections.own_version())}.</footer>{script}</body></html>\n"
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
    """Per incident direction: polar maps, the scatter plane, the lobe to turn, maps of the uncertainty."""
    many = len(dataset.distributions) > _MANY
    dpi = _COARSE_DPI if many else DPI
    parts = []
    for number_, d in enumerate(dataset.distributions):
        title = f"Incident {tables.incident(d)}, {d.channel}: {len(d.theta_deg):,} points"
        pictures = hemisphere_pictures(d)
        if np.isnan(d.p_i):
            raw = _raw_map(d, pictures, dpi)
            parts.append(folded(title, raw) if many else subtitle(title) + raw)
            continue
        shown = [_maps(d, pictures, dpi), _plane(d, truth, dpi)]
        if number_ < _MOST_LOBES:
            shown += [_lobe(d), _uncertainty_map(d, pictures, opened=not many and number_ == 0)]
        parts.append(folded(title, *shown) if many else subtitle(title) + "".join(shown))
    return "".join(parts)


def _maps(d: Distribution, pictures: dict[Half, Picture], dpi: int) -> str:
    scale = polar_map.dsf_scale(d)
    masked = "" if d.measured.all() else " Hatched: masked."
    return figure(
        polar_map.polar_maps(d, pictures, scale, dpi),
        f"Polar maps of the DSF for incidence {tables.incident(d)}, {d.channel}",
        f"DSF, logarithmic; each pixel shows the nearest point. White: nothing {word_for(d)}.{masked}"
        + polar_map.scale_words(scale),
    )


def _raw_map(d: Distribution, pictures: dict[Half, Picture], dpi: int) -> str:
    """Of points that nothing has normalised: their signal in its own unit."""
    signal = replace(d, dsf_per_sr=d.signal)
    scale = polar_map.dsf_scale(signal)
    return figure(
        polar_map.polar_maps(signal, pictures, scale, dpi, f"signal  [{d.signal_unit}]"),
        f"Polar maps of the signal for incidence {tables.incident(d)}, {d.channel}",
        "Raw signal, logarithmic; each pixel shows the nearest point. It is no DSF until a scan of the free beam or a "
        f"declared P_i normalises it. White: nothing measured.{polar_map.scale_words(scale)}",
    )


def _plane(d: Distribution, truth: KnownTruth | None, dpi: int) -> str:
    profile = plane_profile(d)
    drawn = plane_figure.plane_figure(d, truth, dpi, profile)
    if drawn is None:
        return ""
    words = word_for(d).capitalize()
    caption = (
        f"Plane of incidence: {words.lower()} points within {profile.band_deg:.2g}\u00b0 of it, means over 0.1\u00b0. "
    )
    if profile.masked_deg.size:
        caption += "Grey: masked. "
    below = int(np.count_nonzero(profile.dsf_per_sr <= 0))
    if below:
        caption += f"Hollow triangles: {below:,} means at or below zero, which a logarithm cannot show. "
    if truth is not None:
        caption += f"Below: {words.lower()} over truth, less one, and the k = 2 band about zero."
    elif d.effects:
        caption += "Below: expanded uncertainty in percent of the DSF, combined (line) and of the noise alone (dots)."
    else:
        caption += "Below: expanded uncertainty in percent of the DSF, of the noise alone."
    return figure(drawn, f"Scatter plane for incidence {tables.incident(d)}, {d.channel}", caption)


def _lobe(d: Distribution) -> str:
    mesh = lobe.build_mesh(d)
    if mesh is None:
        return ""
    caption = (
        "The DSF as a body: distance from the centre and colour are its logarithm, from "
        f"{mesh.floor_per_sr:.1g} in the centre to {mesh.top_per_sr:.3g} 1/sr. Drag to turn, point to read a value. "
        "Dashed circles: decades in the plane of incidence. Holes: masked, or no point near."
    )
    shown = lobe.canvas(d, mesh, f"Body of the DSF for incidence {tables.incident(d)}, {d.channel}")
    return f"<figure>{shown}<figcaption>{escape(caption)}</figcaption></figure>"


def _uncertainty_map(d: Distribution, pictures: dict[Half, Picture], *, opened: bool) -> str:
    by_cause = uncertainty_map.dominance(d) if d.effects else None
    uri = uncertainty_map.uncertainty_map(d, pictures, by_cause)
    if uri is None:
        return ""
    caption = "Relative standard uncertainty (k = 1) of the DSF at the nearest point, "
    if by_cause is None:
        caption += "independent part alone."
    else:
        caption += (
            "noise and all effects combined. Below: the systematic effect that contributes most, with its share of "
            f"the covered solid angle. On {100 * by_cause.noise_share:.3g} % of it the noise of a single point exceeds "
            "all effects together; in sums it averages out, and they do not."
        )
    drawn = figure(uri, f"Maps of the uncertainty for incidence {tables.incident(d)}, {d.channel}", caption)
    return folded("Map of the uncertainty", drawn, opened=opened)


def _path(dataset: Dataset) -> str:
    parts: list[str] = []
    for d in dataset.distributions:
        uri = path_figure.path_figure(d)
        if uri is not None:
            by = "path" if d.paths and len(d.path) == len(d.theta_deg) else "time"
            caption = f"Path of the detector, coloured by {by}; marks: masked points by their reason."
            drawn = figure(uri, f"Detector path for incidence {tables.incident(d)}", caption)
            parts.append(folded(f"Incident {tables.incident(d)}, {d.channel}", drawn, opened=not parts))
    return "".join(parts)


def _beam(dataset: Dataset) -> str:
    beam = dataset.beam
    if beam is None or not len(beam.theta_deg):
        return ""
    power = {(d.p_i, d.p_i_u_rel, d.signal_unit) for d in dataset.distributions}
    lines = [
        f"P_i = {number(p, 6)} {unit} \u00b7 sr, relative standard uncertainty {number(u, 2)} (independent part)"
        for p, u, unit in sorted(power)
    ]
    closure = beam.integrals.get("closure")
    if closure is not None:
        lines.append(
            f"Closure: the beam's own points and cells give {closure:.6f} of P_i, u = "
            f"{number(beam.integrals.get('closure_u'), 2)}"
        )
    done = "scanned" if word_for(beam) == "measured" else "simulated"
    caption = f"Signal of the unobstructed beam, {done} without the sample, over the angle from its axis."
    return bullets(lines) + figure(beam_figure(beam), "Profile of the reference beam", caption)


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


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")
