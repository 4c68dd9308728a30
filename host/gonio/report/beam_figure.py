"""beam_figure.py: the free beam's profile over decades."""

import matplotlib as mpl
import numpy as np

from gonio.dataset.bsdf import Distribution
from gonio.report.drawing import ACCENT, DPI, MUTED, SMALL_PT, STYLE, data_uri, new_figure, place

_MOST_POINTS = 8000
_LEAST_SHARE = 1e-7  # of the maximum: a simulated beam's surround is dark, and has no logarithm


def beam_figure(beam: Distribution, dpi: int = DPI) -> str:
    """Signal of the free beam against the angle from its axis, as a data URI; the median of its P_i is marked."""
    with mpl.rc_context(STYLE):
        figure = new_figure(2.9, 7.0)
        axes = place(figure, 0.72, 0.5, 6.1, 2.25)
        top = max(float(np.nanmax(beam.signal)), 1e-12)
        lit = np.flatnonzero(beam.signal > _LEAST_SHARE * top)
        shown = lit[:: max(1, len(lit) // _MOST_POINTS)]
        axes.semilogy(beam.theta_deg[shown], beam.signal[shown] / top, ".", ms=2.2, color=ACCENT, mew=0)
        axes.set_xlabel("angle from the beam's axis  [\u00b0]")
        axes.set_ylabel("signal / maximum")
        axes.set_ylim(bottom=float(np.min(beam.signal[lit], initial=top)) / top / 2, top=2)
        axes.grid(visible=True)
        half = _half_power_deg(beam)
        if half is not None:
            axes.axvline(half, color=MUTED, lw=0.9, ls="--")
            axes.annotate(
                f"half of P_i within {half:.3g}\u00b0",
                (half, 0.02),
                xycoords=("data", "axes fraction"),
                xytext=(4, 4),
                textcoords="offset points",
                fontsize=SMALL_PT,
            )
        return data_uri(figure, dpi)


def _half_power_deg(beam: Distribution) -> float | None:
    """Angle from the axis that holds half of the sum of signal times cell."""
    power = np.where(beam.measured, beam.signal * beam.solid_angle_sr, 0.0)
    order = np.argsort(beam.theta_deg)
    within = np.cumsum(power[order])
    if not len(within) or not within[-1] > 0:
        return None
    return float(beam.theta_deg[order][np.searchsorted(within, 0.5 * within[-1])])
