"""path_figure.py: the detector's path on both hemispheres, by path or by time; masked points by their reason."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution, PointFlag
from gonio.report.comparison import short_name
from gonio.report.drawing import (
    DPI,
    HALVES,
    INK,
    LINE_COLOURS,
    MUTED,
    SECOND,
    STYLE,
    Half,
    data_uri,
    mark_directions,
    new_figure,
    on_disc,
    place,
    polar_frame,
)

_MOST_POINTS = 20_000  # of the path as drawn
_MOST_MARKS = 400  # of one reason
_DISC_IN = 3.7
_TIME_MAP = "cividis"
# Reasons in the order of the flags; shape and colour both tell them apart.
_MARKS = {
    PointFlag.SHADOWED: ("s", INK),
    PointFlag.UNREACHABLE: ("x", SECOND),
    PointFlag.HOLDER: ("D", "#4b2a52"),
    PointFlag.SATURATED: ("^", "#b3006b"),
    PointFlag.POSE_LOST: ("v", "#0a7d5c"),
    PointFlag.CLOCK_UNSETTLED: ("P", MUTED),
    PointFlag.NOT_MEASURED: ("1", "#e5a21c"),
}


def path_figure(d: Distribution, dpi: int = DPI) -> str | None:
    """A data URI; None when the points carry neither time nor path."""
    flown = np.flatnonzero(d.time_ns > 0)
    if not len(flown):
        return None
    order = flown[np.argsort(d.time_ns[flown], kind="stable")]
    named = bool(len(d.paths)) and len(d.path) == len(d.theta_deg)
    with mpl.rc_context(STYLE):
        figure = new_figure(_DISC_IN + 0.55, 2 * _DISC_IN + (0.2 if named else 1.3))
        panels = {
            half: place(figure, 0.05 + i * (_DISC_IN + 0.05), 0.5, _DISC_IN, _DISC_IN) for i, half in enumerate(HALVES)
        }
        for half, axes in panels.items():
            polar_frame(axes, half)
            _draw_line(axes, d, order, half, named)
            _mark_masked(axes, d, half)
            mark_directions(axes, d, half)
        handles = _reasons(d)
        if named:
            handles = [*_path_handles(d), *handles]
        else:
            _time_bar(figure, d, order)
        if handles:
            figure.legend(handles=handles, loc="lower center", ncols=6, columnspacing=1.4, handlelength=1.6)
        return data_uri(figure, dpi)


def colour_of_path(number: int) -> str:
    """Colours repeat after the last one."""
    return LINE_COLOURS[number % len(LINE_COLOURS)]


def _draw_line(axes: Axes, d: Distribution, order: NDArray[np.int64], half: Half, named: bool) -> None:
    """The path through every _MOST_POINTS-th part of the points, broken where the detector jumped."""
    order = order[:: max(1, len(order) // _MOST_POINTS)]
    theta = d.theta_deg[order]
    here = (theta <= 90.0) == (half == "front")
    x, y = on_disc(theta, d.phi_deg[order])
    places = np.stack((x, y), axis=1)
    step = np.hypot(np.diff(x), np.diff(y))
    usual = float(np.median(step)) if len(step) else 1.0
    drawn = here[1:] & here[:-1] & (step <= max(12.0 * usual, 8.0))
    if named:
        drawn &= d.path[order[1:]] == d.path[order[:-1]]
    segments = np.stack((places[:-1], places[1:]), axis=1)[drawn]
    if named:
        table = np.array([mpl.colors.to_rgba(colour_of_path(i)) for i in range(len(d.paths))] + [(0.5, 0.5, 0.5, 1.0)])
        axes.add_collection(LineCollection(list(segments), colors=table[d.path[order[1:]][drawn]], linewidths=0.8))
        return
    minutes = _minutes(d, order)
    lines = LineCollection(list(segments), cmap=_TIME_MAP, linewidths=0.8)
    lines.set_array(minutes[1:][drawn])
    lines.set_clim(float(minutes[0]), float(minutes[-1]))
    axes.add_collection(lines)


def _mark_masked(axes: Axes, d: Distribution, half: Half) -> None:
    here = (d.theta_deg <= 90.0) == (half == "front")
    for flag, (marker, colour) in _MARKS.items():
        points = np.flatnonzero(here & ((d.flags & flag) != 0))
        if len(points):
            x, y = on_disc(
                *(angle[points[:: max(1, len(points) // _MOST_MARKS)]] for angle in (d.theta_deg, d.phi_deg))
            )
            axes.scatter(x, y, s=9, marker=marker, color=colour, lw=0.7, zorder=3)


def _reasons(d: Distribution) -> list[mpl.artist.Artist]:
    """Legend of the reasons for masking, with the number of points."""
    handles: list[mpl.artist.Artist] = []
    for flag, (marker, colour) in _MARKS.items():
        count = int(np.count_nonzero(d.flags & flag))
        if count:
            words = f"{(flag.name or '').lower().replace('_', ' ')} ({count:,})"
            handles.append(mpl.lines.Line2D([], [], ls="", marker=marker, ms=4, color=colour, label=words))
    return handles


def _path_handles(d: Distribution) -> list[mpl.artist.Artist]:
    used = np.unique(d.path[d.path >= 0])
    names = [short_name(d.paths[i]) for i in used]
    return [
        mpl.lines.Line2D([], [], color=colour_of_path(int(i)), label=name) for i, name in zip(used, names, strict=True)
    ]


def _minutes(d: Distribution, order: NDArray[np.int64]) -> NDArray[np.float64]:
    return np.asarray((d.time_ns[order] - d.time_ns[order[0]]) / 60e9)


def _time_bar(figure: mpl.figure.Figure, d: Distribution, order: NDArray[np.int64]) -> None:
    minutes = _minutes(d, order[[0, -1]])
    norm = mpl.colors.Normalize(0.0, max(float(minutes[-1]), 1e-9))
    bar = figure.colorbar(
        mpl.cm.ScalarMappable(norm=norm, cmap=_TIME_MAP), cax=place(figure, 2 * _DISC_IN + 0.35, 0.95, 0.14, 2.8)
    )
    bar.set_label("time since the first point  [min]")
    bar.outline.set_visible(False)
