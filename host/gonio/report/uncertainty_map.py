"""uncertainty_map.py: the combined relative uncertainty over both hemispheres, and which effect dominates where."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from gonio.dataset.bsdf import Distribution
from gonio.dataset.effects import EFFECTS, effect_of
from gonio.dataset.uncertainty import combined_u_per_sr
from gonio.report.drawing import (
    BELOW,
    CATEGORY_COLOURS,
    CATEGORY_HATCHES,
    DPI,
    RELATIVE_MAP,
    STYLE,
    Half,
    data_uri,
    hatch_masked,
    mark_directions,
    new_figure,
    place,
    polar_frame,
)
from gonio.report.polar_grid import FloatArray, Picture
from gonio.report.polar_map import DISC_BOX, LogScale, log_bar

_DISC_IN = 3.3
_MOST_CATEGORIES = 7  # the rest is "other"
_LEAST_SHARE = 1e-3  # of the solid angle: a smaller category is not to be seen, and is "other" too


@dataclass(frozen=True)
class Dominance:
    """Which systematic effect contributes most at each point: `category` (n,) counts from 0 in `names`, -1: masked."""

    category: NDArray[np.int64]
    names: tuple[str, ...]  # words of ASTM E2387, by falling share; "other" last where there are many
    shares: tuple[float, ...]  # of the measured solid angle
    noise_share: float  # of the measured solid angle, where a point's noise exceeds all of them together


def relative_u(d: Distribution) -> FloatArray:
    """Combined standard uncertainty over |DSF|, (n,): infinite where the DSF is 0, NaN where masked."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(combined_u_per_sr(d) / np.abs(d.dsf_per_sr))


def dominance(d: Distribution) -> Dominance:
    """Effects of one name (all axes, say) are taken together. Noise is counted apart: it is most of what a single fast
    sample knows not, and least of what a sum does not."""
    squares: dict[str, FloatArray] = {}
    for key, column in d.effects.items():
        name = effect_of(key).name
        squares[name] = squares.get(name, np.zeros(len(column))) + column**2
    names = list(squares)
    largest = np.argmax(np.nan_to_num(np.stack(list(squares.values()))), axis=0)
    measured = d.measured
    weight = d.solid_angle_sr[measured]
    weight = weight if weight.any() else np.ones(len(weight))
    share = np.bincount(largest[measured], weight, len(names)) / max(float(weight.sum()), 1e-300)
    order = [int(i) for i in np.argsort(-share, kind="stable") if share[i] > 0]
    kept = [i for i in order if share[i] >= _LEAST_SHARE]
    kept = order if len(kept) == len(order) <= _MOST_CATEGORIES else kept[: _MOST_CATEGORIES - 1]
    place_of = np.full(len(names), len(kept), dtype=np.int64)
    place_of[kept] = np.arange(len(kept))
    words = [EFFECTS[names[i]].words for i in kept]
    shares = [float(share[i]) for i in kept]
    if len(kept) < len(order):
        words, shares = [*words, "other"], [*shares, 1.0 - sum(shares)]
    noisy = measured & (d.variance_per_sr2 > sum(squares.values()))
    noise_share = float(weight[noisy[measured]].sum() / max(float(weight.sum()), 1e-300))
    return Dominance(np.where(measured, place_of[largest], -1), tuple(words), tuple(shares), noise_share)


def uncertainty_map(
    d: Distribution, pictures: dict[Half, Picture], by_cause: Dominance | None, dpi: int = DPI
) -> str | None:
    """Relative standard uncertainty on a log scale and, with `by_cause`, the dominant effect below, as a data URI; None
    where no point has an uncertainty."""
    relative = 100 * relative_u(d)
    finite = d.measured & np.isfinite(relative) & (relative > 0)
    if not finite.any():
        return None
    scale = _scale(relative[finite], d.solid_angle_sr[finite])
    rows = 1 if by_cause is None else 2
    legend_in = 0.0 if by_cause is None else 0.15 + 0.17 * ((len(by_cause.names) + 1) // 2)
    with mpl.rc_context(STYLE):
        figure = new_figure(rows * (_DISC_IN + 0.05) + legend_in, 8.0)
        bottom = figure.get_size_inches()[1] - _DISC_IN
        colours = mpl.colormaps[RELATIVE_MAP].with_extremes(under=BELOW, over="#ffffff")
        for column, (half, picture) in enumerate(pictures.items()):
            left = 0.05 + column * (_DISC_IN + 0.1)
            axes = place(figure, left, bottom, _DISC_IN, _DISC_IN)
            image = scale.clipped(np.minimum(picture.of(relative), 1e300))
            axes.imshow(image, extent=DISC_BOX, origin="lower", norm=scale.norm, cmap=colours, interpolation="nearest")
            hatch_masked(axes, picture.masked, DISC_BOX)
            polar_frame(axes, half, rings="white")
            mark_directions(axes, d, half)
            if by_cause is not None:
                axes = place(figure, left, legend_in, _DISC_IN, _DISC_IN)
                _draw_categories(axes, by_cause, picture.of(by_cause.category.astype(np.float64)))
                hatch_masked(axes, picture.masked, DISC_BOX)
                polar_frame(axes, half, title="")
        bar = place(figure, 0.05 + len(pictures) * (_DISC_IN + 0.1) + 0.1, bottom + 0.3, 0.14, _DISC_IN - 0.75)
        log_bar(figure, bar, scale, colours, "u (k = 1) of the DSF  [%]")
        if by_cause is not None:
            figure.legend(handles=_legend(by_cause), loc="lower center", ncols=2, columnspacing=2.0)
        return data_uri(figure, dpi)


def _scale(percent: FloatArray, weight: FloatArray) -> LogScale:
    """Holds all but one point in a thousand at either end, and nothing over 100 percent; at least one decade."""
    low, top = (float(end) for end in np.quantile(percent, [0.001, 0.999]))
    top = max(min(top, 100.0), 10 * low)
    weight = weight if weight.any() else np.ones(len(percent))
    outside = [float(weight[which].sum() / weight.sum()) for which in (percent < low, percent > top)]
    return LogScale(low, top, outside[0], 0.0, outside[1])


def _draw_categories(axes: mpl.axes.Axes, by_cause: Dominance, image: FloatArray) -> None:
    colours = ListedColormap(CATEGORY_COLOURS[: len(by_cause.names)])
    norm = BoundaryNorm(np.arange(len(by_cause.names) + 1) - 0.5, colours.N)
    axes.imshow(image, extent=DISC_BOX, origin="lower", norm=norm, cmap=colours, interpolation="nearest")
    for number in range(len(by_cause.names)):
        if CATEGORY_HATCHES[number]:
            inside = np.where(image == number, 1.0, 0.0)
            if inside.any():
                axes.contourf(
                    inside,
                    levels=[0.5, 1.5],
                    extent=DISC_BOX,
                    colors="none",
                    hatches=[CATEGORY_HATCHES[number]],
                    origin="lower",
                )


def _legend(by_cause: Dominance) -> list[Patch]:
    parts = zip(by_cause.names, by_cause.shares, CATEGORY_COLOURS, CATEGORY_HATCHES, strict=False)
    return [
        Patch(facecolor=colour, hatch=hatch, edgecolor="#1c2733", lw=0.4, label=f"{words} ({_share(share)})")
        for words, share, colour, hatch in parts
    ]


def _share(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= 1e-3 else "under 0.1 %"
