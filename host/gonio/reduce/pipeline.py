"""pipeline.py: reduces a raw log to a dataset: corrections in order, cells, uncertainties, integrals."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution
from gonio.geometry.directions import angle_between_deg, angles_deg_from_unit, unit_from_angles_deg
from gonio.rawlog.reader import RawLog
from gonio.reduce.corrections.chain import Switches
from gonio.reduce.corrections.masks import shade_angle_deg
from gonio.reduce.coverage import cells_of_paths
from gonio.reduce.effects.columns import angles_of, effect_columns, pose_variance
from gonio.reduce.integrals.hemispheres import evaluated
from gonio.reduce.integrals.peaks import evaluated_peak, undersampled_note
from gonio.reduce.integrals.results import Results
from gonio.reduce.options import OtherBeam, ReduceOptions
from gonio.reduce.points import Points, binned, distribution_of, points_of, unreachable_points
from gonio.reduce.power import Power, power_of
from gonio.reduce.provenance import not_flown, provenance
from gonio.reduce.samples.flown import Flown, Losses, flown_paths
from gonio.units.errors import UsageError
from gonio.units.instrument import Instrument, override_calibration, parse_instrument

_WORKERS = 2  # more would cost memory: half a gigabyte each for a million samples


def reduce_rawlog(
    rawlog: RawLog,
    options: ReduceOptions | None = None,
    other: OtherBeam | None = None,
    ready: Callable[[Distribution], None] = lambda _: None,
) -> Dataset:
    """Reduce a raw log, all its segments joined; `other`: the free beam of another scan to normalise by. `ready` gets
    each distribution once its points are final, in any thread; what is left are integrals.

    Raises UsageError where it lacks what a BSDF needs: instrument, darks, P_i, or a single measured path.
    """
    options = options or ReduceOptions()
    metadata = rawlog.metadata
    text = metadata.get("instrument")
    if not text:
        raise UsageError("the raw log does not hold its instrument file: record it with gonio scan")
    instrument = parse_instrument(text, "instrument file in the raw log")
    if options.calibration_text:
        instrument = override_calibration(instrument, options.calibration_text, options.calibration_name)
    switches, losses = Switches.of(options.without), Losses()
    flown, dark = flown_paths(rawlog, instrument, losses, switches)
    power = power_of(flown, instrument, switches, options, other)
    measuring = [path for path in flown if path.kind != "reference"]
    directions = list(dict.fromkeys(path.incident_deg for path in measuring if path.incident_deg is not None))
    if not directions:
        raise UsageError("the raw log holds no sample of a coarse or peak path: nothing to reduce")
    stamps_us = rawlog.pose_sigma_us.astype(np.float64)
    known_us = stamps_us[np.isfinite(stamps_us)]
    shade_deg = shade_angle_deg(instrument, metadata.get("beam", {}))
    work = _Work(
        instrument,
        switches,
        options,
        power,
        shade_deg,
        float(np.sqrt(np.mean(known_us**2))) if len(known_us) else 0.0,
        metadata.get("unreachable", ()),
        ready,
    )

    def of_direction(incident_deg: tuple[float, float]) -> tuple[Distribution, list[str]]:
        return work.distribution([path for path in measuring if path.incident_deg == incident_deg], incident_deg)

    with ThreadPoolExecutor(_WORKERS) as workers:  # cells and fits, most of the work, run outside Python's lock
        found = list(workers.map(of_direction, directions))
    notes = [note for _, of_one in found for note in of_one] + not_flown(metadata, flown)
    sample = metadata.get("sample", {})
    thickness_mm = sample.get("thickness_mm")
    channel = str(metadata.get("channel", "visible"))
    return Dataset(
        distributions=[replace(distribution, channel=channel) for distribution, _ in found],
        sample_name=str(sample.get("name", "")),
        front_faces=sample.get("front_faces", "undeclared"),
        polarisation=sample.get("polarisation", "unknown"),
        symmetry=sample.get("symmetry", "undeclared"),
        thickness_mm=None if thickness_mm is None else float(thickness_mm),
        manufacturer=str(sample.get("manufacturer", "")),
        provenance=provenance(rawlog, instrument, options, switches, (dark, power, shade_deg, losses), notes),
        beam=power.distribution,
    )


@dataclass(frozen=True)
class _Work:
    """What all incident directions of a scan share."""

    instrument: Instrument
    switches: Switches
    options: ReduceOptions
    power: Power
    shade_deg: float
    stamp_u_us: float
    unreachable: Any  # the plan's entries
    ready: Callable[[Distribution], None]

    def distribution(self, own: list[Flown], incident_deg: tuple[float, float]) -> tuple[Distribution, list[str]]:
        """The distribution of one incident direction from its paths, and notes for the user."""
        # A path that was flown in two segments is one.
        paths = {path.path_id: path for path in own}
        numbers = {path_id: number for number, path_id in enumerate(paths)}
        points = self._points(own, numbers, incident_deg)
        covered = cells_of_paths(points.unit, points.path, self.options.reach_factor)
        distribution = replace(
            distribution_of(points, covered.solid_angle_sr, incident_deg, self.power.scale),
            linear_solid_angle_sr=covered.linear_sr,
            path=points.path,
            paths=tuple(path.name for path in paths.values()),
        )
        angles = angles_of(points, distribution, self.instrument)
        distribution.variance_per_sr2 += pose_variance(angles, self.stamp_u_us)
        distribution.effects = effect_columns(points, distribution, self.instrument, self.power.reference, angles)
        self.ready(distribution)
        flown_about = [(numbers[path_id], path.name) for path_id, path in paths.items() if path.kind == "peak"]
        with ThreadPoolExecutor(1) as beside:  # sums and fits ask nothing of each other
            sums = beside.submit(evaluated, distribution, beam=self.power.distribution)
            peaks = [_peak(distribution, points, number, name) for number, name in flown_about]
            sums.result().into(distribution)
        distribution.integrals |= _incidence(own, incident_deg)
        notes = []
        for results, of_peak in peaks:
            results.into(distribution)
            notes += of_peak
        return distribution, notes

    def _points(self, own: list[Flown], numbers: dict[int, int], incident_deg: tuple[float, float]) -> Points:
        scale, parts = self.power.scale, []
        for path in own:
            points = points_of(path, numbers[path.path_id], scale, self.instrument, self.switches, self.shade_deg)
            joined = self.options.bin_deg > 0.0 and path.kind == "coarse"
            parts.append(binned(points, self.options.bin_deg) if joined else points)
        return Points.joined([*parts, unreachable_points(self.unreachable, incident_deg, len(self.instrument.axes))])


def _incidence(own: list[Flown], incident_deg: tuple[float, float]) -> dict[str, float]:
    """Where the light came from, as the axes stood on the mean over all samples."""
    weights = [len(path.signal) for path in own]
    incident = np.average([path.incident for path in own], axis=0, weights=weights)
    theta_deg, phi_deg = angles_deg_from_unit(incident)
    off_deg = angle_between_deg(incident / np.linalg.norm(incident), unit_from_angles_deg(*incident_deg))
    return {
        "incident_measured_theta_deg": float(theta_deg),
        "incident_measured_phi_deg": float(phi_deg),
        "incident_off_plan_deg": float(off_deg),
    }


def _peak(distribution: Distribution, points: Points, number: int, name: str) -> tuple[Results, list[str]]:
    """Results of the peak that the path `number` was flown about, nothing where it has none; notes for the user."""
    # One piece: where a path was flown in two segments, nothing of this incident direction lies between them.
    own = np.flatnonzero(points.path == number)
    of_path = slice(int(own[0]), int(own[-1]) + 1)
    peak, results = evaluated_peak(distribution, of_path, name, points.unit)
    if peak is None:
        return Results(), []
    results.values |= {f"peak {name} first_point": float(of_path.start), f"peak {name} points": float(len(own))}
    return results, undersampled_note(name, peak)
