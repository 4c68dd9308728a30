"""csv_points.py: writes the points of a dataset as one plain table, explained in comment lines."""

import csv
import io
from pathlib import Path

import numpy as np

from gonio.dataset.bsdf import Dataset, PointFlag
from gonio.formats import atomic
from gonio.units.errors import UsageError

HEADER = (
    "channel",
    "theta_i_deg",
    "phi_i_deg",
    "theta_s_deg",
    "phi_s_deg",
    "dsf_per_sr",
    "u_dsf_per_sr",
    "bsdf_per_sr",
    "solid_angle_sr",
    "count",
    "flags",
)


def write(dataset: Dataset, path: Path, *, channel: str | None = None) -> int:
    """Writes the points of all channels, or of one, and returns their number.

    A masked point has an empty value and its reasons in `flags`.
    `u_dsf_per_sr` is the standard uncertainty of the independent part; BSDF = DSF / |cos theta_s|, empty within
    0.001 degrees of grazing, where it is singular. The file is written whole or not at all. UsageError for a channel
    that is not there.
    """
    present = sorted({d.channel for d in dataset.distributions})
    if channel is not None and channel not in present:
        raise UsageError(f"no channel {channel!r} in the dataset; it has {', '.join(present)}")
    out = io.StringIO(newline="")
    out.write(f"# gonio points; sample: {_line(dataset.sample_name)}; front faces: {dataset.front_faces}\n")
    out.write(f"# polarisation: {dataset.polarisation}; symmetry: {dataset.symmetry} (as declared)\n")
    out.write("# theta from the front normal, 0-180; phi from +x towards +y; directions point away from the sample\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    total = 0
    for d in (d for d in dataset.distributions if channel in (None, d.channel)):
        cosine = np.abs(np.cos(np.radians(d.theta_deg)))
        singular = cosine < np.sin(np.radians(0.001))
        bsdf = np.divide(d.dsf_per_sr, cosine, out=np.full_like(cosine, np.nan), where=~singular)
        names = {int(flag): _names(int(flag)) for flag in np.unique(d.flags)}
        numbers = (d.theta_deg, d.phi_deg, d.dsf_per_sr, np.sqrt(d.variance_per_sr2), bsdf, d.solid_angle_sr)
        start = [d.channel, f"{d.incident_theta_deg:.6g}", f"{d.incident_phi_deg:.6g}"]
        columns = zip(*(column.tolist() for column in numbers), d.count.tolist(), d.flags.tolist(), strict=True)
        for theta, phi, dsf, u, b, cell, count, flags in columns:
            values = [_cell(dsf), _cell(u), _cell(b), _cell(cell)]
            writer.writerow([*start, f"{theta:.5f}", f"{phi:.5f}", *values, count, names[flags]])
        total += len(d.theta_deg)
    atomic.write_bytes(path, out.getvalue().encode("utf-8"))
    return total


def _cell(value: float) -> str:
    return f"{value:.9g}" if np.isfinite(value) else ""


def _names(flags: int) -> str:
    return "|".join(flag.name or "" for flag in PointFlag if flag and flags & flag).lower()


def _line(text: str) -> str:
    return " ".join(text.split())
