"""compare_figures.py: pictures of a comparison: side by side, difference and accordance, scatter plane, paths."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gonio.compare.result import Pair, PathTrace, Profile
from gonio.report.drawing import (
    ACCENT,
    BELOW,
    HALVES,
    INK,
    RELATIVE_MAP,
    SECOND,
    STYLE,
    Half,
    data_uri,
    diverging_map,
    dsf_map,
    half_name,
    hatch_masked,
    mark_directions,
    new_figure,
    on_disc,
    place,
    polar_frame,
)
from gonio.report.plane_figure import (
    K,
    broken,
    decades_shown,
    draw_profile,
    finish_profiles,
    label_profiles,
    mark_below,
    side_panels,
)
from gonio.report.plane_profile import PlaneProfile
from gonio.report.polar_grid import FloatArray, Picture, hemisphere_pictures
from gonio.report.polar_map import DISC_BOX, LogScale, log_bar, log_scale

_DISC_IN = 3.3
_ROW_IN = 3.35
_MOST_PATH_POINTS = 20_000
_GAP_DEG = 0.15  # the profiles stand at steps of 0.1 degrees


@dataclass(frozen=True)
class Shown:
    """A pair's points as the maps want them; what one of both lacks is masked."""

    theta_deg: FloatArray
    phi_deg: FloatArray
    measured: NDArray[np.bool_]
    incident_theta_deg: float
    incident_phi_deg: float


@dataclass(frozen=True)
class PairPictures:
    """Both hemispheres of a pair and the common scale of A and B."""

    shown: Shown
    halves: dict[Half, Picture]
    scale: LogScale


def pictures(pair: Pair) -> PairPictures:
    """The nearest point of every pixel, found once for all maps of a pair."""
    shown = Shown(pair.theta_deg, pair.phi_deg, pair.used, pair.incident_theta_deg, pair.incident_phi_deg)
    both = np.concatenate([pair.a_per_sr[pair.used], pair.b_per_sr[pair.used]])
    scale = log_scale(both, np.tile(pair.solid_angle_sr[pair.used], 2))
    return PairPictures(shown, hemisphere_pictures(shown), scale)


def side_by_side(pair: Pair, of: PairPictures) -> str:
    """A and B on one logarithmic scale, a row per hemisphere."""
    with mpl.rc_context(STYLE):
        figure = new_figure(_ROW_IN * len(of.halves), 8.0)
        for name, values, column in (("A", pair.a_per_sr, 0), ("B", pair.b_per_sr, 1)):
            for axes, half, picture in _rows(figure, of, column):
                image = of.scale.clipped(picture.of(values))
                axes.imshow(image, extent=DISC_BOX, origin="lower", norm=of.scale.norm, cmap=dsf_map())
                _frame(axes, of, half, f"{name}: {half_name(half)}", "white")
        log_bar(figure, _bar_axes(figure, 2), of.scale, dsf_map(), "DSF  [1/sr]")
        return data_uri(figure)


def relative_percent(pair: Pair) -> FloatArray:
    """100 (B - A) / A, (n,), NaN where A is not above zero or one of both has no value."""
    above = pair.used & (pair.a_per_sr > 0)
    result = np.full(len(pair.used), np.nan)
    result[above] = 100 * (pair.b_per_sr[above] / pair.a_per_sr[above] - 1)
    return result


def difference_end(percent: FloatArray) -> tuple[float, float]:
    """End of the difference's scale, 1, 2 or 5 times a power of ten that holds at least 98 % of the points, and the
    share of the points beyond it."""
    known = np.abs(percent[np.isfinite(percent)])
    if not len(known):
        return 1.0, 0.0
    end = _round_up(float(np.quantile(known, 0.98)))
    return end, float(np.mean(known > end))


def differences(pair: Pair, of: PairPictures) -> str:
    """(B - A) / A and the local accordance, both in percent, a row per hemisphere; what lies beyond the scale has the
    colours at the ends of the bar."""
    relative = relative_percent(pair)
    end, _ = difference_end(relative)
    accordance = pair.local_accordance_percent
    finite = accordance[np.isfinite(accordance)]
    least = min(float(np.floor(np.quantile(finite, 0.01) / 5) * 5), 95.0) if len(finite) else 0.0
    least = max(least, 0.0)
    with mpl.rc_context(STYLE):
        figure = new_figure(_ROW_IN * len(of.halves), 9.6)
        maps: tuple[tuple[str, FloatArray, Normalize, Colormap, float], ...] = (
            ("(B \u2212 A) / A", relative, Normalize(-end, end), diverging_map(), 0.0),
            (
                "local accordance",
                accordance,
                Normalize(least, 100.0),
                mpl.colormaps[RELATIVE_MAP].with_extremes(under=BELOW),
                4.65,
            ),
        )
        for name, values, norm, colours, left in maps:
            for axes, half, picture in _rows(figure, of, 0, left):
                axes.imshow(picture.of(values), extent=DISC_BOX, origin="lower", norm=norm, cmap=colours)
                _frame(axes, of, half, f"{name}: {half_name(half)}")
            extend = "both" if left == 0.0 else ("min" if least > 0 else "neither")
            bar = figure.colorbar(
                mpl.cm.ScalarMappable(norm=norm, cmap=colours),
                cax=_bar_axes(figure, 1, left),
                extend=extend,
            )
            bar.set_label("(B \u2212 A) / A  [%]" if left == 0.0 else "local accordance  [%]")
            bar.outline.set_visible(False)
        return data_uri(figure)


def planes(pair: Pair, names: tuple[str, str]) -> str | None:
    """Scatter planes of A and B with their k = 2 bands; below, B's deviation from A within both bands. None where the
    pair has none."""
    if not pair.profiles:
        return None
    with mpl.rc_context(STYLE):
        figure = new_figure(4.5)
        upper, lower = side_panels(figure, len(pair.profiles))
        for axes, below, profile in zip(upper, lower, pair.profiles, strict=True):
            a = _bins(profile, profile.a_per_sr, profile.u_a_per_sr)
            b = _bins(profile, profile.b_per_sr, profile.u_b_per_sr)
            draw_profile(axes, a, ACCENT, names[0], bands_named=False)
            draw_profile(axes, b, SECOND, names[1], "--", bands_named=False)
            _deviation(below, profile)
            axes.set_title("Reflection side" if profile.region == "reflection" else "Transmission side")
        values = np.concatenate([np.concatenate([p.a_per_sr[p.used], p.b_per_sr[p.used]]) for p in pair.profiles])
        limits = decades_shown(values, [])
        finish_profiles(upper, lower, limits)
        for axes, profile in zip(upper, pair.profiles, strict=True):
            for v, u, colour in (
                (profile.a_per_sr, profile.u_a_per_sr, ACCENT),
                (profile.b_per_sr, profile.u_b_per_sr, SECOND),
            ):
                mark_below(axes, _bins(profile, v, u), limits[0], colour)
        label_profiles(figure, upper, lower, ("DSF  [1/sr]", "B / A \u2212 1  [%]"))
        return data_uri(figure)


def paths(pair: Pair, names: tuple[str, str]) -> str | None:
    """Both detector paths on top of each other; None where A has none."""
    if not len(pair.path_a.theta_deg):
        return None
    with mpl.rc_context(STYLE):
        figure = new_figure(4.1, 7.6)
        traces = [(pair.path_a, ACCENT, "-", 0.9, names[0])]
        if pair.path_b is not None:
            traces.append((pair.path_b, SECOND, "-", 0.6, names[1]))
        shown = Shown(pair.theta_deg, pair.phi_deg, pair.used, pair.incident_theta_deg, pair.incident_phi_deg)
        for column, half in enumerate(HALVES):
            axes = place(figure, 0.05 + column * 3.75, 0.35, 3.7, 3.7)
            for trace, colour, style, width, _ in traces:
                x, y = _path_lines(trace, half)
                axes.plot(x, y, style, color=colour, lw=width, alpha=0.85)
            polar_frame(axes, half)
            mark_directions(axes, shown, half)
        handles = [mpl.lines.Line2D([], [], color=colour, label=name) for _, colour, _, _, name in traces]
        figure.legend(handles=handles, loc="lower center", ncols=2)
        return data_uri(figure)


def _rows(figure: Figure, of: PairPictures, column: int, left: float = 0.0) -> list[tuple[Axes, Half, Picture]]:
    top = float(figure.get_size_inches()[1])
    return [
        (
            place(figure, 0.05 + left + column * (_DISC_IN + 0.05), top - (row + 1) * _ROW_IN, _DISC_IN, _DISC_IN),
            half,
            p,
        )
        for row, (half, p) in enumerate(of.halves.items())
    ]


def _bar_axes(figure: Figure, columns: int, left: float = 0.0) -> Axes:
    top = float(figure.get_size_inches()[1])
    return place(figure, 0.1 + left + columns * (_DISC_IN + 0.05) + 0.05, top - _ROW_IN + 0.35, 0.14, _DISC_IN - 0.8)


def _frame(axes: Axes, of: PairPictures, half: Half, title: str, rings: str = INK) -> None:
    hatch_masked(axes, of.halves[half].masked, DISC_BOX)
    polar_frame(axes, half, title, rings=rings)
    mark_directions(axes, of.shown, half)


def _bins(profile: Profile, values: FloatArray, u: FloatArray) -> PlaneProfile:
    here = np.flatnonzero(np.isfinite(values))
    angle = profile.angle_deg[here]
    none = np.zeros(0, dtype=np.int64)
    gap = np.concatenate([[False], np.diff(angle) > _GAP_DEG]) if len(here) else np.zeros(0, dtype=np.bool_)
    known_u = np.nan_to_num(u[here])
    return PlaneProfile(angle, values[here], known_u, known_u, gap, np.zeros((0, 2)), none, none, 0.0)


def _deviation(axes: Axes, profile: Profile) -> None:
    use = profile.used & (profile.a_per_sr > 0)
    scale = 100 / np.where(use, profile.a_per_sr, np.nan)
    for u, colour in ((profile.u_a_per_sr, ACCENT), (profile.u_b_per_sr, SECOND)):
        p = _bins(profile, scale, u * scale)
        half = broken(K * p.u_combined, p)
        axes.fill_between(broken(p.angle_deg, p), -half, half, color=colour, alpha=0.3, lw=0)
    deviation = scale * (profile.b_per_sr - profile.a_per_sr)
    axes.plot(profile.angle_deg, deviation, ".", ms=2.2, color=INK, mew=0)
    axes.axhline(0, lw=0.8, color=ACCENT)
    known = np.abs(deviation[np.isfinite(deviation)])
    end = float(np.clip(1.4 * np.quantile(known, 0.98), 0.1, 200.0)) if len(known) else 1.0
    if not axes.get_autoscaley_on():  # the other side has set it
        end = max(end, axes.get_ylim()[1])
    axes.set_ylim(-end, end)


def _path_lines(trace: PathTrace, half: Half) -> tuple[FloatArray, FloatArray]:
    """Places on the disc, NaN where the line breaks."""
    step = max(1, len(trace.theta_deg) // _MOST_PATH_POINTS)
    theta, phi, path = trace.theta_deg[::step], trace.phi_deg[::step], trace.path[::step]
    x, y = on_disc(theta, phi)
    far = np.hypot(np.diff(x), np.diff(y))
    usual = float(np.median(far)) if len(far) else 1.0
    broken_after = np.append((far > max(12.0 * usual, 8.0)) | (np.diff(path) != 0), True)
    hidden = broken_after | ((theta <= 90.0) != (half == "front"))
    return np.where(hidden, np.nan, x), np.where(hidden, np.nan, y)


def _round_up(value: float) -> float:
    """To 1, 2 or 5 times a power of ten."""
    if not value > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1 - 1e-9)))
