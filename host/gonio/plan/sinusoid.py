"""sinusoid.py: all axes on sinusoids of different phase, to measure how well samples are paired with positions."""

import numpy as np

from gonio.geometry.kinematics import Kinematics
from gonio.plan.knots import AxisMotion, pack
from gonio.plan.limits import require_allowed
from gonio.plan.moves import move
from gonio.plan.profiles import speed_up
from gonio.plan.program import DarkStep, PathStep, Program, ShutterStep
from gonio.units.instrument import Instrument

_KNOT_S = 0.05
_RAMP_S = 8.0  # the rate of path time then changes by 0.23/s at most, less than a feed hold


def sinusoid_motion(
    instrument: Instrument, amplitude_deg: float, peak_speed_deg_per_s: float, duration_s: float
) -> AxisMotion:
    """Every axis about the middle of its range: A sin(w s + phase), with path time s speeding up at the start and down
    at the end; phases and, slightly, frequencies differ, and no axis exceeds the peak speed."""
    count = len(instrument.axes)
    knots = int(np.ceil(duration_s / _KNOT_S))
    time = np.linspace(0.0, duration_s, knots + 1, dtype=np.float64)
    rising = time <= 0.5 * duration_s
    law, rate, bend = speed_up(np.where(rising, time, duration_s - time), _RAMP_S)
    whole = duration_s - _RAMP_S
    s, bend = np.where(rising, law, whole - law), np.where(rising, bend, -bend)

    w = peak_speed_deg_per_s / amplitude_deg * (1.0 - 0.07 * np.arange(count))
    angle = w * s[:, None] + np.arange(count) * (np.pi / count) + 0.3
    middle = np.array([0.5 * (axis.min_deg + axis.max_deg) for axis in instrument.axes])
    slope = amplitude_deg * w * np.cos(angle)
    curvature = -amplitude_deg * w**2 * np.sin(angle)
    return AxisMotion(
        time,
        middle + amplitude_deg * np.sin(angle),
        slope * rate[:, None],
        curvature * (rate**2)[:, None] + slope * bend[:, None],
    )


def sinusoid_program(
    instrument: Instrument,
    amplitude_deg: float,
    peak_speed_deg_per_s: float,
    duration_s: float,
    dark_s: float = 1.0,
) -> Program:
    """Move to the start, dark, then the sinusoids with the shutter open. Raises UsageError if an axis cannot."""
    motion = sinusoid_motion(instrument, amplitude_deg, peak_speed_deg_per_s, duration_s)
    knots = pack(motion, instrument)
    require_allowed(knots, instrument, Kinematics(instrument.axes), "sinusoid")
    home = np.clip(np.zeros(len(instrument.axes)), *np.array([(a.min_deg, a.max_deg) for a in instrument.axes]).T)
    lead_in = move(home, motion.q_deg[0], instrument, "move to sinusoid")
    return Program(
        steps=[
            ShutterStep(open=False),
            PathStep(1, "move", "move to sinusoid", lead_in),
            DarkStep(dark_s),
            ShutterStep(open=True),
            PathStep(2, "coarse", "sinusoid", knots),
            ShutterStep(open=False),
        ],
        instrument=instrument,
    )
