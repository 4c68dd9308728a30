"""html.py: writes the report of a dataset: one self-contained HTML file, no network, images inside."""

import platform
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.formats import atomic
from gonio.formats.klems_matrices import BANDS, PROCESSES, SIDES, build
from gonio.report import figures
from gonio.report.covered import covered_reflectance, zero_forty_five
from gonio.report.html_parts import (
    bullets,
    facts,
    figure,
    fixed,
    flatten,
    folded,
    number,
    paragraph,
    percent,
    section,
    signed_percent,
    table,
)
from gonio.report.style import CSS
from gonio.report.truth import DsfTruth, expected_peaks, measured_peaks
from gonio.units.errors import GonioError

_MANY = 6  # more distributions than this are folded away and drawn coarser
_COUNTERS = "counters"
_COARSE_SHARE = 1.01  # of the cosine-weighted hemisphere; more is no coverage but coarse cells


def write_report(dataset: Dataset, path: Path, *, truth: DsfTruth | None = None) -> None:
    """Writes the report, whole or not at all. `truth` (closed form, convolved) is shown beside the measurement."""
    atomic.write_bytes(path, render(dataset, truth).encode("utf-8"))


def render(dataset: Dataset, truth: DsfTruth | None = None) -> str:
    """The HTML document."""
    name = dataset.sample_name or "unnamed sample"
    sections = [
        ("Integrals", _integrals(dataset, truth)),
        ("Peaks", _peaks(dataset, truth)),
        ("Wavelengths", _wavelengths(dataset)),
        ("Scattering", _distributions(dataset, truth)),
        ("Path", _path(dataset)),
        ("Reference beam", _beam(dataset)),
        ("Lost and masked", _losses(dataset)),
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


def _head(dataset: Dataset, truth: DsfTruth | None) -> str:
    parts = dataset.distributions
    simulated = any(np.any(d.flags & PointFlag.SIMULATED) for d in parts)
    kind = "Computed" if simulated else "Measured"
    points = sum(len(d.theta_deg) for d in parts)
    used = sum(int(np.count_nonzero(d.measured)) for d in parts)
    thetas = sorted({round(d.incident_theta_deg, 2) for d in parts})
    lead = f"{kind} with {points:,} points, {used:,} of them used."
    if truth is not None:
        lead += " The sample's scattering is known in closed form and is shown beside the measurement."
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


def _integrals(dataset: Dataset, truth: DsfTruth | None) -> str:
    rows = []
    for d in dataset.distributions:
        known = {} if truth is None else truth.integrals(d.incident_theta_deg, d.incident_phi_deg)
        for name, behind in (("rho", False), ("tau", True)):
            if name not in d.integrals:
                continue
            side = "front" if (d.incident_theta_deg <= 90) != behind else "back"
            share = d.integrals.get(f"measured_cosine_share_{side}")
            if not share:
                continue
            value, u = d.integrals[name], d.integrals.get(f"{name}_u")
            row = [
                _incident(d),
                d.channel,
                {"rho": "\u03c1 reflected", "tau": "\u03c4 transmitted"}[name],
                fixed(value, 4),
            ]
            row += [fixed(u, 4), percent(share), fixed(d.integrals.get(f"{name}_filled"), 4)]
            if truth is not None:
                reference = known.get(name)
                row += [fixed(reference, 4), signed_percent(value / reference - 1 if reference else None)]
            rows.append(row)
    if not rows:
        return ""
    head = ["incident", "channel", "into", "value", "u (k = 1)", "measured share", "of it filled"]
    head += ["truth", "difference"] if truth is not None else []
    note = (
        "Sum of DSF times solid angle over the hemisphere. The measured share is that of the cosine-weighted one; "
        "\u201cfilled\u201d is the part of the value that masked directions took from their nearest neighbour. "
        "What lies outside both counts as zero."
    )
    shares = [v for d in dataset.distributions for k, v in d.integrals.items() if k.startswith("measured_cosine_share")]
    coarse = max(shares, default=0.0) > _COARSE_SHARE
    remark = paragraph(
        "Some shares exceed 100 %: the points are so sparse that the outermost cells reach the horizon, and these sums "
        "are too high by about as much. The reflectance over the covered part, where given, is free of this.",
        "warn",
    )
    return table(head, rows) + paragraph(note, "note") + (remark if coarse else "")


def _peaks(dataset: Dataset, truth: DsfTruth | None) -> str:
    rows = []
    for d in dataset.distributions:
        known = {} if truth is None else expected_peaks(truth, d.incident_theta_deg, d.incident_phi_deg)
        for name, peak in measured_peaks(d).items():
            row = [_incident(d), d.channel, name, fixed(peak.get("theta_deg"), 3), fixed(peak.get("phi_deg"), 3)]
            row += [number(peak.get("height_per_sr")), fixed(peak.get("sigma_deg"), 4), fixed(peak.get("integral"), 5)]
            if truth is not None:
                expected = known.get(name)
                row += (
                    ["\u2013"] * 2
                    if expected is None
                    else [
                        signed_percent(peak["sigma_deg"] / expected.sigma_deg - 1),
                        signed_percent(peak["integral"] / expected.integral - 1),
                    ]
                )
            rows.append(row)
    if not rows:
        return ""
    head = [
        "incident",
        "channel",
        "peak",
        "theta [\u00b0]",
        "phi [\u00b0]",
        "height [1/sr]",
        "sigma [\u00b0]",
        "integral",
    ]
    head += ["sigma \u2212 truth", "integral \u2212 truth"] if truth is not None else []
    note = "Gaussian on a plane ground. Sigma still holds what beam and aperture add; the truth is convolved with both."
    return table(head, rows) + paragraph(note, "note")


def _wavelengths(dataset: Dataset) -> str:
    rows = []
    for d in dataset.distributions:
        if d.wavelength_nm is None or d.incident_theta_deg > 1:
            continue
        covered = covered_reflectance(d)
        row = [f"{d.wavelength_nm:g} nm", fixed(zero_forty_five(d), 3)]
        rows.append([*row, fixed(covered.value, 4), f"{covered.limit_deg:.1f}\u00b0", percent(covered.share)])
    if not rows:
        return ""
    note = (
        "0:45 is pi times the mean BSDF within 2\u00b0 of theta = 45\u00b0, incidence normal. The reflectance is over "
        "the covered part of the hemisphere, from the normal to the outermost point: nothing is added for the rest."
    )
    head = ["wavelength", "0:45", "\u03c1 over the covered part", "covered up to", "covered, cosine-weighted"]
    return table(head, rows) + paragraph(note, "note")


def _distributions(dataset: Dataset, truth: DsfTruth | None) -> str:
    many = len(dataset.distributions) > _MANY
    dpi = 72 if many else 110
    parts = []
    for d in dataset.distributions:
        masked = "" if d.measured.all() else " Hatched: masked."
        maps = figure(
            figures.polar_maps(d, dpi),
            f"Polar maps of the DSF for incidence {_incident(d)}, {d.channel}",
            f"DSF, logarithmic; each pixel shows the nearest point. White: nothing measured.{masked}",
        )
        plane = figure(
            figures.plane_figure(d, truth, dpi),
            f"Scatter plane for incidence {_incident(d)}, {d.channel}",
            "Plane of incidence, measured points only."
            + ("" if truth is None else " Below: measured over truth, less one, at the points themselves."),
        )
        title = f"Incident {_incident(d)}, {d.channel}: {len(d.theta_deg):,} points"
        parts.append(folded(title, maps, plane) if many else f"<h3>{escape(title)}</h3>{maps}{plane}")
    return "".join(parts)


def _path(dataset: Dataset) -> str:
    parts: list[str] = []
    for d in dataset.distributions:
        uri = figures.path_figure(d)
        if uri is not None:
            drawn = figure(uri, f"Detector path for incidence {_incident(d)}", "Path of the detector in flying order.")
            parts.append(folded(f"Incident {_incident(d)}, {d.channel}", drawn, opened=not parts))
    return "".join(parts)


def _beam(dataset: Dataset) -> str:
    beam = dataset.beam
    if beam is None or not len(beam.theta_deg):
        return ""
    power = {(d.p_i, d.p_i_u_rel) for d in dataset.distributions}
    lines = [
        f"P_i = {number(p, 6)} (signal \u00b7 sr), relative standard uncertainty {percent(u, 3)}"
        for p, u in sorted(power)
    ]
    caption = "Signal of the unobstructed beam, scanned without the sample, over the angle from its axis."
    return bullets(lines) + figure(figures.beam_figure(beam), "Profile of the reference beam", caption)


def _losses(dataset: Dataset) -> str:
    parts = []
    counters = flatten(dataset.provenance.get(_COUNTERS, {}))
    if counters:
        parts.append(table(["counter", "count"], counters))
    rows = []
    for d in dataset.distributions:
        counts = [(flag, int(np.count_nonzero(d.flags & flag))) for flag in PointFlag if flag]
        named = [f"{(flag.name or '').lower().replace('_', ' ')} {n:,}" for flag, n in counts if n]
        rows.append(
            [_incident(d), d.channel, f"{len(d.theta_deg):,}", f"{np.count_nonzero(d.measured):,}", "; ".join(named)]
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
    head = ["matrix", "columns measured", "rotated (isotropic)", "zero"]
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


def _incident(d: Distribution) -> str:
    return f"{d.incident_theta_deg:.4g}\u00b0 / {d.incident_phi_deg:.4g}\u00b0"


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _own_version() -> str:
    try:
        return version("gonio")
    except PackageNotFoundError:
        return "(not installed)"
