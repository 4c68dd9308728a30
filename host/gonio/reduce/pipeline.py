"""pipeline.py: reduces a raw log (or imported points) to a dataset: the corrections in order, and what they used."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import scipy

from gonio.dataset.bsdf import MASKED, Dataset, Distribution
from gonio.geometry.cells import covered_cells_sr
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.rawlog.reader import RawLog
from gonio.reduce.corrections.light import shot_variance_per_count, smooth_variance
from gonio.reduce.integrals.beam import Beam, measure_beam
from gonio.reduce.integrals.hemispheres import integrals
from gonio.reduce.integrals.peaks import measure_peak
from gonio.reduce.points import Points, Scale, binned, cells, distribution_of, points_of, unreachable_points
from gonio.reduce.samples.controller import controller_facts
from gonio.reduce.samples.flown import Flown, Losses, flown_paths
from gonio.reduce.samples.masks import shade_angle_deg
from gonio.reduce.samples.timeline import counted
from gonio.units.errors import UsageError
from gonio.units.instrument import parse_instrument
from gonio.units.version import gonio_version

CORRECTIONS = (
    "delays: light of a sample = strobe time less the channel's delay; position = SYNC echo plus the axis' latch delay",
    "pose: cubic through the four SYNC positions around the light",
    "dark: means with the shutter closed, linear in time, and over temperature where the darks tell",
    "gain: high channel, smoothly blended into the low one from 80 to 95 % of full scale",
    "lamp: divided by the monitor relative to its mean over the reference scan",
    "P_i: sum E Omega over the reference spiral; nothing subtracted but dark",
    "masks: shade of the detector's head, saturation, unreachable directions",
    "variance: noise measured in the dark plus shot noise and monitor noise estimated from the scan, as white noise",
)

_WORKERS = 2  # more would cost memory: half a gigabyte each for a million samples


@dataclass(frozen=True)
class ReduceOptions:
    """`bin_deg`: successive samples of the coarse pass are joined over so many degrees of track; 0: never."""

    bin_deg: float = 0.0


def reduce_rawlog(rawlog: RawLog, options: ReduceOptions | None = None) -> Dataset:
    """Reduce a raw log, all its segments joined. Raises UsageError where it lacks what a BSDF needs: instrument, darks,
    the free beam, or a single measured path."""
    options = options or ReduceOptions()
    metadata = rawlog.metadata
    text = metadata.get("instrument")
    if not text:
        raise UsageError("the raw log does not hold its instrument file: record it with gonio scan")
    instrument = parse_instrument(text, "instrument file in the raw log")
    losses = Losses()
    flown, dark = flown_paths(rawlog, instrument, losses)
    beam, beam_points, scale = _free_beam([path for path in flown if path.kind == "reference"], flown)
    shade_deg = shade_angle_deg(instrument, metadata.get("beam", {}))
    channel = str(metadata.get("channel", "visible"))
    measuring = [path for path in flown if path.kind != "reference"]
    directions = list(dict.fromkeys(path.incident_deg for path in measuring if path.incident_deg is not None))
    if not directions:
        raise UsageError("the raw log holds no sample of a coarse or peak path: nothing to reduce")
    unreachable = metadata.get("unreachable", ())

    def of_direction(incident_deg: tuple[float, float]) -> Distribution:
        own = [path for path in measuring if path.incident_deg == incident_deg]
        return _distribution(own, incident_deg, scale, shade_deg, (unreachable, options))

    with ThreadPoolExecutor(_WORKERS) as workers:  # the convex hulls, most of the work, run outside Python's lock
        distributions = list(workers.map(of_direction, directions))
    for distribution in distributions:
        distribution.channel = channel
    sample = metadata.get("sample", {})
    thickness_mm = sample.get("thickness_mm")
    return Dataset(
        distributions=distributions,
        sample_name=str(sample.get("name", "")),
        front_faces=sample.get("front_faces", "undeclared"),
        polarisation=sample.get("polarisation", "unknown"),
        symmetry=sample.get("symmetry", "undeclared"),
        thickness_mm=None if thickness_mm is None else float(thickness_mm),
        manufacturer=str(sample.get("manufacturer", "")),
        provenance={
            "instrument_text": text,
            "corrections": list(CORRECTIONS),
            "options": asdict(options),
            "raw_sha256": list(rawlog.sha256s),
            "raw_problem": rawlog.problem,
            "counters": _counters(rawlog, losses),
            "notes": losses.notes + beam.notes() + _not_flown(metadata, flown),
            "noise": {
                "dark_counts_rms": [float(v) for v in np.sqrt(dark.variance_counts2)],
                "dark_counts": dark.counts.mean(axis=0).tolist(),
                "dark_counts_per_c": dark.per_c.tolist(),
                "shot_variance_per_count": scale.shot_per_count,
                "monitor_variance_rel": scale.monitor_variance_rel,
            },
            "shade_angle_deg": shade_deg,
            **({"controller": facts} if (facts := controller_facts(rawlog, instrument)) else {}),
            "versions": {"gonio": gonio_version(), "numpy": np.__version__, "scipy": scipy.__version__},
            "scan": {key: value for key, value in metadata.items() if key not in ("instrument", "unreachable")},
        },
        beam=_beam_distribution(beam, beam_points, scale),
    )


def reduce_dataset(dataset: Dataset) -> Dataset:
    """Cells and integrals for points that were not flown here (imported). The DSF stays as it is; cells end where the
    points do. Points that have cells (reduced, simulated) are left alone, with all that was found in them."""
    if all(distribution.solid_angle_sr.any() for distribution in dataset.distributions):
        return dataset
    distributions = []
    for distribution in dataset.distributions:
        unit = unit_from_angles_deg(distribution.theta_deg, distribution.phi_deg)
        omega, moment = covered_cells_sr(unit)
        with_cells = replace(distribution, solid_angle_sr=omega)
        with_cells.integrals = integrals(with_cells, np.abs(moment[:, 2]))
        distributions.append(with_cells)
    steps = [*dataset.provenance.get("corrections", []), "cells and integrals of the points as imported"]
    return replace(dataset, distributions=distributions, provenance={**dataset.provenance, "corrections": steps})


def _free_beam(reference: list[Flown], flown: list[Flown]) -> tuple[Beam, Points, Scale]:
    if not reference:
        raise UsageError("the raw log holds no reference scan of the free beam: P_i is unknown; plan a [reference]")
    monitor = np.concatenate([path.monitor_counts for path in reference])
    mean_monitor = float(monitor.mean())
    if not mean_monitor > 0.0:
        raise UsageError(
            f"the lamp monitor reads {mean_monitor:g} counts in the reference scan: check lamp and monitor"
        )
    shot = shot_variance_per_count(
        np.concatenate([path.signal for path in flown]),
        np.concatenate([path.dark_variance for path in flown]),
        np.concatenate([np.arange(len(path.signal)) > 0 for path in flown]),
    )
    monitor_variance = float(np.median(smooth_variance(monitor))) / 0.4549 if len(monitor) > 100 else 0.0
    scale = Scale(mean_monitor, 1.0, 0.0, shot, monitor_variance / mean_monitor**2)
    points = Points.joined([points_of(path, number, scale, None) for number, path in enumerate(reference)])
    beam = measure_beam(
        np.concatenate([path.detector_lab for path in reference]),
        points.signal / points.normalisation,
        points.variance / points.normalisation**2,
        points.flags & MASKED == 0,
    )
    if not beam.p_i > 0.0:
        raise UsageError(f"P_i is {beam.p_i:g}: the reference scan saw no light; check shutter, lamp and beam")
    return beam, points, replace(scale, p_i=beam.p_i, p_i_u_rel=beam.p_i_u_rel)


def _distribution(
    own: list[Flown],
    incident_deg: tuple[float, float],
    scale: Scale,
    shade_deg: float,
    plan: tuple[Any, ReduceOptions],
) -> Distribution:
    unreachable, options = plan
    parts = []
    # A path that was flown in two segments is one.
    paths = {path.path_id: path for path in own}
    numbers = {path_id: number for number, path_id in enumerate(paths)}
    for path in own:
        points = points_of(path, numbers[path.path_id], scale, shade_deg)
        parts.append(binned(points, options.bin_deg) if options.bin_deg > 0.0 and path.kind == "coarse" else points)
    points = Points.joined([*parts, unreachable_points(unreachable, incident_deg)])
    omega = cells(points, [path.kind for path in paths.values()])
    distribution = distribution_of(points, omega, incident_deg, scale)
    distribution.integrals = integrals(distribution)
    incident = np.concatenate([path.incident for path in own]).mean(axis=0)
    theta_deg, phi_deg = angles_deg_from_unit(incident)
    off_deg = angle_between_deg(incident / np.linalg.norm(incident), unit_from_angles_deg(*incident_deg))
    distribution.integrals |= {
        "incident_measured_theta_deg": float(theta_deg),
        "incident_measured_phi_deg": float(phi_deg),
        "incident_off_plan_deg": float(off_deg),
    }
    for path_id, path in paths.items():
        if path.kind != "peak":
            continue
        # One piece: where a path was flown in two segments, nothing of this incident direction lies between them.
        own_points = np.flatnonzero(points.path == numbers[path_id])
        of_path = slice(int(own_points[0]), int(own_points[-1]) + 1)
        peak = measure_peak(points.unit[of_path], distribution.dsf_per_sr[of_path], distribution.measured[of_path])
        if peak is not None:
            distribution.integrals |= peak.named(path.name)
            distribution.integrals |= {
                f"peak {path.name} first_point": float(of_path.start),
                f"peak {path.name} points": float(len(own_points)),
            }
    return distribution


def _beam_distribution(beam: Beam, points: Points, scale: Scale) -> Distribution:
    found = distribution_of(points, beam.solid_angle_sr, (0.0, 0.0), scale)
    centroid = {"centroid_x_deg": beam.centroid_x_deg, "centroid_y_deg": beam.centroid_y_deg}
    return replace(found, theta_deg=beam.polar_deg, phi_deg=beam.azimuth_deg, integrals=centroid)


def _counters(rawlog: RawLog, losses: Losses) -> dict[str, int]:
    """The firmware's counters, added up over segments, and the reduction's own."""
    total: dict[str, int] = {}
    for segment in range(max(rawlog.event_segment, default=-1) + 1):
        events = [e for e, of in zip(rawlog.events, rawlog.event_segment, strict=True) if of == segment]
        for name, value in counted(events, int(rawlog.time_origin_ns[segment])).items():
            total[name] = total.get(name, 0) + value
    total["points_pose_lost"] = losses.pose_lost
    total["points_clock_unsettled"] = losses.clock_unsettled
    return total


def _not_flown(metadata: dict[str, Any], flown: list[Flown]) -> list[str]:
    """Planned paths that the log does not hold, or not to their end."""
    done = {path.path_id for path in flown if path.finished}
    begun = {path.path_id for path in flown}
    notes = []
    for entry in metadata.get("paths", ()):
        if entry["kind"] != "move" and entry["path_id"] not in done:
            how = "flown only in part" if entry["path_id"] in begun else "not flown"
            notes.append(f"path {entry['path_id']} ({entry.get('name', entry['kind'])}) was {how}")
    return notes
