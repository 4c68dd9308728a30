"""effects.py: the systematic effects by name: what they are called in a budget, and how far one cause reaches."""

from dataclasses import dataclass
from typing import Literal

# How far two values share one error: everything this instrument ever measures; one session (one reference beam and what
# is measured with it); one mounting of the sample.
Reach = Literal["instrument", "session", "mount"]


@dataclass(frozen=True)
class Effect:
    """One line of the budget. `words` follow the terms of ASTM E2387 (Standard Practice for Goniometric Optical Scatter
    Measurements)."""

    name: str
    words: str
    reach: Reach


# Append only: the names are stored. "axis NAME" and "pose_time NAME" stand for one entry per axis, the latter also per
# channel.
EFFECTS = {
    effect.name: effect
    for effect in (
        Effect("dark", "signal: dark offset", "session"),
        Effect("gain_ratio", "signal: ratio of the gains", "instrument"),
        Effect("linearity", "signal: receiver linearity", "instrument"),
        Effect("lamp", "incident power: source drift not followed by the monitor", "session"),
        Effect("p_i", "incident power: P_i of the reference beam", "session"),
        Effect("distance", "receiver solid angle: distance", "instrument"),
        Effect("aperture", "receiver solid angle: aperture", "instrument"),
        Effect("axis", "scatter angle: zero of an axis", "instrument"),
        Effect("axis_second", "scatter angle: zero of an axis, second order", "instrument"),
        Effect("pose_time", "scatter angle: time of sample and position", "instrument"),
        Effect("tilt_x", "sample alignment: normal turned about x", "mount"),
        Effect("tilt_y", "sample alignment: normal turned about y", "mount"),
        Effect("tilt_second", "sample alignment: second order", "mount"),
        Effect("sample_offset", "sample alignment: front face off the centre", "mount"),
        Effect("stray_light", "background: stray light", "instrument"),
        Effect("stated", "systematic part as imported data state it", "instrument"),
        Effect("quadrature", "integration: finite number of points", "mount"),
        Effect("coverage", "integration: what was not measured", "mount"),
        Effect("ground", "separation: ground beneath the direct part", "mount"),
        Effect("smoothing", "deconvolution: what smoothing may hide", "mount"),
        Effect("independent", "noise of the points", "mount"),
        Effect("skirt", "incident power: skirt of the beam, outside the reference scan", "session"),
    )
}


def effect_of(key: str) -> Effect:
    """The effect that a stored key belongs to: keys are NAME, "NAME detail" (an axis, say) or either with " #SCOPE" at
    the end, where a merge has kept the causes of several sessions or mounts apart. Raises KeyError."""
    return EFFECTS[key.partition(" #")[0].partition(" ")[0]]
