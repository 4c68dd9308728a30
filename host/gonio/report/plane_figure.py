"""plane_figure.py: the scatter plane over decades with its error band, and what the decades hide, enlarged below."""

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.integrals.truth_beside import KnownTruth
from gonio.report.comparison import word_for
from gonio.report.drawing import (
    ACCENT,
    DPI,
    HALVES,
    INK,
    MASK_GREY,
    SECOND,
    STYLE,
    WIDTH_IN,
    Half,
    data_uri,
    log_ticks,
    new_figure,
)
from gonio.report.plane_profile import FloatArray, PlaneProfile, folded_deg, plane_directions, plane_profile

K = 2.0  # coverage factor of every band drawn
_OUTER, _INNER = 0.22, 0.42  # opacity of the combined band and of the independent one
_LEFT_IN, _GAP_IN, _RIGHT_IN = 0.72, 0.36, 0.14
_SPARSE = 300  # fewer bins than this get a dot each


def plane_figure(
    d: Distribution, truth: KnownTruth | None, dpi: int = DPI, profile: PlaneProfile | None = None
) -> str | None:
    """Both sides of the scatter plane as a data URI, None without a point in it. Above: DSF on a log axis, k = 2 band.
    Below: with a truth the deviation from it in the band, without one the expanded uncertainty itself."""
    profile = profile or plane_profile(d)
    if not len(profile.angle_deg):
        return None
    behind = np.abs(profile.angle_deg) > 90
    sides: list[Half] = [s for s in HALVES if np.any(behind == (s == "back"))]
    with mpl.rc_context(STYLE):
        figure = new_figure(4.5)
        upper, lower = side_panels(figure, len(sides))
        for axes, below, side in zip(upper, lower, sides, strict=True):
            mine = on_side(profile, side)
            draw_profile(axes, mine, ACCENT, word_for(d))
            if truth is None:
                _draw_uncertainty(below, mine)
            else:
                _draw_truth(axes, d, truth, side)
                _draw_deviation(below, d, truth, profile, behind == (side == "back"))
            axes.set_title(side_name(d, side))
        limits = decades_shown(profile.dsf_per_sr, [float(axes.dataLim.y1) for axes in upper])
        finish_profiles(upper, lower, limits)
        for axes, side in zip(upper, sides, strict=True):
            mark_below(axes, on_side(profile, side), limits[0], ACCENT)
        below_words = f"U (k = {K:g})  [%]" if truth is None else "deviation  [%]"
        label_profiles(figure, upper, lower, ("DSF  [1/sr]", below_words))
        return data_uri(figure, dpi)


def side_panels(figure: Figure, sides: int) -> tuple[list[Axes], list[Axes]]:
    """A tall and a low panel per side, side by side, sharing axes."""
    width, height = figure.get_size_inches()
    each = (width - _LEFT_IN - _RIGHT_IN - (sides - 1) * _GAP_IN) / sides
    rows: list[list[Axes]] = []
    for bottom, tall in ((1.66, height - 1.66 - 0.5), (0.46, 1.0)):
        row: list[Axes] = []
        for column in range(sides):
            box = (_LEFT_IN + column * (each + _GAP_IN), bottom, each, tall)
            fraction = (box[0] / width, box[1] / height, box[2] / width, box[3] / height)
            above = rows[0][column] if rows else None
            row.append(figure.add_axes(fraction, sharey=row[0] if row else None, sharex=above))
        rows.append(row)
    return rows[0], rows[1]


def draw_profile(
    axes: Axes, p: PlaneProfile, colour: str, label: str, style: str = "-", *, bands_named: bool = True
) -> None:
    """Line broken at gaps, k = 2 bands, masked stretches in grey; the axis is logarithmic."""
    axes.set_yscale("log")
    x = broken(p.angle_deg, p)
    shared = bool(np.any(p.u_combined > p.u_independent))
    bands = [(p.u_combined, _OUTER, "U (k = 2), combined")] if shared else []
    for u, opacity, words in (*bands, (p.u_independent, _INNER, "U (k = 2), noise alone")):
        low = np.maximum(p.dsf_per_sr - K * u, 1e-300)  # a band that reaches zero reaches the lower edge
        high = np.maximum(p.dsf_per_sr + K * u, 1e-300)
        band = words if bands_named else None
        axes.fill_between(x, broken(low, p), broken(high, p), color=colour, alpha=opacity, lw=0, label=band)
    shown = np.where(p.dsf_per_sr > 0, p.dsf_per_sr, np.nan)
    axes.plot(x, broken(shown, p), style, lw=1.1, color=colour, label=label, marker=_dots(p), ms=2.5)
    for first, last in p.masked_deg:
        axes.axvspan(first, last, color=MASK_GREY, alpha=0.7, lw=0, zorder=0)


def mark_below(axes: Axes, p: PlaneProfile, low: float, colour: str) -> None:
    """Triangles on the lower edge: filled for values below the axis, hollow for zero and negative ones."""
    under = p.dsf_per_sr < low
    negative = p.dsf_per_sr <= 0
    for which, face in ((under & ~negative, colour), (negative, "white")):
        if which.any():
            axes.plot(
                p.angle_deg[which],
                np.full(int(which.sum()), low),
                "v",
                ms=4,
                mfc=face,
                mec=colour,
                mew=0.7,
                clip_on=False,
                zorder=4,
            )


def finish_profiles(upper: list[Axes], lower: list[Axes], limits: tuple[float, float]) -> None:
    """Limits, ticks and grid of both rows."""
    upper[0].set_ylim(*limits)
    log_ticks(upper[0].yaxis, *limits)
    if lower[0].get_yscale() == "log":
        low, high = lower[0].get_ylim()
        log_ticks(lower[0].yaxis, low, high, 5)
    for axes in (*upper, *lower):
        axes.grid(visible=True, which="major")
        axes.set_xlim(-90, 90)
        axes.set_xticks(range(-90, 91, 30))
    for axes in upper:
        axes.tick_params(labelbottom=False)
    for axes in (*upper[1:], *lower[1:]):
        axes.tick_params(labelleft=False)


def decades_shown(dsf_per_sr: FloatArray, tops: list[float]) -> tuple[float, float]:
    """Ends of the logarithmic axis: all but the lowest hundredth, at most seven decades."""
    positive = dsf_per_sr[dsf_per_sr > 0]
    if not len(positive):
        return 1e-6, 1.0
    top = max(float(positive.max()), *(t for t in tops if np.isfinite(t)), 0.0)
    return max(float(np.quantile(positive, 0.01)) / 2, top * 1e-7), top * 2


def side_name(d: Distribution, side: Half) -> str:
    """What a hemisphere is to the light: the side it comes from reflects."""
    return "Reflection side" if (d.incident_theta_deg <= 90) == (side == "front") else "Transmission side"


def on_side(profile: PlaneProfile, side: Half) -> PlaneProfile:
    """The bins of one hemisphere, angles folded to -90..90 and rising."""
    return _one_side(profile, (np.abs(profile.angle_deg) > 90) == (side == "back"))


def _one_side(p: PlaneProfile, mine: NDArray[np.bool_]) -> PlaneProfile:
    angle = folded_deg(p.angle_deg[mine])
    order = np.argsort(angle, kind="stable")
    here = np.flatnonzero(mine)[order]
    # Behind, rising angles run against the rising folded ones: a gap lies before the earlier neighbour there.
    backwards = len(here) > 1 and bool(np.median(np.diff(here)) < 0)
    gap = p.gap_before[here]
    if backwards:
        gap = np.concatenate([[False], p.gap_before[here[:-1]]])
    back = bool(len(here)) and bool(np.abs(p.angle_deg[here[0]]) > 90)
    runs = p.masked_deg[(np.abs(p.masked_deg.mean(axis=1)) > 90) == back]
    return PlaneProfile(
        angle[order],
        p.dsf_per_sr[here],
        p.u_independent[here],
        p.u_combined[here],
        gap,
        np.sort(folded_deg(runs), axis=1),
        np.zeros(0, dtype=np.int64),
        np.zeros(0, dtype=np.int64),
        p.band_deg,
    )


def _draw_uncertainty(axes: Axes, p: PlaneProfile) -> None:
    """Expanded uncertainty in percent of the DSF, combined and independent, on a log axis."""
    axes.set_yscale("log")
    x = broken(p.angle_deg, p)
    scale = 100 * K / np.where(p.dsf_per_sr > 0, p.dsf_per_sr, np.nan)
    axes.plot(x, broken(scale * p.u_combined, p), "-", lw=1.1, color=ACCENT)
    axes.plot(x, broken(scale * p.u_independent, p), ":", lw=1.1, color=ACCENT)


def _draw_truth(axes: Axes, d: Distribution, truth: KnownTruth, side: Half) -> None:
    fine = np.arange(-89.9, 89.95, 0.1)
    signed = fine if side == "front" else np.where(fine >= 0, 180.0 - fine, -180.0 - fine)
    line = truth.dsf_per_sr(d.incident_theta_deg, d.incident_phi_deg, plane_directions(d, signed))
    shown = np.where(line > 0, line, np.nan)
    axes.semilogy(fine, shown, "--", lw=1.0, color=SECOND, label="truth, convolved", zorder=3)


def _draw_deviation(
    axes: Axes, d: Distribution, truth: KnownTruth, profile: PlaneProfile, mine: NDArray[np.bool_]
) -> None:
    """Bins over the truth's mean at the same points, less one [percent], in the k = 2 bands about zero."""
    points = unit_from_angles_deg(d.theta_deg[profile.point], d.phi_deg[profile.point])
    expected = profile.mean(truth.dsf_per_sr(d.incident_theta_deg, d.incident_phi_deg, points))
    expected = np.where(expected > 0, expected, np.nan)
    p = _one_side(profile, mine)
    order = np.flatnonzero(mine)[np.argsort(folded_deg(profile.angle_deg[mine]), kind="stable")]
    deviation = 100 * (p.dsf_per_sr / expected[order] - 1)
    x = broken(p.angle_deg, p)
    for u, opacity in ((p.u_combined, _OUTER), (p.u_independent, _INNER)):
        half = broken(100 * K * u / expected[order], p)
        axes.fill_between(x, -half, half, color=ACCENT, alpha=opacity, lw=0)
    axes.plot(p.angle_deg, deviation, ".", ms=2.4, color=INK, mew=0)
    axes.axhline(0, lw=0.9, color=SECOND, ls="--")
    known = deviation[np.isfinite(deviation)]
    if len(known):
        spread = float(np.clip(np.quantile(np.abs(known), 0.98) * 1.4, 0.5, 100.0))
        if not axes.get_autoscaley_on():  # the other side has set it
            spread = max(spread, axes.get_ylim()[1])
        axes.set_ylim(-spread, spread)


def label_profiles(figure: Figure, upper: list[Axes], lower: list[Axes], ylabels: tuple[str, str]) -> None:
    """Words of both rows; the legend in a strip above, so that it hides nothing."""
    for axes, words in zip((upper[0], lower[0]), ylabels, strict=True):
        axes.set_ylabel(words)
        axes.yaxis.set_label_coords(-0.57 / (axes.get_position().width * WIDTH_IN), 0.5)
    figure.text(
        0.5,
        0.02,
        "angle from the normal in the plane of incidence [\u00b0], positive on the mirror side",
        ha="center",
        va="bottom",
        fontsize=9,
    )
    handles: list[Artist] = []
    labels: list[str] = []
    for axes in upper:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in labels:
                handles.append(handle)
                labels.append(label)
    figure.legend(handles, labels, loc="upper right", ncols=5, handlelength=1.8, columnspacing=1.4)


def broken(values: FloatArray, p: PlaneProfile) -> FloatArray:
    """With a NaN before every gap, so that lines and bands break there."""
    return np.insert(values, np.flatnonzero(p.gap_before), np.nan)


def _dots(p: PlaneProfile) -> str:
    return "." if len(p.angle_deg) < _SPARSE else "None"
