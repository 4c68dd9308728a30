"""result_tables.py: tables of what else a distribution adds up to: regular and diffuse parts, cones, and coverage."""

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.report.budget import integral_words
from gonio.report.html_parts import number, paragraph, percent, signed_percent, table
from gonio.report.tables import where, where_head

_PARTS = ("rho_direct", "rho_diffuse", "tau_direct", "tau_diffuse", "openness", "haze")
_SIDES = ("front", "back")
_LEAST_SR = 1e-9


def parts(dataset: Dataset) -> str:
    """Regular and diffuse parts and biconical integrals, one row each, with combined uncertainty."""
    rows = []
    for d in dataset.distributions:
        cones = [name for name in d.integrals if name.startswith("cone ") and f"{name}_u" in d.integrals]
        for name in (*_PARTS, *cones):
            value, u = d.integrals.get(name), d.integrals.get(f"{name}_u")
            if value is None:
                continue
            relative = None if u is None or not value else u / abs(value)
            row = [*where(dataset, d), integral_words(name), number(value, 5), number(u, 2), percent(relative, 2)]
            rows.append([*row, _remark(d, name)])
    if not rows:
        return ""
    head = [*where_head(dataset), "part", "value", "u (k = 1)", "u / value", "how"]
    shown = table(head, rows, text_columns=(len(head) - 1,), name_columns=(head.index("part"),))
    if not any(name in d.integrals for d in dataset.distributions for name in _PARTS):
        return shown
    note = (
        "Direct: what leaves as the beam itself, mirrored or straight through, found by its own shape in a cone beside "
        "a smooth ground. Diffuse: the hemisphere less the direct part. Haze (ASTM D1003): share of the transmitted "
        "light that is scattered by more than 2.5\u00b0. Openness: direct transmittance at normal incidence."
    )
    return shown + paragraph(note, "note")


def coverage(dataset: Dataset) -> str:
    """What was measured of each hemisphere and what the finite number of points costs."""
    rows = []
    for d in dataset.distributions:
        for side in _SIDES:
            share = d.integrals.get(f"measured_share_{side}")
            if share is None or f"uncovered_sr_{side}" not in d.integrals:
                continue
            name = "rho" if (d.incident_theta_deg <= 90) == (side == "front") else "tau"
            corrected, plain = d.integrals.get(f"{name}_measured"), d.integrals.get(f"{name}_voronoi")
            moved = None if corrected is None or not plain else (corrected - plain) / plain
            rows.append(
                [
                    *where(dataset, d),
                    side,
                    _share(share),
                    _share(d.integrals.get(f"measured_cosine_share_{side}")),
                    _area(d.integrals.get(f"masked_sr_{side}")),
                    _area(d.integrals.get(f"uncovered_sr_{side}")),
                    number(d.integrals.get(f"{name}_quadrature"), 2),
                    signed_percent(moved, 4),
                ]
            )
    if not rows:
        return ""
    head = [
        *where_head(dataset),
        "hemisphere",
        "covered, of solid angle",
        "cosine-weighted",
        "masked [sr]",
        "uncovered [sr]",
        "quadrature u",
        "correction to cells",
    ]
    note = (
        "Masked: cells of points that hold no value. Uncovered: farther than the reach from any point, or without a "
        "cell. Quadrature: a sum over cells is high on a peak and linear interpolation between the points twice as "
        "high, so twice the one less the other is taken, and their difference is its standard uncertainty; the last "
        "column is what that changed."
    )
    return table(head, rows, name_columns=(head.index("hemisphere"),)) + paragraph(note, "note")


def _share(share: float | None) -> str:
    """Of a whole that sums over cells may exceed by a trifle."""
    return percent(None if share is None else min(share, 1.0), 2)


def _area(area_sr: float | None) -> str:
    """What is less than rounding of the cells leaves is nothing."""
    return "0" if area_sr is not None and area_sr < _LEAST_SR else number(area_sr, 3)


def _remark(d: Distribution, name: str) -> str:
    half_angle, off = d.integrals.get(f"{name}_half_angle_deg"), d.integrals.get(f"{name}_off_deg")
    words = [] if half_angle is None else [f"fit in a cone of \u00b1{half_angle:.3g}\u00b0"]
    if off is not None:
        words.append(
            f"{off:.2g}\u00b0 off the ideal direction" if off >= 1e-3 else "in the ideal direction to 0.001\u00b0"
        )
    share = d.integrals.get(f"{name}_measured_share")
    return ", ".join(words) or ("" if share is None else f"{100 * share:.1f} % of the cone covered")
