"""tables.py: the report's tables of integrals, peaks and wavelengths, with the truth beside where it is known."""

from collections.abc import Mapping, Sequence

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.reduce.integrals.hemispheres import zero_forty_five
from gonio.report.comparison import HEMISPHERES, measured_peaks, relative, short_name, word_for
from gonio.report.html_parts import fixed, number, paragraph, percent, signed_percent, table

_INTO = {"rho": "\u03c1 reflected", "tau": "\u03c4 transmitted"}
_POLE_DEG = 0.01
Known = Sequence[Mapping[str, float]]  # per distribution, see comparison.known_values; empty without a truth


def incident(d: Distribution) -> str:
    return f"{d.incident_theta_deg:.4g}\u00b0 / {d.incident_phi_deg:.4g}\u00b0"


def integrals(dataset: Dataset, known: Known) -> str:
    """Hemispherical values; the truth is taken over the same directions, so that what nobody saw is no error."""
    with_truth = any(known)
    with_masked = any(not d.measured.all() for d in dataset.distributions)
    with_counted = any("rho_counted" in d.integrals for d in dataset.distributions)
    rows = []
    for d, truth in zip(dataset.distributions, known, strict=True):
        for name in HEMISPHERES:
            front = (d.incident_theta_deg <= 90) == (name == "rho")
            share = d.integrals.get(f"measured_cosine_share_{'front' if front else 'back'}")
            if f"{name}_measured" not in d.integrals or not share:
                continue
            measured, there = d.integrals[f"{name}_measured"], truth.get(f"{name}_truth_measured")
            row = [*where(dataset, d), _INTO[name], fixed(measured, 4), number(d.integrals.get(f"{name}_u"), 2)]
            row += [percent(min(share, 1.0))]
            if with_counted:
                row += [fixed(d.integrals.get(f"{name}_counted"), 4), number(d.integrals.get(f"{name}_counted_u"), 2)]
            if with_truth:
                row += [fixed(there, 4), signed_percent(relative(measured, there))]
            if with_masked:
                estimate_u = number(d.integrals.get(f"{name}_estimate_u"), 2)
                row += [fixed(d.integrals.get(f"{name}_estimate"), 4), estimate_u]
            if with_truth:
                row += [fixed(truth.get(f"{name}_truth"), 4)]
            rows.append(row)
    if not rows:
        return ""
    simulated = any(word_for(d) == "simulated" for d in dataset.distributions)
    sum_of_points = "sum of points" if simulated else "measured"
    share_of = "share covered" if simulated else "measured share"
    head = [*where_head(dataset), "into", sum_of_points, "u (k = 1)", share_of]
    head += ["photons counted", "u (k = 1)"] if with_counted else []
    head += ["truth there", "difference"] if with_truth else []
    head += ["masked modelled", "u (k = 1)"] if with_masked else []
    head += ["whole truth"] if with_truth else []
    note = (
        f"{sum_of_points.capitalize()}: DSF times solid angle, added over these directions; {share_of}: of the "
        "cosine-weighted hemisphere. "
    )
    note += _what_u_holds(dataset, simulated)
    if with_counted:
        note += (
            " Photons counted: all that reached the hemisphere over all that were emitted. The sum of points differs "
            "from it where the points lie too far apart for the distribution's ridges and peaks."
        )
    if with_masked:
        note += (
            " Masked modelled: the same sum with a smooth model in masked and uncovered directions; worth nothing "
            "where a peak is masked."
        )
    if with_truth:
        note += (
            " Truth there: the convolved truth over exactly the measured directions; a lobe behind the detector's "
            "head is in neither. Whole truth: of the sample itself, over the whole hemisphere."
        )
    return table(head, rows, name_columns=(head.index("into"),)) + paragraph(note, "note")


def _what_u_holds(dataset: Dataset, simulated: bool) -> str:
    """One sentence on the column u, for what the dataset has."""
    if simulated:
        return (
            "u is the independent part only, noise of the points and of the reference beam; what comes of the points' "
            "finite number is not in it."
        )
    if all("rho" in d.budgets or "tau" in d.budgets for d in dataset.distributions):
        if any(d.effects for d in dataset.distributions):
            return "u is the combined standard uncertainty: noise and all effects of the budget below, quadrature too."
        return (
            "u holds noise, the reference beam and the finite number of points; what all points share (alignment, "
            "linearity, distances) is not known of this dataset."
        )
    return (
        "u is the independent part only, noise of the points and of the reference beam; what all points share "
        "(alignment, solid angles, linearity, delays) is not in it."
    )


def peaks(dataset: Dataset, known: Known) -> str:
    """Fitted peaks; the truth is fitted in the same way at the same points."""
    with_truth = any(known)
    found = [peak for d in dataset.distributions for peak in measured_peaks(d).values()]
    with_turns = any("turns" in peak for peak in found)
    rows = []
    for d, truth in zip(dataset.distributions, known, strict=True):
        for name, peak in measured_peaks(d).items():
            row = [*where(dataset, d), short_name(name)]
            row += [fixed(peak.get("theta_deg"), 3), _azimuth(peak), number(peak.get("height_per_sr"))]
            row += [_with_u(peak, "sigma_deg", 4), _with_u(peak, "integral", 5)]
            if with_turns:
                row += [_sampling(peak)]
            if with_truth:
                row += [number(truth.get(f"peak {name} direction_error_deg"), 2)]
                for field in ("sigma_deg", "integral"):
                    row += [signed_percent(relative(peak.get(field), truth.get(f"peak {name} {field}_truth")))]
            rows.append(row)
    if not rows:
        return ""
    head = [
        *where_head(dataset),
        "peak",
        "theta [\u00b0]",
        "phi [\u00b0]",
        "height [1/sr]",
        "sigma [\u00b0]",
        "integral",
    ]
    head += ["turns"] if with_turns else []
    head += ["direction off truth [\u00b0]", "sigma \u2212 truth", "integral \u2212 truth"] if with_truth else []
    note = (
        "Fit of a Gaussian on a plane ground; \u00b1 is one standard uncertainty. Sigma still holds what beam and "
        "aperture add; the integral is what stands above the ground. Of a peak that is no Gaussian, like the beam "
        "straight through, height and sigma are those of the fit, and the ground is that of the rim."
    )
    if with_turns:
        note += (
            " Turns: of the spiral across the full width at half maximum; with fewer than ten a peak is under-sampled."
        )
    if with_truth:
        note += " The truth is convolved with both and put through the same fit at the same directions and masks."
    return table(head, rows, name_columns=(head.index("peak"),)) + paragraph(note, "note")


def wavelengths(dataset: Dataset) -> str:
    """0:45 and reflectance per wavelength, incidence normal."""
    rows = []
    for d in dataset.distributions:
        if d.wavelength_nm is None or d.incident_theta_deg > 1:
            continue
        row = [f"{d.wavelength_nm:g} nm", fixed(zero_forty_five(d), 3), fixed(d.integrals.get("rho_measured"), 4)]
        outermost_deg = float(d.theta_deg[d.measured & (d.theta_deg <= 90.0)].max(initial=0.0))
        covered = min(d.integrals.get("rho_measured_share", np.nan), 1.0)
        rows.append([*row, f"{outermost_deg:.1f}\u00b0", percent(covered)])
    if not rows:
        return ""
    note = (
        "0:45 is pi times the mean BSDF within 2\u00b0 of theta = 45\u00b0, incidence normal. The reflectance is over "
        "the part of the hemisphere within reach of the points: nothing is added for the rest."
    )
    head = ["wavelength", "0:45", "\u03c1 over the covered part", "outermost point", "covered, cosine-weighted"]
    return table(head, rows) + paragraph(note, "note")


def _with_u(peak: Mapping[str, float], field: str, decimals: int) -> str:
    """A fitted value and, where it is known, its standard uncertainty."""
    u = peak.get(f"{field}_u")
    return fixed(peak.get(field), decimals) + ("" if u is None else f" \u00b1 {number(u, 1)}")


def _sampling(peak: Mapping[str, float]) -> str:
    """Turns per width, marked where they are too few."""
    return number(peak.get("turns"), 3) + (" under-sampled" if peak.get("undersampled") else "")


def _azimuth(peak: Mapping[str, float]) -> str:
    """phi in degrees, an en dash at the poles, where it says nothing."""
    from_pole = abs((peak.get("theta_deg", 0.0) + 90.0) % 180.0 - 90.0)
    return fixed(peak.get("phi_deg") if from_pole > _POLE_DEG else None, 3)


def where(dataset: Dataset, d: Distribution) -> list[str]:
    """First cells of a row: incident direction and, where there are several, channel."""
    return [incident(d), d.channel] if _several_channels(dataset) else [incident(d)]


def where_head(dataset: Dataset) -> list[str]:
    """Heads of the cells of `where`."""
    return ["incident", "channel"] if _several_channels(dataset) else ["incident"]


def _several_channels(dataset: Dataset) -> bool:
    return len({d.channel for d in dataset.distributions}) > 1
