"""figures.py: the report's figures, drawn with matplotlib and returned as PNG in a data URI."""

import base64
import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from gonio.dataset.bsdf import Distribution
from gonio.geometry.directions import unit_from_angles_deg
from gonio.reduce.integrals.truth_beside import KnownTruth
from gonio.report.comparison import word_for
from gonio.report.polar_grid import Half, hemisphere_image, plane_directions, plane_profile

INK, MUTED, ACCENT, SECOND = "#1c2733", "#66727f", "#00538a", "#c8541b"
MASK_GREY = "#c9ced4"
_MOST_PATH_POINTS = 20_000
_MEAN_OVER_DEG = 1.0
_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "text.color": INK,
    "hatch.linewidth": 0.5,
}
HALVES: tuple[Half, Half] = ("front", "back")


def data_uri(figure: Figure, dpi: int = 110) -> str:
    """The figure as `data:image/png;base64,...`."""
    out = io.BytesIO()
    figure.set_dpi(dpi)
    canvas: Any = FigureCanvasAgg(figure)  # its methods carry no types
    canvas.draw()  # once: savefig would draw twice for the layout
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").save(out, format="PNG", compress_level=7)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")


def polar_maps(d: Distribution, dpi: int = 110) -> str:
    """DSF on the measured hemispheres, one logarithmic scale, masked regions hatched."""
    with mpl.rc_context(_STYLE):
        images = {half: image for half in HALVES if (image := hemisphere_image(d, half)) is not None}
        figure = Figure(figsize=(4.3 * len(images) + 0.9, 4.3), dpi=dpi, layout="constrained")
        low, top = _range(d)
        norm = LogNorm(low, top)
        panels: Sequence[Axes] = figure.subplots(1, len(images), squeeze=False)[0]
        drawn = None
        for axes, (half, image) in zip(panels, images.items(), strict=True):
            box = (-90.0, 90.0, -90.0, 90.0)
            values = np.where(image.dsf_per_sr <= low, low, image.dsf_per_sr)
            drawn = axes.imshow(values, extent=box, origin="lower", norm=norm, cmap="cividis", interpolation="nearest")
            if image.masked.any():
                axes.contourf(
                    image.masked, levels=[0.5, 1.5], extent=box, colors=[MASK_GREY], hatches=["////"], origin="lower"
                )
            _polar_frame(axes, half)
            _mark_directions(axes, d, half)
        if drawn is not None:
            bar = figure.colorbar(drawn, ax=list(panels), shrink=0.75, pad=0.02, aspect=24)
            bar.set_label("DSF  [1/sr]")
            bar.outline.set_visible(False)
        return data_uri(figure, dpi)


def plane_figure(d: Distribution, truth: KnownTruth | None, dpi: int = 110) -> str:
    """Scatter plane on a log axis; with a truth its line, and the deviation at the points below."""
    profile = plane_profile(d)
    with mpl.rc_context(_STYLE):
        behind = np.abs(profile.angle_deg) > 90
        sides = [s for s in HALVES if np.any(behind == (s == "back"))]
        rows = 2 if truth is not None else 1
        figure = Figure(figsize=(9.4, 2.9 + 1.3 * (rows - 1)), dpi=dpi, layout="constrained")
        grid = figure.subplots(
            rows, max(len(sides), 1), squeeze=False, sharex="col", sharey="row", height_ratios=[2.4, 1][:rows]
        )
        for column, side in enumerate(sides):
            axes: Axes = grid[0][column]
            mine = behind == (side == "back")
            angle = _folded(profile.angle_deg[mine])
            axes.semilogy(
                angle,
                np.where(profile.dsf_per_sr[mine] > 0, profile.dsf_per_sr[mine], np.nan),
                ".",
                ms=2.2,
                color=ACCENT,
                label=f"{word_for(d)}, within {profile.band_deg:.2g}\u00b0 of the plane",
            )
            if truth is not None:
                _draw_truth(axes, grid[1][column], d, truth, profile.index[mine], angle, side)
            axes.set_title(
                "Reflection side" if _is_reflection(d, side) else "Transmission side", fontsize=9, loc="left"
            )
            axes.grid(alpha=0.25, lw=0.5)
            axes.set_xlim(-90, 90)
            axes.set_xticks(range(-90, 91, 30))
        _label_profile(figure, grid, profile.dsf_per_sr, truth is not None)
        return data_uri(figure, dpi)


def _draw_truth(
    axes: Axes,
    lower: Axes,
    d: Distribution,
    truth: KnownTruth,
    index: NDArray[np.int64],
    angle: NDArray[np.float64],
    side: Half,
) -> None:
    fine = np.arange(-89.9, 89.95, 0.1)
    signed = fine if side == "front" else np.where(fine >= 0, 180.0 - fine, -180.0 - fine)
    line = truth.dsf_per_sr(d.incident_theta_deg, d.incident_phi_deg, plane_directions(d, signed))
    axes.semilogy(fine, np.where(line > 0, line, np.nan), "-", lw=0.9, color=SECOND, label="truth, convolved", zorder=3)
    points = unit_from_angles_deg(d.theta_deg[index], d.phi_deg[index])
    at_points = truth.dsf_per_sr(d.incident_theta_deg, d.incident_phi_deg, points)
    good = at_points > 0
    deviation = 100 * (d.dsf_per_sr[index][good] / at_points[good] - 1)
    lower.plot(angle[good], deviation, ".", ms=1.6, color=ACCENT, alpha=0.35, mew=0)
    bins, place = np.unique(np.floor(angle[good] / _MEAN_OVER_DEG), return_inverse=True)
    means = np.bincount(place, deviation, len(bins)) / np.bincount(place, minlength=len(bins))
    lower.plot((bins + 0.5) * _MEAN_OVER_DEG, means, ".", ms=2.4, color=INK, mew=0)
    lower.axhline(0, lw=0.8, color=SECOND)
    spread = float(np.clip(np.quantile(np.abs(deviation), 0.98) * 1.4, 1.0, 100.0)) if good.any() else 1.0
    lower.set_ylim(-spread, spread)
    lower.grid(alpha=0.25, lw=0.5)


def _label_profile(figure: Figure, grid: NDArray[np.object_], dsf: NDArray[np.float64], with_truth: bool) -> None:
    first: Axes = grid[0][0]
    first.set_ylabel("DSF  [1/sr]")
    positive = dsf[dsf > 0]
    if len(positive):
        top = max(float(positive.max()), *(float(axes.dataLim.y1) for axes in grid[0]))
        first.set_ylim(max(float(np.quantile(positive, 0.01)) / 3, top * 1e-7), top * 2)
    handles, labels = first.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper right", ncols=2, fontsize=8, frameon=False)
    if with_truth:
        grid[1][0].set_ylabel("deviation  [%]")
    for axes in grid[-1]:
        axes.set_xlabel(
            "angle from the normal in the plane of incidence  [\u00b0]   (positive: mirror side)", fontsize=8
        )


def path_figure(d: Distribution, dpi: int = 110) -> str | None:
    """The detector's path in flying order; None when the points carry no time."""
    if not np.any(d.time_ns > 0):
        return None
    order = np.argsort(d.time_ns, kind="stable")
    order = order[:: max(1, len(order) // _MOST_PATH_POINTS)]
    theta, phi = d.theta_deg[order], np.radians(d.phi_deg[order])
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(8.2, 4.1), dpi=dpi, layout="constrained")
        for axes, half in zip(figure.subplots(1, 2), HALVES, strict=True):
            radius = theta if half == "front" else 180.0 - theta
            here = radius <= 90.0
            x, y = np.where(here, radius * np.cos(phi), np.nan), np.where(here, radius * np.sin(phi), np.nan)
            step = np.hypot(np.diff(x), np.diff(y))
            usual = np.nanmedian(step) if np.isfinite(step).any() else 1.0
            jump = np.append(step > max(12.0 * usual, 8.0), False)
            axes.plot(np.where(jump, np.nan, x), np.where(jump, np.nan, y), "-", lw=0.45, color=ACCENT, alpha=0.8)
            _polar_frame(axes, half)
            _mark_directions(axes, d, half)
        return data_uri(figure, dpi)


def beam_figure(beam: Distribution, dpi: int = 110) -> str:
    """Signal of the free beam against the angle from its axis."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(6.2, 2.7), dpi=dpi, layout="constrained")
        axes = figure.subplots()
        top = max(float(np.nanmax(beam.signal)), 1e-12)
        lit = beam.signal > 1e-7 * top  # a simulated beam's surround is dark, and has no logarithm
        axes.semilogy(beam.theta_deg[lit], beam.signal[lit] / top, ".", ms=1.8, color=ACCENT)
        axes.set_xlabel("angle from the beam's axis  [\u00b0]")
        axes.set_ylabel("signal / maximum")
        axes.set_ylim(bottom=float(np.min(beam.signal[lit], initial=top)) / top / 2, top=2)
        axes.grid(alpha=0.25, lw=0.5)
        return data_uri(figure, dpi)


def _polar_frame(axes: Axes, half: Half) -> None:
    axes.set_aspect("equal")
    axes.set_axis_off()
    circle = np.radians(np.arange(0, 361, 2))
    for radius in (30, 60, 90):
        axes.plot(radius * np.cos(circle), radius * np.sin(circle), lw=0.9 if radius == 90 else 0.4, color=MUTED)
        if radius < 90:
            theta = radius if half == "front" else 180 - radius
            place = (-radius * np.sqrt(0.5), -radius * np.sqrt(0.5))  # off the planes that are lit most often
            axes.annotate(f"{theta}\u00b0", place, fontsize=6.5, color=MUTED, ha="center", va="top", bbox=_box())
    for azimuth, align in ((0, "left"), (90, "center"), (180, "right"), (270, "center")):
        x, y = 94 * np.cos(np.radians(azimuth)), 94 * np.sin(np.radians(azimuth))
        vertical = {90: "bottom", 270: "top"}.get(azimuth, "center")
        axes.annotate(f"\u03c6 {azimuth}\u00b0", (x, y), fontsize=7, color=MUTED, ha=align, va=vertical)
    side = (
        "front hemisphere (\u03b8 < 90\u00b0)"
        if half == "front"
        else "back hemisphere (\u03b8 > 90\u00b0), seen from the front"
    )
    axes.annotate(side, (0, 106), fontsize=8.5, color=INK, ha="center", va="bottom")
    axes.set_xlim(-112, 112)
    axes.set_ylim(-106, 122)


def _box() -> dict[str, object]:
    return {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.75}


def _mark_directions(axes: Axes, d: Distribution, half: Half) -> None:
    marks = (
        (d.incident_theta_deg, d.incident_phi_deg, "source", "o"),
        (d.incident_theta_deg, d.incident_phi_deg + 180, "mirror", "x"),
        (180 - d.incident_theta_deg, d.incident_phi_deg + 180, "through", "+"),
    )
    for theta, phi, name, marker in marks:
        if (theta <= 90) != (half == "front") or (name == "mirror" and d.incident_theta_deg < 3):
            continue
        radius = theta if half == "front" else 180 - theta
        x, y = radius * np.cos(np.radians(phi)), radius * np.sin(np.radians(phi))
        face = "none" if marker == "o" else SECOND
        axes.scatter(
            [x], [y], s=34, marker=marker, facecolors=face, edgecolors=SECOND if marker == "o" else None, lw=1.1
        )
        axes.annotate(name, (x, y), xytext=(5, 5), textcoords="offset points", fontsize=7, color=SECOND, bbox=_box())


def _range(d: Distribution) -> tuple[float, float]:
    """Ends of the logarithmic colour scale: from what all but 1 % of the measured solid angle exceeds, however densely
    a peak was flown, to the maximum; at least one decade, at most eight."""
    used = d.measured & (d.dsf_per_sr > 0)
    if not used.any():
        return 1e-6, 1.0
    order = np.argsort(d.dsf_per_sr[used])
    values, weight = d.dsf_per_sr[used][order], d.solid_angle_sr[used][order]
    share = np.cumsum(weight if weight.any() else np.ones(len(values)))
    top = float(values[-1])
    low = float(values[np.searchsorted(share, 0.01 * share[-1])])
    return min(max(low, top * 1e-8), top / 10), top


def _folded(angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Signed angles from the nearer normal: 150 becomes 30, -150 becomes -30."""
    return np.where(np.abs(angle_deg) <= 90, angle_deg, np.sign(angle_deg) * (180.0 - np.abs(angle_deg)))


def _is_reflection(d: Distribution, side: Half) -> bool:
    return (d.incident_theta_deg <= 90) == (side == "front")
