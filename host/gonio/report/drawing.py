"""drawing.py: one style for all figures: colours, colour maps, letters, the polar frame, and pictures in data URIs."""

import base64
import io
from typing import Any, Literal, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator
from numpy.typing import NDArray
from PIL import Image

Half = Literal["front", "back"]
HALVES: tuple[Half, Half] = ("front", "back")


class Placed(Protocol):
    """Points on the sphere as maps need them: a Distribution, or one side of a comparison."""

    @property
    def theta_deg(self) -> NDArray[np.float64]: ...
    @property
    def phi_deg(self) -> NDArray[np.float64]: ...
    @property
    def measured(self) -> NDArray[np.bool_]: ...
    @property
    def incident_theta_deg(self) -> float: ...
    @property
    def incident_phi_deg(self) -> float: ...


INK, MUTED, ACCENT, SECOND = "#1c2733", "#5d6975", "#00538a", "#c8541b"
MASK_GREY = "#c9ced4"
BELOW = "#000000"  # under the scale: not a colour of any map here
WIDTH_IN, DPI = 9.0, 120  # the report's column; on a phone the picture scrolls at its full size
SMALL_PT = 8  # no letter is smaller: 1.7 mm on paper
# Colour maps. All but the diverging one grow steadily lighter, so they read in grey and for the colour-blind.
DSF_MAP, RELATIVE_MAP = "viridis", "cividis"

# Categories (which effect, which path) in an order of alternating lightness, told apart by the colour-blind too
# (after Okabe and Ito); each has a hatch as well, for print in grey.
CATEGORY_COLOURS = ("#00538a", "#f0e442", "#c8541b", "#7cc4ee", "#4b2a52", "#e5a21c", "#0a7d5c", "#d99bbd")
CATEGORY_HATCHES = ("", "", "////", "", "", "....", "\\\\\\\\", "xx")
# Lines on white: no yellow.
LINE_COLOURS = ("#00538a", "#c8541b", "#0a7d5c", "#4b2a52", "#3f9bd1", "#b07a0c", "#c05a94", "#5d6975")

STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.labelsize": 9,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "legend.fontsize": SMALL_PT,
    "legend.frameon": False,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": SMALL_PT,
    "ytick.labelsize": SMALL_PT,
    "text.color": INK,
    "hatch.linewidth": 0.5,
    "axes.unicode_minus": True,
}


def dsf_map() -> Colormap:
    """Colours of the DSF; what lies under the scale is black."""
    return mpl.colormaps[DSF_MAP].with_extremes(under=BELOW)


def diverging_map() -> Colormap:
    """Differences: blue below, orange above, lightest at zero; steadily darker to both ends, blue the darker one."""
    ends = ["#0b2a5b", "#2f6db3", "#a9cbe8", "#f7f7f4", "#f6c08a", "#dd7a24", "#97420c"]
    return LinearSegmentedColormap.from_list("gonio_difference", ends).with_extremes(under="#000000", over="#4f1e00")


def new_figure(height_in: float, width_in: float = WIDTH_IN) -> Figure:
    """An empty figure; its parts are placed by `place`. To be drawn within `mpl.rc_context(STYLE)`."""
    return Figure(figsize=(width_in, height_in), dpi=DPI)


def place(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes by their place in inches from the lower left corner."""
    w, h = figure.get_size_inches()
    return figure.add_axes((left / w, bottom / h, width / w, height / h))


def data_uri(figure: Figure, dpi: int = DPI) -> str:
    """The figure as `data:image/png;base64,...`."""
    return "data:image/png;base64," + base64.b64encode(png(figure, dpi)).decode("ascii")


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """The figure as PNG."""
    out = io.BytesIO()
    figure.set_dpi(dpi)
    canvas: Any = FigureCanvasAgg(figure)  # its methods carry no types
    canvas.draw()  # once: savefig would draw twice for the layout
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").save(out, format="PNG", compress_level=7)
    return out.getvalue()


def half_name(half: Half) -> str:
    return "front (\u03b8 < 90\u00b0)" if half == "front" else "back (\u03b8 > 90\u00b0), seen from the front"


def polar_frame(axes: Axes, half: Half, title: str | None = None, rings: str = MUTED) -> None:
    """Circles every 30 degrees from the pole, azimuths at the rim, the hemisphere's name or `title`."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    circle = np.radians(np.arange(0, 361, 2))
    for radius in (30, 60, 90):
        width, colour = (0.9, MUTED) if radius == 90 else (0.5, rings)
        axes.plot(radius * np.cos(circle), radius * np.sin(circle), lw=width, color=colour, alpha=0.7)
        if radius < 90:
            theta = radius if half == "front" else 180 - radius
            at = (-radius * np.sqrt(0.5), -radius * np.sqrt(0.5))  # off the planes that are lit most often
            axes.annotate(f"{theta}\u00b0", at, fontsize=SMALL_PT, color=MUTED, ha="center", va="center", bbox=_box())
    for azimuth, align in ((0, "left"), (90, "center"), (180, "right"), (270, "center")):
        x, y = 93 * np.cos(np.radians(azimuth)), 93 * np.sin(np.radians(azimuth))
        vertical = {90: "bottom", 270: "top"}.get(azimuth, "center")
        axes.annotate(f"\u03c6 {azimuth}\u00b0", (x, y), fontsize=SMALL_PT, color=MUTED, ha=align, va=vertical)
    words = half_name(half) if title is None else title
    axes.annotate(words, (0, 107), fontsize=9.5, color=INK, ha="center", va="bottom")
    axes.set_xlim(-116, 116)
    axes.set_ylim(-106, 120)


def mark_directions(axes: Axes, d: Placed, half: Half) -> None:
    """Source, mirror direction and the way straight through, where they lie in this hemisphere."""
    marks = (
        (d.incident_theta_deg, d.incident_phi_deg, "source", "o"),
        (d.incident_theta_deg, d.incident_phi_deg + 180, "mirror", "x"),
        (180 - d.incident_theta_deg, d.incident_phi_deg + 180, "through", "+"),
    )
    for theta, phi, name, marker in marks:
        if (theta <= 90) != (half == "front") or (name == "mirror" and d.incident_theta_deg < 3):
            continue
        x, y = on_disc(np.array([theta]), np.array([phi]))
        face = "none" if marker == "o" else SECOND
        edge = SECOND if marker == "o" else None
        axes.scatter(x, y, s=38, marker=marker, facecolors=face, edgecolors=edge, lw=1.2, zorder=5)
        axes.annotate(
            name,
            (x[0], y[0]),
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=SMALL_PT,
            color=SECOND,
            bbox=_box(),
            zorder=6,
        )


def on_disc(theta_deg: NDArray[np.float64], phi_deg: NDArray[np.float64]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Place on a hemisphere's disc: radius is the angle from its pole [degrees]."""
    radius = np.where(theta_deg <= 90.0, theta_deg, 180.0 - theta_deg)
    phi = np.radians(phi_deg)
    return radius * np.cos(phi), radius * np.sin(phi)


def log_ticks(axis: Axis, low: float, high: float, most: int = 10) -> None:
    """Labels of a logarithmic axis or bar from `low` to `high`: powers of ten; plain figures 1, 2, 5 where there are
    few decades, so that there are always some."""
    decades = np.log10(high / low)
    if decades < 2:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades > 0.5 else tuple(range(1, 10))))
        axis.set_major_formatter(lambda value, _: f"{value:.3g}")
    else:
        axis.set_major_locator(LogLocator(numticks=most))
    if decades > 5 or decades < 2:
        axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def hatch_masked(axes: Axes, masked: NDArray[np.bool_], box: tuple[float, float, float, float]) -> None:
    """Grey with strokes where every pixel of `masked` (rows from below) is true."""
    if masked.any():
        axes.contourf(
            masked, levels=[0.5, 1.5], extent=box, colors=[MASK_GREY], hatches=["////"], origin="lower", zorder=2
        )


def _box() -> dict[str, object]:
    return {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.8}
