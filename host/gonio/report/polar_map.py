"""polar_map.py: maps of the DSF on both hemispheres with logarithmic colour, and close views of the peaks."""

import re
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LogNorm
from matplotlib.figure import Figure

from gonio.dataset.bsdf import Distribution
from gonio.report.comparison import measured_peaks, short_name
from gonio.report.drawing import (
    DPI,
    INK,
    MUTED,
    SMALL_PT,
    STYLE,
    WIDTH_IN,
    Half,
    data_uri,
    dsf_map,
    hatch_masked,
    log_ticks,
    mark_directions,
    new_figure,
    place,
    polar_frame,
)
from gonio.report.polar_grid import FloatArray, Picture, window_picture

DISC_BOX = (-90.0, 90.0, -90.0, 90.0)
_DISC_IN, _ZOOM_IN, _BAR_IN = 3.3, 1.2, 0.14
_MOST_ZOOMS = 2
_ZOOM_SIGMAS, _LEAST_ZOOM_DEG, _MOST_ZOOM_DEG = 5.0, 0.5, 12.0


@dataclass(frozen=True)
class LogScale:
    """Ends of a logarithmic colour scale [as the values], and the shares of solid angle that lie under it."""

    low: float
    top: float
    below_share: float  # of the measured solid angle, values under `low`
    negative_share: float  # of the measured solid angle, values of zero and less
    above_share: float = 0.0  # of the measured solid angle, values over `top`

    @property
    def norm(self) -> LogNorm:
        return LogNorm(self.low, self.top)

    def clipped(self, image: FloatArray) -> FloatArray:
        """The image with everything under the scale just under it, zero and negative too: LogNorm drops those."""
        return np.where(image < self.low, 0.5 * self.low, image)


def log_scale(values: FloatArray, weight: FloatArray, *, most_decades: float = 8.0) -> LogScale:
    """From what all but 1 % of the weight exceeds, however densely a peak was flown, to the maximum; at least one
    decade. `values`, `weight` (n,), without NaN."""
    total = float(weight.sum())
    weight, total = (weight, total) if total > 0 else (np.ones(len(values)), float(len(values)))
    used = values > 0
    if not used.any():
        return LogScale(1e-6, 1.0, 1.0, 1.0)
    order = np.argsort(values[used])
    rising, share = values[used][order], np.cumsum(weight[used][order])
    top = float(rising[-1])
    low = float(rising[np.searchsorted(share, 0.01 * share[-1])])
    low = min(max(low, top * 10.0**-most_decades), top / 10)
    return LogScale(low, top, float(weight[values < low].sum()) / total, float(weight[values <= 0].sum()) / total)


def dsf_scale(d: Distribution) -> LogScale:
    """The scale of a distribution's measured points."""
    return log_scale(d.dsf_per_sr[d.measured], d.solid_angle_sr[d.measured])


def polar_maps(
    d: Distribution, pictures: dict[Half, Picture], scale: LogScale, dpi: int = DPI, label: str = "DSF  [1/sr]"
) -> str:
    """DSF on the measured hemispheres, one logarithmic scale, masked regions hatched, peaks close by, as a data URI."""
    with mpl.rc_context(STYLE):
        peaks = _peaks_to_show(d)
        zoom_at = 0.1 + len(pictures) * (_DISC_IN + 0.03)
        bar_at = zoom_at + (_ZOOM_IN + 0.2 if peaks else 0.1)
        width = min(bar_at + 0.8, WIDTH_IN)
        figure = new_figure(_DISC_IN, width)
        norm, colours = scale.norm, dsf_map()
        for column, (half, picture) in enumerate(pictures.items()):
            axes = place(figure, 0.05 + column * (_DISC_IN + 0.03), 0.0, _DISC_IN, _DISC_IN)
            image = scale.clipped(picture.of(d.dsf_per_sr))
            axes.imshow(image, extent=DISC_BOX, origin="lower", norm=norm, cmap=colours, interpolation="nearest")
            hatch_masked(axes, picture.masked, DISC_BOX)
            polar_frame(axes, half, rings="white")
            mark_directions(axes, d, half)
        for row, (name, theta, phi, half_width) in enumerate(peaks):
            axes = place(figure, zoom_at, _DISC_IN - 0.55 - (row + 1) * _ZOOM_IN - row * 0.3, _ZOOM_IN, _ZOOM_IN)
            _draw_zoom(axes, d, scale, (theta, phi), half_width)
            axes.set_title(f"{name}, \u00b1{half_width:.2g}\u00b0", fontsize=SMALL_PT, loc="center", pad=3)
        log_bar(figure, place(figure, bar_at, 0.3, _BAR_IN, _DISC_IN - 0.75), scale, dsf_map(), label)
        return data_uri(figure, dpi)


def log_bar(figure: Figure, axes: Axes, scale: LogScale, colours: Colormap, label: str) -> None:
    """Colour bar with one label per decade, arrow-ended where values lie outside the scale."""
    mappable = mpl.cm.ScalarMappable(norm=scale.norm, cmap=colours)
    ends = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}
    bar = figure.colorbar(mappable, cax=axes, extend=ends[scale.below_share > 0, scale.above_share > 0])
    log_ticks(bar.ax.yaxis, scale.low, scale.top)
    bar.set_label(label)
    bar.outline.set_visible(False)


def scale_words(scale: LogScale) -> str:
    """What the caption says about values that the scale cannot show."""
    if scale.below_share <= 0:
        return ""
    words = f" Black: under the scale, {_percent(scale.below_share)} of the covered solid angle"
    if scale.negative_share > 0:
        words += f", {_percent(scale.negative_share)} at or below zero (noise)"
    return words + "."


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def _peaks_to_show(d: Distribution) -> list[tuple[str, float, float, float]]:
    """(name, theta, phi, half width [degrees]) of the peaks that fill little of the map."""
    shown = []
    for name, peak in measured_peaks(d).items():
        sigma = abs(peak.get("sigma_deg", np.nan))
        if "theta_deg" in peak and "phi_deg" in peak and np.isfinite(sigma) and sigma * _ZOOM_SIGMAS < _MOST_ZOOM_DEG:
            half_width = max(_LEAST_ZOOM_DEG, float(f"{_ZOOM_SIGMAS * sigma:.1g}"))
            shown.append((re.sub(r"_", " ", short_name(name)), peak["theta_deg"], peak["phi_deg"], half_width))
    return shown[:_MOST_ZOOMS]


def _draw_zoom(axes: Axes, d: Distribution, scale: LogScale, at_deg: tuple[float, float], half_width: float) -> None:
    picture = window_picture(d, *at_deg, half_width)
    box = (-half_width, half_width, -half_width, half_width)
    image = scale.clipped(picture.of(d.dsf_per_sr))
    axes.imshow(image, extent=box, origin="lower", norm=scale.norm, cmap=dsf_map(), interpolation="nearest")
    hatch_masked(axes, picture.masked, box)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set(visible=True, color=MUTED, lw=0.6)
    axes.title.set_color(INK)
