"""power.py: P_i of a scan, by its own reference scan, another one's, or as declared, and the scan's noise."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gonio.dataset.bsdf import MASKED, Distribution
from gonio.reduce.corrections import lamp
from gonio.reduce.corrections.chain import Switches
from gonio.reduce.corrections.noise import shot_variance_per_count, smooth_variance
from gonio.reduce.effects.power import ReferenceBeam, reference_beam
from gonio.reduce.effects.signal import Level
from gonio.reduce.integrals.beam import Beam, measure_beam
from gonio.reduce.integrals.closure import closure
from gonio.reduce.options import OtherBeam, ReduceOptions
from gonio.reduce.points import Points, Scale, distribution_of, points_of
from gonio.reduce.samples.flown import Flown
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument

_MEDIAN_CHI2 = 0.4549  # of one degree of freedom


@dataclass
class Power:
    """What normalises a scan. `facts` go into the provenance: what, p_i, p_i_u_rel, monitor_counts, level."""

    scale: Scale
    reference: ReferenceBeam
    facts: dict[str, Any]
    distribution: Distribution | None = None  # the free beam
    notes: list[str] = field(default_factory=list)


def power_of(
    flown: Sequence[Flown],
    instrument: Instrument,
    switches: Switches,
    options: ReduceOptions,
    other: OtherBeam | None,
) -> Power:
    """What the user names goes before the scan's own reference scan. Raises UsageError where there is neither, or no
    light in it."""
    reference = [path for path in flown if path.kind == "reference"]
    if options.p_i is not None and other is not None:
        raise UsageError("--p-i and --beam both say what P_i is: give one of them")
    if options.p_i is None and other is None and not reference:
        raise UsageError(
            "the raw log holds no reference scan of the free beam: P_i is unknown; plan a [reference], or give it with "
            "--p-i VALUE (counts*sr) or --beam OTHER.h5"
        )
    monitored = reference or list(flown)
    monitor = np.concatenate([path.monitor_counts for path in monitored])
    mean_monitor = float(monitor.mean())
    if switches.on(lamp.NAME) and not mean_monitor > 0.0:
        where = "reference scan" if reference else "scan"
        raise UsageError(f"the lamp monitor reads {mean_monitor:g} counts in the {where}: check lamp and monitor")
    shot = shot_variance_per_count(
        np.concatenate([path.signal for path in flown]),
        np.concatenate([path.dark_variance for path in flown]),
        np.concatenate([np.arange(len(path.signal)) > 0 for path in flown]),
    )
    monitor_variance = float(np.median(smooth_variance(monitor))) / _MEDIAN_CHI2 if len(monitor) > 100 else 0.0
    noise_rel = monitor_variance / mean_monitor**2 if switches.on(lamp.NAME) else 0.0
    scale = Scale(mean_monitor, 1.0, 0.0, shot, noise_rel)
    if options.p_i is not None:
        found = _declared(options.p_i, options.p_i_u, scale)
    elif other is not None:
        found = _of_other(other, scale)
    else:
        return _measured(reference, scale, instrument, switches)
    if reference:
        found.notes.append("the scan has a reference scan of its own, which was not used")
    return found


def _declared(p_i: float, p_i_u: float, scale: Scale) -> Power:
    # Nothing is known of the level at which it was measured: errors of gain and linearity count in full.
    level = Level(np.zeros(1), np.zeros(1))
    facts = {"what": "P_i as declared", "p_i": p_i, "p_i_u_rel": p_i_u / p_i, "monitor_counts": scale.monitor_counts}
    return Power(
        replace(scale, p_i=p_i, p_i_u_rel=p_i_u / p_i),
        ReferenceBeam(p_i, p_i_u / p_i, level),
        _with_level(facts, level),
    )


def _of_other(other: OtherBeam, scale: Scale) -> Power:
    try:
        p_i, p_i_u_rel, monitor, high, full = (
            float(other.facts[key])
            for key in ("p_i", "p_i_u_rel", "monitor_counts", "level_high_share", "level_of_full_scale")
        )
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(
            f"{other.name}: holds no free beam that another scan can use; give a dataset that gonio reduce made of a "
            "scan with a reference scan"
        ) from error
    level = Level(np.array([high]), np.array([full]))
    facts = {
        "what": f"P_i of the reference scan in {other.name}",
        "p_i": p_i,
        "p_i_u_rel": p_i_u_rel,
        "monitor_counts": monitor,
    }
    scale = replace(scale, monitor_counts=monitor, p_i=p_i, p_i_u_rel=p_i_u_rel)
    return Power(scale, ReferenceBeam(p_i, p_i_u_rel, level), _with_level(facts, level))


def _measured(reference: list[Flown], scale: Scale, instrument: Instrument, switches: Switches) -> Power:
    points = Points.joined(
        [points_of(path, number, scale, instrument, switches, None) for number, path in enumerate(reference)]
    )
    beam = measure_beam(
        points.unit,
        points.signal / points.normalisation,
        points.variance / points.normalisation**2,
        points.flags & MASKED == 0,
        points.path,
    )
    if not beam.p_i > 0.0:
        raise UsageError(f"P_i is {beam.p_i:g}: the reference scan saw no light; check shutter, lamp and beam")
    known = reference_beam(points, beam.solid_angle_sr, beam.p_i_u_rel, instrument)
    scale = replace(scale, p_i=beam.p_i, p_i_u_rel=known.p_i_u_rel)
    facts = {
        "what": "P_i = integral of E over the reference scan; nothing subtracted but dark",
        "p_i": beam.p_i,
        "p_i_u_rel": known.p_i_u_rel,
        "monitor_counts": scale.monitor_counts,
    }
    names = tuple(path.name for path in reference)
    distribution = _beam_distribution(beam, points, scale, names)
    return Power(scale, known, _with_level(facts, known.level), distribution, beam.notes())


def _with_level(facts: dict[str, Any], level: Level) -> dict[str, Any]:
    high, full = float(level.high_share[0]), float(level.of_full_scale[0])
    return facts | {"level_high_share": high, "level_of_full_scale": full}


def _beam_distribution(beam: Beam, points: Points, scale: Scale, names: tuple[str, ...]) -> Distribution:
    found = replace(
        distribution_of(points, beam.solid_angle_sr, (0.0, 0.0), scale),
        theta_deg=beam.polar_deg,
        phi_deg=beam.azimuth_deg,
        linear_solid_angle_sr=beam.linear_sr,
        path=points.path,
        paths=names,
    )
    results = beam.results()
    results.put("closure", closure(found))
    results.into(found)
    return found
