"""provenance.py: what a reduction records beside its results, so that it can be judged and repeated."""

from dataclasses import asdict
from typing import Any

import numpy as np
import scipy

from gonio.rawlog.reader import RawLog
from gonio.reduce.corrections.chain import Switches, recorded
from gonio.reduce.corrections.dark import Dark
from gonio.reduce.options import ReduceOptions
from gonio.reduce.power import Power
from gonio.reduce.samples.controller import controller_facts
from gonio.reduce.samples.flown import Flown, Losses
from gonio.reduce.samples.timeline import counted
from gonio.units.instrument import Instrument
from gonio.units.version import gonio_version


def provenance(
    rawlog: RawLog,
    instrument: Instrument,
    options: ReduceOptions,
    switches: Switches,
    found: tuple[Dark, Power, float, Losses],
    notes: list[str],
) -> dict[str, Any]:
    """Plain JSON. `found`: darks, P_i, shade angle in degrees, losses. With the raw logs of these hashes, the same
    options and versions, the reduction gives the same dataset."""
    dark, power, shade_deg, losses = found
    used: dict[str, dict[str, Any]] = {
        "dark": {
            "counts": dark.counts.mean(axis=0).tolist(),
            "counts_u": dark.u_counts.mean(axis=0).tolist(),
            "counts_per_c": dark.per_c.tolist(),
        },
        "lamp": {"reference_counts": power.scale.monitor_counts},
        "masks": {"shade_angle_deg": shade_deg},
    }
    return {
        "instrument_text": rawlog.metadata["instrument"],
        "corrections": recorded(switches, instrument, used, power.facts),
        "options": _recorded(options),
        "raw_sha256": list(rawlog.sha256s),
        "raw_problem": rawlog.problem,
        "counters": _counters(rawlog, losses),
        "notes": losses.notes + power.notes + notes,
        "noise": {
            "dark_counts_rms": [float(v) for v in np.sqrt(dark.variance_counts2)],
            "dark_counts": dark.counts.mean(axis=0).tolist(),
            "dark_counts_per_c": dark.per_c.tolist(),
            "shot_variance_per_count": power.scale.shot_per_count,
            "monitor_variance_rel": power.scale.monitor_variance_rel,
        },
        "beam": power.facts,
        "shade_angle_deg": shade_deg,
        **({"controller": facts} if (facts := controller_facts(rawlog, instrument)) else {}),
        "versions": {"gonio": gonio_version(), "numpy": np.__version__, "scipy": scipy.__version__},
        "scan": {key: value for key, value in rawlog.metadata.items() if key not in ("instrument", "unreachable")},
    }


def _recorded(options: ReduceOptions) -> dict[str, Any]:
    """What the result depends on: not where the calibration's text came from."""
    chosen = asdict(options) | {"without": list(options.without)}
    del chosen["calibration_name"]
    return chosen


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


def not_flown(metadata: dict[str, Any], flown: list[Flown]) -> list[str]:
    """Notes on planned paths that the log does not hold, or not to their end."""
    done = {path.path_id for path in flown if path.finished}
    begun = {path.path_id for path in flown}
    notes = []
    for entry in metadata.get("paths", ()):
        if entry["kind"] != "move" and entry["path_id"] not in done:
            how = "flown only in part" if entry["path_id"] in begun else "not flown"
            notes.append(f"path {entry['path_id']} ({entry.get('name', entry['kind'])}) was {how}")
    return notes
