"""csv_write.py: writes the points of a dataset as one plain table, explained in comment lines (csv_read.py reads)."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gonio.dataset.bsdf import Dataset, Distribution, PointFlag
from gonio.dataset.uncertainty import combined_u_per_sr
from gonio.formats import atomic
from gonio.formats.pab.raw_signal import refuse_raw
from gonio.formats.text_numbers import shortest
from gonio.units.errors import UsageError

HEADER = (
    "channel",
    "theta_i_deg",
    "phi_i_deg",
    "theta_s_deg",
    "phi_s_deg",
    "dsf_per_sr",
    "u_dsf_per_sr",
    "u_combined_per_sr",
    "bsdf_per_sr",
    "solid_angle_sr",
    "count",
    "flags",
)
UNCERTAINTY = ("u_dsf_per_sr", "u_combined_per_sr")
HORIZON_DEG = 0.001  # nearer to it a BSDF is singular
# Comment lines that hold the dataset's own fields.
FIELDS = ("sample_name", "front_faces", "polarisation", "symmetry", "manufacturer")


def write(dataset: Dataset, path: Path, *, channel: str | None = None) -> int:
    """Writes the points of all channels, or of one, and returns their number.

    Directions, DSF and solid angles are written with all digits of the float64, so that they read back the same.
    `u_dsf_per_sr` is the standard uncertainty of the independent part, `u_combined_per_sr` of independent and
    systematic parts together (k = 1), of one point: systematic parts move all points together. BSDF = DSF /
    |cos theta_s|, empty within HORIZON_DEG of grazing, where it is singular. A masked point has empty values and its
    reasons in `flags`. Where no uncertainty of any point is known, as of a model's, its columns are left away. The file
    is written whole or not at all. UsageError for a channel that is not there and for points that are not normalised.
    """
    present = sorted({d.channel for d in dataset.distributions})
    if channel is not None and channel not in present:
        raise UsageError(f"no channel {channel!r} in the dataset; it has {', '.join(present)}")
    chosen = [d for d in dataset.distributions if channel in (None, d.channel)]
    refuse_raw(chosen)
    out = io.StringIO(newline="")
    out.write("# gonio points\n")
    for name in FIELDS:
        out.write(f"# {name}: {_line(getattr(dataset, name))}\n")
    if dataset.thickness_mm is not None:
        out.write(f"# thickness_mm: {dataset.thickness_mm!r}\n")
    wavelengths = {d.channel: d.wavelength_nm for d in chosen if d.wavelength_nm is not None}
    for name, wavelength_nm in wavelengths.items():
        out.write(f"# wavelength_nm: {wavelength_nm!r} {_line(name)}\n")
    out.write("# theta from the front normal, 0-180; phi from +x towards +y; directions point away from the sample\n")
    writer = csv.writer(out, lineterminator="\n")
    known = any(np.isfinite(d.variance_per_sr2).any() for d in chosen)
    writer.writerow([name for name in HEADER if known or name not in UNCERTAINTY])
    for d in chosen:
        writer.writerows(_rows(d, known=known))
    atomic.write_bytes(path, out.getvalue().encode("utf-8"))
    return sum(len(d.theta_deg) for d in chosen)


def _rows(d: Distribution, *, known: bool) -> Iterator[list[Any]]:
    """Cells of each point; of its uncertainty where it is `known`."""
    cosine = np.abs(np.cos(np.radians(d.theta_deg)))
    singular = cosine < np.sin(np.radians(HORIZON_DEG))
    bsdf = np.divide(d.dsf_per_sr, cosine, out=np.full_like(cosine, np.nan), where=~singular)
    names = {int(flag): _names(int(flag)) for flag in np.unique(d.flags)}
    uncertainty = (np.sqrt(d.variance_per_sr2), combined_u_per_sr(d)) if known else ()
    columns = (
        shortest(d.theta_deg),
        shortest(d.phi_deg),
        _cells(shortest(d.dsf_per_sr)),
        *(_cells(_twelve_digits(u)) for u in uncertainty),
        _cells(_twelve_digits(bsdf)),
        shortest(d.solid_angle_sr),
        d.count.tolist(),
        [names[flags] for flags in d.flags.tolist()],
    )
    start = [d.channel, *shortest(np.array([d.incident_theta_deg, d.incident_phi_deg]))]
    return ([*start, *row] for row in zip(*columns, strict=True))


def _twelve_digits(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[str]:
    """What is derived from the other columns: fewer digits, so that deriving it again gives the same text."""
    return [f"{value:.12g}" for value in values.tolist()]


def _cells(texts: list[str]) -> list[str]:
    return ["" if text == "nan" else text for text in texts]


def _names(flags: int) -> str:
    return "|".join(flag.name or "" for flag in PointFlag if flag and flags & flag).lower()


def _line(text: str) -> str:
    return " ".join(text.split())
